//! Targets from outside, step pulses and a voltage, and their bad inputs.

use core::f64::consts::TAU;

use crate::support::commission::{ORDER, commission, over};
use crate::support::drive::{Drive, snapshots};
use crate::support::{Bench, COUNTS, HOMING, still};
use drive_link::{Command, Fault, Home, Refusal, Settings, State, TargetSource};
use identifier_core::parameters::ServoParameters;

const SERVO: ServoParameters = ServoParameters {
    a: 0.2174,
    b: 257.7,
    coulomb: 0.0,
    load: 0.0,
};

/// A step that is no whole number of counts, rad: 1/3600 of a revolution.
const STEP: f64 = TAU / 3600.0;

fn followed(source: TargetSource) -> Settings {
    let mut wanted = still();
    wanted.protection.travel = [-8.0, 8.0];
    wanted.source = source;
    wanted
}

/// A run with these settings.
fn running(settings: Settings) -> (Drive, &'static Bench) {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.done(Command::Configure(settings));
    // Steps before the start do not count.
    bench.steps.set(Some(5000));
    drive.order(Command::Start, 10);
    (drive, bench)
}

/// Steps in every sample.
fn step(drive: &mut Drive, each: i16, samples: u32) {
    for _ in 0..samples {
        drive.bench.steps.set(Some(each));
        drive.pass(1);
    }
}

/// The reference, rad from the origin.
fn reference(drive: &mut Drive) -> f64 {
    let shown = snapshots(&drive.order(Command::Watch(1), 2));
    drive.order(Command::Watch(0), 1);
    shown[0].reference.into()
}

#[test]
fn steps_are_followed_to_a_count_there_and_back() {
    for size in [STEP, -STEP] {
        let (mut drive, _) = running(followed(TargetSource::Steps { step: size }));
        assert!(drive.position().abs() < 1e-3);
        // 2 steps a sample are 3.5 rad/s; 4000 of them are 7 rad.
        step(&mut drive, 2, 2000);
        drive.pass(1000);
        let at = reference(&mut drive);
        assert!((at - 4000.0 * size).abs() < TAU / COUNTS, "{at}");
        assert!((drive.position() - at).abs() < 0.05);
        step(&mut drive, -2, 4000);
        drive.pass(1000);
        let at = reference(&mut drive);
        assert!((at + 4000.0 * size).abs() < TAU / COUNTS, "{at}");
        assert!((drive.position() - at).abs() < 0.05);
        assert_eq!(drive.state(), State::Running);
    }
}

#[test]
fn a_gear_of_any_ratio_does_not_drift() {
    let mut wanted = followed(TargetSource::Steps { step: STEP });
    wanted.protection.pace = 10.0;
    let (mut drive, bench) = running(wanted);
    for _ in 0..300 {
        step(&mut drive, 3, 100);
        step(&mut drive, -3, 100);
    }
    drive.pass(1000);
    assert!(bench.held.get().is_some());
    let at = reference(&mut drive);
    assert!(at.abs() < 0.5 * TAU / COUNTS, "{at}");
}

#[test]
fn steps_that_are_too_fast_are_a_fault_and_a_burst_is_none() {
    // 5 rad/s are 2.86 steps a sample.
    let source = TargetSource::Steps { step: STEP };
    let (mut drive, _) = running(followed(source));
    // A burst within 20 ms, then a pause.
    for _ in 0..20 {
        step(&mut drive, 10, 5);
        drive.pass(20);
    }
    assert_eq!(drive.state(), State::Running);

    let (mut drive, bench) = running(followed(source));
    let mut samples = 0;
    while drive.state() == State::Running && samples < 2000 {
        step(&mut drive, 4, 1);
        samples += 1;
    }
    let fault = Fault::StepsTooFast;
    assert_eq!(drive.state(), State::Faulted(fault));
    assert_eq!(bench.held.get(), None);
    // 4 steps a sample are 1.4 of the pace: it lags by 20 ms of the pace after 50 ms.
    assert!((30..=70).contains(&samples), "{samples}");
    assert!(fault.to_string().contains("allow more pace"));
    // One sample with as many as a counter holds.
    let (mut drive, bench) = running(followed(source));
    for many in [i16::MAX, i16::MIN] {
        step(&mut drive, many, 1);
        let state = drive.state();
        assert!(matches!(state, State::Faulted(_)), "{state:?}");
        assert_eq!(bench.held.get(), None);
        drive.order(Command::Clear, 1);
        drive.order(Command::Start, 5);
    }
}

#[test]
fn steps_beyond_the_travel_and_steps_that_are_unclear_are_faults() {
    let (mut drive, bench) = running(followed(TargetSource::Steps { step: STEP }));
    step(&mut drive, 2, 2280);
    assert_eq!(drive.state(), State::Running);
    for _ in 0..20 {
        if drive.state() == State::Running {
            step(&mut drive, 2, 1);
        }
    }
    assert_eq!(drive.state(), State::Faulted(Fault::TargetOutside));
    assert_eq!(bench.held.get(), None);
    assert!(drive.position() < 8.0);

    let (mut drive, bench) = running(followed(TargetSource::Steps { step: STEP }));
    step(&mut drive, 1, 10);
    bench.steps.set(None);
    drive.pass(1);
    assert_eq!(drive.state(), State::Faulted(Fault::StepsUnclear));
    assert_eq!(bench.held.get(), None);
    // Before a start they do not matter.
    drive.done(Command::Clear);
    bench.steps.set(None);
    drive.pass(2);
    drive.order(Command::Start, 100);
    assert_eq!(drive.state(), State::Running);
}

#[test]
fn targets_of_the_host_are_refused_and_a_stop_holds() {
    let (mut drive, bench) = running(followed(TargetSource::Steps { step: STEP }));
    let refused = drive.refusal(Command::Target(1.0));
    assert_eq!(refused, Refusal::TargetsFromOutside);
    step(&mut drive, 2, 100);
    drive.done(Command::Stop);
    step(&mut drive, 2, 1);
    assert_eq!(bench.held.get(), None);
    step(&mut drive, 2, 100);
    assert_eq!(bench.held.get(), None);
    assert_eq!(drive.state(), State::Disabled);
}

#[test]
fn a_silent_host_ends_the_run_although_pulses_come() {
    let mut wanted = followed(TargetSource::Steps { step: STEP });
    wanted.protection.link_timeout = 0.3;
    let (mut drive, bench) = running(wanted);
    step(&mut drive, 2, 1000);
    assert_eq!(drive.state(), State::Faulted(Fault::LinkLost));
    assert_eq!(bench.held.get(), None);
    // It came to rest where the reference was.
    assert!(drive.position() < 1.5, "{}", drive.position());
}

#[test]
fn homing_comes_first_and_steps_count_from_home() {
    let mut wanted = followed(TargetSource::Steps { step: STEP });
    wanted.homing = Some(HOMING);
    let (mut drive, bench) = running(wanted);
    *bench.home_switch.borrow_mut() = -6.0..-3.0;
    drive.done(Command::Home);
    while drive.status().home != Home::Known {
        // Ignored on the way.
        step(&mut drive, 1, 1);
    }
    drive.pass(100);
    step(&mut drive, 2, 900);
    drive.pass(1000);
    // The origin is 2 rad from home.
    let at = reference(&mut drive);
    assert!((at - (1800.0 * STEP - 2.0)).abs() < 2e-3, "{at}");
    let at = drive.position();
    assert!((at - (1800.0 * STEP - 3.0)).abs() < 0.05, "{at}");
    assert_eq!(drive.state(), State::Running);
}

#[test]
fn after_a_commissioning_steps_count_from_where_it_stands() {
    let (mut drive, _) = running(followed(TargetSource::Steps { step: STEP }));
    step(&mut drive, 2, 500);
    drive.pass(1000);
    commission(&mut drive, ORDER);
    assert_eq!(drive.state(), State::Running);
    drive.pass(3000);
    let rest = reference(&mut drive);
    assert!((rest - 1000.0 * STEP).abs() < 0.05, "{rest}");
    step(&mut drive, 2, 500);
    drive.pass(1000);
    let at = reference(&mut drive);
    assert!((at - rest - 1000.0 * STEP).abs() < TAU / COUNTS, "{at}");
}

/// However many come: 65 536 of them are none by the counter of 16 bits.
#[test]
fn steps_that_come_during_a_commissioning_are_said() {
    for (each, samples) in [(1, 100), (-1, 1), (i16::MIN, 2)] {
        let (mut drive, bench) = running(followed(TargetSource::Steps { step: STEP }));
        drive.order(Command::Commission(ORDER), 300);
        step(&mut drive, each, samples);
        over(&mut drive);
        drive.pass(10);
        assert_eq!(
            drive.state(),
            State::Faulted(Fault::StepsMissed),
            "{each} {samples}"
        );
        assert_eq!(bench.held.get(), None);
        drive.order(Command::Clear, 1);
        drive.order(Command::Start, 10);
        let rest = reference(&mut drive);
        step(&mut drive, 2, 50);
        drive.pass(1000);
        let at = reference(&mut drive);
        assert!(
            (at - rest - 100.0 * STEP).abs() < 2.0 * TAU / COUNTS,
            "{at}"
        );
    }
}
