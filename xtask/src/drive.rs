//! The drive firmware on an emulated chip, whose pins, encoder and flash are memory: the whole way of
//! a request, a record and a fault, with a servo that stands still.

use std::error::Error;
use std::fmt::Debug;

use drive_link::{Command, Fault, Kept, Law, PROTOCOL, Refusal, Report, Snapshot, State};
use host_sim::drive::{Client, DriveError};

use crate::{emulator, firmware};

/// Talks to the drive as a host would, and as a broken line does.
pub(crate) fn check() -> Result<(), String> {
    firmware::build(&["emulator"])?;
    let (_running, port) = emulator::Running::start(&firmware::path("drive"))?;
    talk(&mut Client::new(port)).map_err(|error| error.to_string())
}

fn talk(drive: &mut Client) -> Result<(), Box<dyn Error>> {
    let status = drive.status()?;
    expect("protocol", status.protocol, PROTOCOL)?;
    expect("state after the boot", status.state, State::Released)?;
    expect("what the store holds", status.kept, Kept::Nothing)?;
    // More than fit into both of the emulated sectors, which are then erased in turn.
    for _ in 0..20 {
        drive.ask(Command::Save)?;
    }
    expect("what it holds then", drive.status()?.kept, Kept::Record)?;
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
        drive.port().say(&bytes)?;
        expect(
            "state after garbage",
            drive.status()?.state,
            State::Released,
        )?;
    }
    if drive.status()?.garbled == 0 {
        return Err("garbage was taken for frames".into());
    }
    println!("the drive boots, and garbage on its line costs nothing but itself");

    let settings = drive.settings()?;
    let mut wrong = settings;
    let controller = &mut wrong.closed_loop.core.controller;
    controller.as_mut().ok_or("the drive has no controller")?.kp = 1.0;
    match refusal(drive, Command::Configure(wrong))? {
        Refusal::Setting(refused) => println!("refused as it should be: {refused}"),
        other => return Err(format!("kp = 1 is refused, but because {other}").into()),
    }
    let mut short = settings;
    short.closed_loop.law = Law::GaussNewton;
    short.closed_loop.core.sample_time = 5e-5;
    match refusal(drive, Command::Configure(short))? {
        Refusal::Setting(refused) => println!("refused as it should be: {refused}"),
        other => return Err(format!("too short a sample is refused, but because {other}").into()),
    }
    expect("the settings after that", drive.settings()?, settings)?;

    // An encoder that stands still is left behind by any reference: let it, and look on.
    for law in [settings.closed_loop.law, Law::GaussNewton] {
        let mut wanted = settings;
        wanted.closed_loop.law = law;
        wanted.protection.following_error = 1e9;
        wanted.protection.stall_time = 1e3;
        drive.ask(Command::Configure(wanted))?;
        drive.ask(Command::Watch(20))?;
        drive.ask(Command::Start)?;
        expect("the first sample shown", drive.next(shown)?.sample, 1)?;
        expect("the next of them", drive.next(shown)?.sample, 21)?;
        let refused = refusal(drive, Command::Save)?;
        expect("a record in motion", refused, Refusal::Running)?;
        drive.ask(Command::Stop)?;
        until(drive, State::Released)?;
        println!("{law}: started, watched and stopped");
    }

    let mut strict = settings;
    strict.protection.following_error = 1e-3;
    drive.ask(Command::Configure(strict))?;
    drive.ask(Command::Start)?;
    let fault = drive.next(struck)?;
    expect(
        "the fault of an encoder that stands still",
        fault,
        Fault::FollowingError,
    )?;
    expect(
        "the state then",
        drive.status()?.state,
        State::Faulted(fault),
    )?;
    let refused = refusal(drive, Command::Start)?;
    expect("a start in spite of it", refused, Refusal::Faulted(fault))?;
    println!("{fault}");
    drive.ask(Command::Clear)?;
    until(drive, State::Released)?;
    println!("cleared, and ready again");
    Ok(())
}

fn shown(report: &Report) -> Option<Snapshot> {
    match report {
        Report::Snapshot(snapshot) => Some(*snapshot),
        _ => None,
    }
}

fn struck(report: &Report) -> Option<Fault> {
    match report {
        Report::Fault(fault) => Some(*fault),
        _ => None,
    }
}

/// Waits until the drive is in a state.
fn until(drive: &mut Client, wanted: State) -> Result<(), Box<dyn Error>> {
    for _ in 0..100 {
        if drive.status()?.state == wanted {
            return Ok(());
        }
    }
    Err(format!("the drive does not become {wanted:?}").into())
}

/// Why the drive refuses.
fn refusal(drive: &mut Client, command: Command) -> Result<Refusal, Box<dyn Error>> {
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
