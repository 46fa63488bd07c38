//! The drive firmware on an emulated chip, whose pins, encoder and flash are memory. An emulated servo is at its
//! output. The tests are requests, runs, records, faults and commissionings from end to end.

use std::error::Error;
use std::fmt::Debug;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use commissioning::{CommissionSettings, Limits, Phase};
use drive_link::{
    BootChecks, Command, Commissioning, Ended, Estimator, Fault, Kept, LoopSettings, Origin,
    Refusal, Report, Snapshot, State,
};
use identifier_core::tuning::Goal;
use servo_id::drive::{AtEnd, Client, DriveError, Driven};

use crate::{emulator, firmware, seal};

/// Time limit of the emulator for half a minute of the drive.
const TIME_LIMIT: Duration = Duration::from_secs(300);

/// Operates the drive as a host does, and as a broken line does.
pub(crate) fn check() -> Result<(), String> {
    let program = firmware::emulated_drive()?;
    let (_running, port) = emulator::Running::start(&program, &[])?;
    operate(&mut Driven::new(Client::new(port), 0.0, AtEnd::Leave))
        .map_err(|error| error.to_string())?;
    refuse_damage(&program).map_err(|error| error.to_string())
}

/// Boots a drive whose program does not fit its seal.
fn refuse_damage(program: &Path) -> Result<(), Box<dyn Error>> {
    let damaged = seal::damaged(program)?;
    let (_running, port) = emulator::Running::start(&damaged, &[])?;
    let status = Client::new(port).status()?;
    let fault = Fault::ImageDamaged;
    expect("a damaged program", status.state, State::Faulted(fault))?;
    println!("{fault}");
    Ok(())
}

fn operate(drive: &mut Driven) -> Result<(), Box<dyn Error>> {
    let status = drive.status()?;
    expect("state after the boot", status.state, State::Disabled)?;
    expect("configured", status.configured, false)?;
    expect("the boot", status.boot, BootChecks::PASSED)?;
    let test = drive.board_test()?;
    expect("the board", test.board.as_str(), emulator::BOARD)?;
    let (here, _) = drive_logic::self_test("", || 0);
    expect("the bits", test.bits, here.bits)?;
    // The emulator has no cycle counter.
    expect("cycles of a sample", test.cycles, None)?;
    expect("cycles of an interrupt", status.interrupt_cycles, None)?;
    println!("the chip computes the bits of this machine");
    let refused = refusal(drive, Command::Start)?;
    expect("a start of a new drive", refused, Refusal::NotConfigured)?;
    expect("the store at first", status.kept, Kept::Nothing)?;
    // More than fit into both of the emulated sectors, which are then erased in turn.
    for _ in 0..20 {
        drive.ask(Command::Save)?;
    }
    expect("the store then", drive.status()?.kept, Kept::Record)?;
    println!("records are kept");

    // Garbage of every kind: the drive answers the next request.
    let mut garbage = 0x2545_f491_u32;
    for length in [1_u32, 7, 300, 2000, 5000] {
        let bytes: Vec<u8> = (0..length)
            .map(|_| {
                garbage ^= garbage << 13;
                garbage ^= garbage >> 17;
                garbage ^= garbage << 5;
                garbage as u8
            })
            .chain([0])
            .collect();
        drive.port().write_raw(&bytes)?;
        expect(
            "state after garbage",
            drive.status()?.state,
            State::Disabled,
        )?;
    }
    if drive.status()?.garbled == 0 {
        return Err("garbage was taken for frames".into());
    }
    println!("the drive boots, and recovers from garbage on its line");

    let settings = drive.settings()?;
    let mut wrong = settings;
    let controller = &mut wrong.closed_loop.core.controller;
    controller.as_mut().ok_or("the drive has no controller")?.kp = 1.0;
    match refusal(drive, Command::Configure(wrong))? {
        Refusal::Setting(refused) => println!("refused as it should be: {refused}"),
        other => return Err(format!("kp = 1 is refused, but because {other}").into()),
    }
    let mut crooked = settings;
    crooked.closed_loop.core.sample_time = 1.25e-4;
    match refusal(drive, Command::Configure(crooked))? {
        Refusal::Setting(refused) => println!("refused as it should be: {refused}"),
        other => return Err(format!("2.5 periods are refused, but because {other}").into()),
    }
    expect("the settings after that", drive.settings()?, settings)?;

    for law in [
        Estimator::Gradient { friction: true },
        Estimator::GaussNewton,
    ] {
        let mut wanted = settings;
        wanted.closed_loop.law = law;
        wanted.protection.link_timeout = 0.0;
        drive.ask(Command::Configure(wanted))?;
        drive.ask(Command::Watch(100))?;
        drive.ask(Command::Start)?;
        expect("the first sample shown", drive.next(shown)?.sample, 1)?;
        expect("the next of them", drive.next(shown)?.sample, 101)?;
        let refused = refusal(drive, Command::Save)?;
        expect("a record in motion", refused, Refusal::Running)?;
        let learnt = drive
            .next_within(TIME_LIMIT, |report| {
                shown(report).filter(|shown| shown.sample > 30_000)
            })?
            .ok_or("the drive has not run for 30 s")?;
        let b = learnt.estimates.servo.b;
        if !(250.0..266.0).contains(&b) {
            return Err(format!("{law:?}: b is {b} where the servo has 257.7").into());
        }
        drive.stop()?;
        let status = drive.status()?;
        expect("how it ended", status.ended, Some(Ended::Stopped))?;
        expect("late samples", status.overruns, 0)?;
        println!("{law:?}: b {b:.1} after 30 s, stopped");
    }
    drive.ask(Command::Save)?;

    let mut tight = settings;
    tight.protection.duration = 0.5;
    tight.protection.link_timeout = 0.0;
    drive.ask(Command::Configure(tight))?;
    drive.ask(Command::Start)?;
    until(drive, State::Disabled)?;
    let ended = drive.status()?.ended;
    expect("the end of a run of 0.5 s", ended, Some(Ended::Over))?;
    println!("a run ends when its time is over");

    // The drive's second is a fraction of the host's, which soon exceeds the timeout.
    tight.protection.duration = 0.0;
    tight.protection.link_timeout = 0.1;
    drive.ask(Command::Configure(tight))?;
    drive.ask(Command::Start)?;
    let fault = drive.next(injected)?;
    expect("the fault of a silent host", fault, Fault::LinkLost)?;
    expect(
        "the state then",
        drive.status()?.state,
        State::Faulted(fault),
    )?;
    let refused = refusal(drive, Command::Start)?;
    expect("a start in spite of it", refused, Refusal::Faulted(fault))?;
    println!("{fault}");
    drive.ask(Command::Clear)?;
    until(drive, State::Disabled)?;
    println!("cleared, and ready again");
    tight.protection.link_timeout = 0.0;
    drive.ask(Command::Configure(tight))?;
    commission(drive, &tight.closed_loop)
}

/// Commissions the drive, and starts a run with the gains found.
fn commission(drive: &mut Driven, closed_loop: &LoopSettings) -> Result<(), Box<dyn Error>> {
    let order = CommissionSettings {
        goal: Goal::Bandwidth(40.0),
        ..CommissionSettings::new(
            closed_loop.core.sample_time,
            closed_loop.core.resolution,
            Limits::new([-1.5, 1.5], 40.0, [-10.0, 10.0]),
        )
    };
    drive.commission(&order)?;
    until(drive, State::Disabled)?;
    let outcome = drive.outcome()?;
    let applied = Commissioning {
        phase: Phase::Applied,
        reason: None,
    };
    expect("the commissioning", outcome.commissioning, applied)?;
    expect("whether it is kept", outcome.kept, true)?;
    let status = drive.status()?;
    expect("late samples", status.overruns, 0)?;
    let origin = status.gains.map(|gains| gains.origin);
    expect("the gains", origin, Some(Origin::Commissioned))?;
    let b = outcome.servo.map_or(0.0, |servo| servo.parameters.b);
    if !(252.5..263.0).contains(&b) {
        return Err(format!("b is {b} where the servo has 257.7").into());
    }
    drive.ask(Command::Start)?;
    expect("a start", drive.status()?.state, State::Running)?;
    drive.stop()?;
    println!("commissioned: b {b:.1}, and the gains are kept");
    commission_beside(drive, &order)
}

/// Commissions beside the running loop, which resumes.
fn commission_beside(drive: &mut Driven, order: &CommissionSettings) -> Result<(), Box<dyn Error>> {
    drive.ask(Command::Start)?;
    drive.commission(order)?;
    until(drive, State::Running)?;
    let outcome = drive.outcome()?;
    let phase = outcome.commissioning.phase;
    expect("the commissioning beside a loop", phase, Phase::Applied)?;
    expect("whether it is kept in motion", outcome.kept, false)?;
    drive.ask(Command::Watch(100))?;
    let b = drive.next(shown)?.estimates.servo.b;
    if !(252.5..263.0).contains(&b) {
        return Err(format!("the loop resumes with b = {b} where the servo has 257.7").into());
    }
    expect("late samples", drive.status()?.overruns, 0)?;
    drive.stop()?;
    expect("whether it is kept then", drive.outcome()?.kept, true)?;
    println!("commissioned beside a loop, which resumes with b {b:.1}");
    Ok(())
}

fn shown(report: &Report) -> Option<Snapshot> {
    match report {
        Report::Snapshot(snapshot) => Some(*snapshot),
        _ => None,
    }
}

fn injected(report: &Report) -> Option<Fault> {
    match report {
        Report::Fault(fault) => Some(*fault),
        _ => None,
    }
}

/// Waits until the drive is in a state.
fn until(drive: &mut Driven, wanted: State) -> Result<(), Box<dyn Error>> {
    let begun = Instant::now();
    while begun.elapsed() < TIME_LIMIT {
        if drive.status()?.state == wanted {
            return Ok(());
        }
        thread::sleep(Duration::from_millis(20));
    }
    Err(format!("the drive does not become {wanted:?}").into())
}

/// The drive's reason for refusing a command.
fn refusal(drive: &mut Driven, command: Command) -> Result<Refusal, Box<dyn Error>> {
    match drive.ask(command) {
        Err(DriveError::Refused(refusal)) => Ok(refusal),
        Err(other) => Err(other.into()),
        Ok(()) => Err(format!("{command:?} was not refused").into()),
    }
}

fn expect<T: PartialEq + Debug>(what: &str, found: T, wanted: T) -> Result<(), Box<dyn Error>> {
    if found == wanted {
        Ok(())
    } else {
        Err(format!("{what}: {found:?} instead of {wanted:?}").into())
    }
}
