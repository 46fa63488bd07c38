//! A vertical axis with a holding brake, and the load at the start of a run.

use crate::support::commission::{ORDER, aborted, ended, over, until};
use crate::support::drive::Drive;
use crate::support::harms::Harm;
use crate::support::line::request_bytes;
use crate::support::{Bench, COUNTS, Flash, HOMING, harms, settings};
use commissioning::Phase;
use drive_link::{
    Command, Ended, Estimator, Fault, HoldingBrake, Home, Refusal, Settings, State, TargetSource,
};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use identifier_core::settings::ControllerSettings;
use virtual_servo::VirtualBrake;

/// A vertical axis whose load takes 30 % of the command.
const VERTICAL: ServoParameters = ServoParameters {
    a: 0.2174,
    b: 257.7,
    coulomb: 0.0,
    load: -0.3 * 10.0 * 257.7,
};

const BRAKE: HoldingBrake = HoldingBrake {
    opens: 0.05,
    closes: 0.1,
};

/// Samples in which it closes.
const CLOSES: u32 = 100;

/// The largest fall where the loop holds the axis, rad.
const MAX_FALL: f64 = 0.005;

/// The page with the table of the falls.
const PAGE: &str = include_str!("../../../../docs/faults.md");

/// Settings of the axis, without dither.
fn vertical(brake: Option<HoldingBrake>) -> Settings {
    let mut settings = settings();
    settings.closed_loop.law = Estimator::GaussNewton;
    settings.closed_loop.core.identifier.parameter_range = None;
    settings.closed_loop.core.identifier.gamma = None;
    settings.dither.amplitude = 0.0;
    settings.brake = brake;
    settings
}

/// Has a run identify the load, so that the drive keeps it.
fn identify(drive: &mut Drive, settings: &Settings) {
    let mut shaken = *settings;
    (shaken.dither.amplitude, shaken.brake) = (0.3, None);
    (shaken.protection.duration, shaken.protection.link_timeout) = (0.0, 0.0);
    drive.run(shaken);
    let samples = (2.0 / settings.closed_loop.core.sample_time) as u32;
    drive.pass(samples);
    drive.order(Command::Stop, 3);
    let load = drive.status().estimates.expect("identified").servo.load;
    assert!((load / VERTICAL.load - 1.0).abs() < 0.01, "{load}");
    drive.done(Command::Configure(*settings));
    drive.bench.hold_at(0.0);
}

/// A drive on a vertical axis that rests on its brake; the load is known.
fn on_its_brake(settings: Settings) -> (Drive, &'static Bench) {
    let (mut drive, bench) = Drive::on_bench(&VERTICAL);
    identify(&mut drive, &settings);
    let brake = VirtualBrake::closed(BRAKE.opens, BRAKE.closes);
    bench.brake.set(Some(brake));
    (drive, bench)
}

/// The lowest position in these samples, rad. In none of them the brake is open without the loop.
fn lowest(drive: &mut Drive, samples: u32) -> f64 {
    let positions = (0..samples).map(|_| {
        drive.pass(1);
        assert!(drive.bench.held.get().is_some() || !drive.bench.brake_power.get());
        drive.position()
    });
    positions.fold(f64::INFINITY, f64::min)
}

/// Runs samples until the stage is disabled: their number.
fn until_disabled(drive: &mut Drive) -> u32 {
    let disabled = (1..3000).find(|_| {
        drive.pass(1);
        drive.bench.held.get().is_none()
    });
    disabled.expect("it is disabled")
}

/// What happens to the axis, how, and the fault that holds afterwards.
type Case = (&'static str, fn(&mut Drive), Option<Fault>);

const CASES: [Case; 9] = [
    ("start", |_| {}, None),
    ("move", |drive| drive.done(Command::Target(2.0)), None),
    ("stop", harms::stop, None),
    ("end of the time", |_| {}, None),
    ("link lost", |_| {}, Some(Fault::LinkLost)),
    (
        "limit switch",
        harms::low_switch_opens,
        Some(Fault::LimitSwitch),
    ),
    (
        "encoder lost",
        harms::encoder_fails,
        Some(Fault::EncoderLost),
    ),
    (
        "amplifier fault",
        harms::amplifier_fails,
        Some(Fault::AmplifierFault),
    ),
    ("supply low", harms::supply_sags, Some(Fault::SupplyLow)),
];

#[test]
fn a_vertical_axis_falls_in_no_case_but_faults_of_what_holds_it() {
    for (name, cause, fault) in CASES {
        let mut settings = vertical(Some(BRAKE));
        settings.protection.duration = if name == "end of the time" { 0.5 } else { 0.0 };
        settings.protection.link_timeout = if name == "link lost" { 0.5 } else { 0.0 };
        let (mut drive, bench) = on_its_brake(settings);
        drive.done(Command::Start);
        let mut position = lowest(&mut drive, 400);
        if name != "start" {
            cause(&mut drive);
            position = position.min(lowest(&mut drive, 1600));
        }
        let fall = (-position).max(0.0);
        let row = format!(
            "| {name} | {} | {fall:.3} |",
            fault.map_or_else(|| "–".to_owned(), |fault| fault.number().to_string())
        );
        println!("{row}");
        let keeps_running = matches!(name, "start" | "move");
        assert_eq!(bench.held.get().is_some(), keeps_running, "{name}");
        assert_eq!(bench.brake_power.get(), keeps_running, "{name}");
        let state = match fault {
            Some(fault) => State::Faulted(fault),
            None if keeps_running => State::Running,
            None => State::Disabled,
        };
        assert_eq!(drive.state(), state, "{name}");
        let is_cut = fault.is_some_and(|fault| [20, 10, 13].contains(&fault.number()));
        assert_eq!(fall > MAX_FALL, is_cut, "{row}");
        assert!(PAGE.contains(&row), "docs/faults.md has another row: {row}");
    }
}

#[test]
fn a_load_that_is_known_is_held_from_the_first_sample() {
    let own = ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0);
    for sample_time in [1e-3, 2.5e-4, 1e-4, 5e-5] {
        // As it is, an eighth and a sixty-fourth of its stiffness, and without integral.
        for (part, ki) in [(1.0, 4.0), (8.0, 4.0), (64.0, 0.01), (1.0, 0.0)] {
            let mut settings = vertical(None);
            settings.closed_loop.core.sample_time = sample_time;
            settings.closed_loop.core.controller = Some(ControllerSettings {
                kp: own.kp / part,
                kd: own.kd / part.sqrt(),
                ki,
                ..own
            });
            let bench = Bench::sampled(&VERTICAL, sample_time);
            let mut drive = Drive::boot(bench, &Flash::blank());
            settings.protection.following_error = 40.0;
            // Behind its brake; and in the air, where it is held once it is seen to fall.
            for brake in [Some(BRAKE), None] {
                settings.brake = brake;
                bench.brake.set(None);
                identify(&mut drive, &settings);
                bench
                    .brake
                    .set(brake.map(|times| VirtualBrake::closed(times.opens, times.closes)));
                drive.done(Command::Start);
                let samples = (0.3 / sample_time) as u32;
                let fall = -lowest(&mut drive, samples);
                let end = bench.position();
                let seen =
                    (2.0 * 6.0 * settings.closed_loop.core.resolution / -VERTICAL.load).sqrt();
                let speed = -VERTICAL.load * (seen + 2.0 * sample_time);
                let most = match brake {
                    Some(_) => MAX_FALL,
                    None => MAX_FALL + speed / (own.kp / part * VERTICAL.b).sqrt(),
                };
                assert!(
                    fall < most && end < brake.map_or(most, |_| MAX_FALL),
                    "{sample_time} {part} {ki} {brake:?}: {fall} of {most} {end}"
                );
                drive.order(Command::Stop, bench.samples(0.2));
            }
        }
    }
}

/// Has the drive take in what an axis did while it was jammed, freed of its load or pulled, and starts again: the largest
/// command of the first samples, the largest distance, rad, and the largest speed, rad/s.
fn begun_again(drive: &mut Drive) -> [f64; 3] {
    let from = drive.position();
    let mut most = [0.0_f64; 3];
    for sample in 0..2000 {
        drive.pass(1);
        let Some(command) = drive.bench.held.get() else {
            panic!("{sample}: {:?}", drive.state());
        };
        let first = if sample < 3 { command.abs() } else { 0.0 };
        let speed = drive.bench.plant.borrow().velocity.abs();
        let now = [f64::from(first), (drive.position() - from).abs(), speed];
        most = core::array::from_fn(|of| most[of].max(now[of]));
    }
    most
}

#[test]
fn a_load_of_before_moves_no_axis_that_has_none_any_longer() {
    const FREE: ServoParameters = ServoParameters {
        load: 0.0,
        coulomb: 10.0,
        ..VERTICAL
    };
    for (kp, ki) in [(9.0, 4.0), (9.0, 0.0), (1.0, 0.1)] {
        let mut settings = vertical(None);
        let controller = settings.closed_loop.core.controller.as_mut();
        let controller = controller.expect("given");
        (controller.kp, controller.ki) = (kp, ki);
        // The payload is taken off.
        let (mut drive, bench) = Drive::on_bench(&VERTICAL);
        settings.protection.following_error = 40.0;
        identify(&mut drive, &settings);
        bench.change(&FREE);
        drive.pass(30);
        drive.done(Command::Start);
        let [first, distance, speed] = begun_again(&mut drive);
        println!("payload {kp} {ki}: {first} {distance} {speed}");
        assert!(
            first < 1.0 && distance < 0.05 && speed < 2.0,
            "{kp} {ki}: {first} {distance} {speed}"
        );
        // And a target that comes meanwhile is followed.
        drive.order(Command::Stop, 100);
        drive.done(Command::Start);
        drive.done(Command::Target(0.3));
        begun_again(&mut drive);
        assert!(
            (bench.position() - 0.3).abs() < 0.05,
            "{}",
            bench.position()
        );
        drive.order(Command::Stop, 100);
        // A commissioning does not begin with it either.
        let (mut drive, bench) = Drive::on_bench(&VERTICAL);
        settings.protection.following_error = 40.0;
        identify(&mut drive, &settings);
        bench.change(&FREE);
        drive.pass(100);
        drive.done(Command::Commission(ORDER));
        for _ in 0..20 {
            drive.pass(1);
            let command = bench.held.get().unwrap_or(0.0);
            assert!(command.abs() < 1.0, "{kp} {ki}: {command}");
        }
        // It jams, ends by a fault and is freed.
        settings.protection.following_error = 3.0;
        settings.dither.amplitude = 0.3;
        let (mut drive, bench) = Drive::on_bench(&FREE);
        drive.run_for(settings, 3000);
        let place = bench.position();
        drive.done(Command::Target(2.9));
        let is_jammed = (0..30_000).any(|_| {
            bench.hold_at(place);
            drive.pass(1);
            bench.held.get().is_none()
        });
        assert!(is_jammed, "it ends");
        drive.order(Command::Clear, 100);
        drive.done(Command::Save);
        settings.dither.amplitude = 0.0;
        let mut again = drive.rebooted();
        again.done(Command::Configure(settings));
        again.done(Command::Start);
        let [first, distance, speed] = begun_again(&mut again);
        println!("jam {kp} {ki}: {first} {distance} {speed}");
        assert!(
            first < 1.0 && distance < 0.1 && speed < 5.0,
            "{kp} {ki}: {first} {distance} {speed}"
        );
    }
}

#[test]
fn a_load_of_before_that_friction_holds_is_no_silent_encoder() {
    let mut settings = vertical(None);
    let (mut drive, bench) = Drive::on_bench(&VERTICAL);
    identify(&mut drive, &settings);
    (
        settings.protection.breakaway,
        settings.protection.stall_time,
    ) = (0.1, 0.02);
    drive.done(Command::Configure(settings));
    bench.change(&ServoParameters {
        load: 0.5 * VERTICAL.load,
        coulomb: -VERTICAL.load,
        ..VERTICAL
    });
    drive.pass(30);
    drive.order(Command::Start, 3000);
    assert_eq!(drive.state(), State::Running);
    assert!(
        bench
            .held
            .get()
            .is_some_and(|held| (held - 3.0).abs() < 0.1)
    );
}

/// A drive that holds the axis with its brake open.
fn holding() -> (Drive, &'static Bench) {
    let (mut drive, bench) = on_its_brake(vertical(Some(BRAKE)));
    drive.order(Command::Start, 400);
    assert!(bench.brake_power.get());
    (drive, bench)
}

#[test]
fn a_stop_closes_the_brake_at_once_and_holds_for_as_long_as_it_closes() {
    let (mut drive, bench) = holding();
    drive.order(Command::Stop, 1);
    assert!(!bench.brake_power.get(), "within a sample");
    // Nothing new meanwhile.
    assert_eq!(drive.refusal(Command::Start), Refusal::Running);
    assert_eq!(drive.refusal(Command::Target(1.0)), Refusal::NotRunning);
    assert_eq!(
        drive.refusal(Command::Configure(settings())),
        Refusal::Running
    );
    assert_eq!(drive.refusal(Command::Commission(ORDER)), Refusal::Running);
    assert_eq!(until_disabled(&mut drive), CLOSES);
    assert_eq!(drive.state(), State::Disabled);
    assert_eq!(drive.status().ended, Some(Ended::Stopped));
    // And once more.
    drive.order(Command::Start, 400);
    assert!(bench.held.get().is_some() && bench.brake_power.get());
    assert!(bench.position().abs() < MAX_FALL);
}

#[test]
fn a_second_stop_or_a_fault_while_the_brake_closes_disables_at_once() {
    type Second = (fn(&mut Drive), Option<Fault>);
    let second: [Second; 4] = [
        (harms::stop, None),
        (harms::encoder_fails, Some(Fault::EncoderLost)),
        (harms::amplifier_fails, Some(Fault::AmplifierFault)),
        (harms::high_switch_opens, Some(Fault::LimitSwitch)),
    ];
    for (cause, fault) in second {
        let (mut drive, bench) = holding();
        drive.order(Command::Stop, 20);
        assert!(bench.held.get().is_some());
        cause(&mut drive);
        // A switch is debounced for 2 ms, a reading is bridged.
        assert!(until_disabled(&mut drive) <= 3, "{fault:?}");
        drive.pass(3);
        let state = fault.map_or(State::Disabled, State::Faulted);
        assert_eq!(drive.state(), state);
        let ended = fault.map_or(Ended::Stopped, Ended::Faulted);
        assert_eq!(drive.status().ended, Some(ended), "the graver end");
    }
}

#[test]
fn of_two_faults_of_an_end_the_graver_is_told_and_decides_on_home() {
    let jumps = |drive: &mut Drive| drive.bench.first.set(300_000);
    let graver: [(Harm, Harm, bool); 4] = [
        (harms::low_switch_opens, harms::encoder_fails, true),
        (harms::low_switch_opens, jumps, true),
        // The link is lost.
        (|_| {}, harms::encoder_fails, true),
        (|_| {}, harms::high_switch_opens, false),
    ];
    for commissions in [false, true] {
        for (case, (first, second, is_lost)) in graver.into_iter().enumerate() {
            let mut settings = vertical(Some(BRAKE));
            settings.homing = Some(HOMING);
            settings.protection.link_timeout = 0.2;
            let (mut drive, bench) = on_its_brake(settings);
            *bench.home_switch.borrow_mut() = -40.0..-1.0;
            drive.done(Command::Start);
            let alive = |drive: &mut Drive, samples| {
                for _ in 0..samples / 50 {
                    drive.done(Command::KeepAlive);
                    drive.pass(50);
                }
            };
            alive(&mut drive, 200);
            drive.done(Command::Home);
            alive(&mut drive, 6000);
            assert_eq!(drive.status().home, Home::Known);
            if commissions {
                drive.done(Command::Stop);
                drive.pass(300);
                let mut order = ORDER;
                order.resolution = settings.closed_loop.core.resolution;
                drive.done(Command::Commission(order));
                alive(&mut drive, 200);
            }
            first(&mut drive);
            while bench.brake_power.get() {
                drive.pass(1);
            }
            drive.pass(10);
            assert!(
                bench.held.get().is_some(),
                "{commissions} {case}: it is held"
            );
            second(&mut drive);
            // A reading is bridged, a switch is debounced.
            let left = until_disabled(&mut drive);
            assert!(left <= 4, "{commissions} {case}: {left}");
            drive.pass(200);
            let State::Faulted(told) = drive.state() else {
                panic!("{commissions} {case}: {:?}", drive.state());
            };
            assert_eq!(
                told.loses_position(),
                is_lost,
                "{commissions} {case}: {told}"
            );
            let home = if is_lost { Home::Unknown } else { Home::Known };
            assert_eq!(drive.status().home, home, "{commissions} {case}: {told}");
        }
    }
}

#[test]
fn a_stop_that_was_sent_again_is_no_second_stop_and_a_first_one_lets_go_of_no_held_axis() {
    let (mut drive, bench) = holding();
    let mut listener = drive.listener.take().expect("one line");
    let mut stop = |id| {
        for byte in request_bytes(id, Command::Stop) {
            listener.take(byte);
        }
    };
    for _ in 0..3 {
        stop(7);
        drive.pass(20);
        assert!(bench.held.get().is_some() && !bench.brake_power.get());
    }
    stop(8);
    drive.pass(1);
    assert_eq!(bench.held.get(), None);
    // After a limit switch.
    let (mut drive, bench) = holding();
    drive.lines(|lines| lines.low_switch = false);
    drive.pass(20);
    drive.order(Command::Stop, 20);
    assert!(bench.held.get().is_some() && !bench.brake_power.get());
    drive.order(Command::Stop, 1);
    assert_eq!(bench.held.get(), None);
    drive.pass(3);
    assert_eq!(drive.state(), State::Faulted(Fault::LimitSwitch));
}

#[test]
fn motion_waits_until_the_brake_has_opened_and_the_loop_holds_before() {
    let (mut drive, bench) = on_its_brake(vertical(Some(BRAKE)));
    drive.order(Command::Start, 1);
    let held = f64::from(bench.held.get().expect("held"));
    assert!((held - 3.0).abs() < 0.1, "{held}");
    assert!(!bench.brake_power.get(), "held before it opens");
    drive.done(Command::Target(2.0));
    for sample in 0..50 {
        drive.pass(1);
        assert!(bench.brake_power.get());
        assert!(bench.position().abs() < MAX_FALL, "{sample}");
    }
    drive.pass(2000);
    assert!((bench.position() - 2.0).abs() < 0.01);
    // A stop on the way up: the loop brakes the axis, and the brake takes it over.
    drive.order(Command::Target(-2.0), 300);
    drive.done(Command::Stop);
    let stopped = bench.position();
    assert_eq!(until_disabled(&mut drive), CLOSES + 1);
    assert!((bench.position() - stopped).abs() < 0.3);
}

#[test]
fn steps_while_the_brake_opens_are_followed_afterwards() {
    let step = core::f64::consts::TAU / COUNTS;
    let settings = Settings {
        source: TargetSource::Steps { step },
        ..vertical(Some(BRAKE))
    };
    let (mut drive, bench) = on_its_brake(settings);
    drive.order(Command::Start, 2);
    bench.steps.set(Some(50));
    drive.pass(30);
    assert!(bench.position().abs() < 3.0 * step);
    drive.pass(1000);
    assert!((bench.position() - 50.0 * step).abs() < 3.0 * step);
}

#[test]
fn a_commissioning_holds_the_axis_from_its_start_to_the_closed_brake() {
    // The axis may fall as far as its motions go.
    let travel = ORDER.limits.travel[1];
    type Cause = fn(&mut Drive);
    let ends: [(Option<Phase>, Cause, Option<Reason>); 4] = [
        (None, |_| {}, None),
        (Some(Phase::Fit), harms::stop, Some(Reason::Stopped)),
        (
            Some(Phase::Probe),
            harms::low_switch_opens,
            Some(Reason::LimitSwitch),
        ),
        (Some(Phase::Trial), harms::stop, Some(Reason::Stopped)),
    ];
    for (phase, cause, reason) in ends {
        let (mut drive, bench) = on_its_brake(vertical(Some(BRAKE)));
        drive.done(Command::Commission(ORDER));
        // Before the first motion.
        assert!(-lowest(&mut drive, 40) < MAX_FALL);
        if let Some(phase) = phase {
            until(&mut drive, phase);
        }
        let before = bench.position();
        cause(&mut drive);
        let phase = ended(&mut drive).commissioning;
        assert_eq!(phase.reason, reason, "{phase}");
        assert_eq!(bench.held.get(), None);
        let rests_at = bench.position();
        assert!(
            (rests_at - before).abs() < travel,
            "{phase}: {before} {rests_at}"
        );
        drive.pass(200);
        assert_eq!(
            bench.position().to_bits(),
            rests_at.to_bits(),
            "{phase}: the brake holds it"
        );
        if reason.is_none() {
            assert!(rests_at.abs() < MAX_FALL, "{rests_at}");
        }
    }
}

#[test]
fn a_commissioning_without_gains_opens_the_brake_with_its_first_command() {
    let (mut drive, bench) = on_its_brake(vertical(Some(BRAKE)));
    let mut settings = vertical(Some(BRAKE));
    settings.closed_loop.core.controller = None;
    drive.done(Command::Configure(settings));
    drive.done(Command::Commission(ORDER));
    until(&mut drive, Phase::Probe);
    drive.pass(20);
    assert!(bench.brake_power.get());
}

#[test]
fn nothing_takes_the_place_of_a_run_whose_brake_closes() {
    let (mut drive, bench) = holding();
    drive.lines(|lines| lines.low_switch = false);
    // Its report is not heard yet.
    while bench.brake_power.get() {
        drive.sample();
    }
    drive.done(Command::Commission(ORDER));
    assert!(until_disabled(&mut drive) <= CLOSES);
    assert_eq!(drive.state(), State::Faulted(Fault::LimitSwitch));
    assert_eq!(
        ended(&mut drive).commissioning,
        aborted(Reason::ModeChanged)
    );
}

#[test]
fn a_link_may_be_silent_while_the_brake_of_a_commissioning_closes() {
    let mut settings = vertical(Some(BRAKE));
    settings.protection.link_timeout = 0.06;
    let (mut drive, _) = on_its_brake(settings);
    drive.done(Command::Commission(ORDER));
    until(&mut drive, Phase::Probe);
    drive.order(Command::Stop, 1);
    assert_eq!(until_disabled(&mut drive), CLOSES);
    drive.pass(3);
    assert_eq!(drive.state(), State::Disabled);
}

#[test]
fn a_commissioning_in_place_of_a_run_waits_for_the_brake() {
    let (mut drive, bench) = on_its_brake(vertical(Some(BRAKE)));
    drive.order(Command::Start, 3);
    drive.done(Command::Commission(ORDER));
    for _ in 0..45 {
        drive.pass(1);
        assert!(bench.position().abs() < MAX_FALL);
        let phase = drive.status().commissioning.map(|last| last.phase);
        assert!(
            matches!(phase, Some(Phase::Idle | Phase::Rest)),
            "{phase:?}"
        );
    }
    over(&mut drive);
    drive.pass(10);
    assert_eq!(drive.state(), State::Running);
    drive.done(Command::Stop);
    assert!(-lowest(&mut drive, 400) < MAX_FALL);
}
