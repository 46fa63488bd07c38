//! Counts that wrap, and a run that a commissioning takes over and hands back.

use crate::support::commission::{ORDER, until};
use crate::support::drive::{Drive, SERVO, snapshots};
use crate::support::{Bench, Flash, still};
use commissioning::Phase;
use drive_link::{Command, Fault, Refusal, Report, State};
use identifier_core::parameters::ServoParameters;

#[test]
fn a_far_target_is_reached_over_a_count_that_wraps_and_a_turned_axis_is_a_fault() {
    let (bench, flash) = (Bench::counting_from(i32::MAX - 100, &SERVO), Flash::blank());
    let mut drive = Drive::boot(bench, &flash);
    drive.done(Command::Watch(1));
    let reports = drive.order(Command::Start, 19_001);
    drive.order(Command::Target(-50.0), 13_000);
    assert!((bench.position() + 50.0).abs() < 1.0);
    assert_eq!(drive.state(), State::Running);
    bench.plant.borrow_mut().position += 6.3;
    let end = drive.pass(2);
    let fault = Report::Fault(Fault::FollowingError);
    assert!(end.contains(&fault), "{end:?}");
    let found = snapshots(&reports).last().expect("shown").estimates;
    assert!((found.servo.b / SERVO.b - 1.0).abs() < 0.01, "{found:?}");
    assert!((found.servo.a - SERVO.a).abs() < 0.1, "{found:?}");
}

#[test]
fn a_commissioning_takes_a_run_over_and_hands_it_back_without_a_bump() {
    /// Command of one count of the encoder, at most: k_p and the derivative's share of it.
    const ONE_COUNT: f32 = 0.06;
    let loaded = ServoParameters {
        coulomb: 15.0,
        load: 100.0,
        ..SERVO
    };
    let quiet = still();
    let (bench, flash) = (
        Bench::counting_from(i32::MAX - 100, &loaded),
        Flash::blank(),
    );
    let held = || bench.held.get().expect("the servo is held");
    let mut drive = Drive::boot(bench, &flash);
    drive.run_for(quiet, 6000);
    let before = held();
    drive.done(Command::Commission(ORDER));
    drive.sample();
    assert!((held() - before).abs() < ONE_COUNT);
    until(&mut drive, Phase::FrequencyResponse);
    assert_eq!(drive.refusal(Command::Start), Refusal::EndedCommissioning);
    let mut last = 0.0;
    while drive.state() != State::Running {
        last = held();
        drive.pass(1);
    }
    assert!((held() - last).abs() < 2.0 * ONE_COUNT, "{last}");
    assert_eq!(drive.shown(), quiet);
    drive.order(Command::Target(0.5), 4000);
    assert_eq!(drive.state(), State::Running);
    assert!((bench.position() - 0.5).abs() < 0.1);
}
