//! Gains that follow the inertia of a commissioned servo in a run.
#![cfg(not(feature = "fixed-point"))]

#[macro_use]
mod support;

use drive_link::{
    Command, Gains, Law, Origin, Refusal, Report, ServoChanges, Settings, State, Status,
};
use identifier_core::commission::{Phase, Reason};
use identifier_core::settings::IdentifierSettings;
use identifier_core::tuning::{NotFollowed, StepMeasure, Tuning};
use support::commission::{ORDER, SERVO, changed, outcome, over};
use support::drive::Drive;
use support::{Bench, Flash, SAMPLE_TIME, settings};
use virtual_servo::SplitMix64;

/// Settings under which targets are steps of the reference.
fn stepping(servo_changes: ServoChanges) -> Settings {
    let mut wanted = settings();
    wanted.dither.amplitude = 0.0;
    (wanted.protection.pace, wanted.protection.speed) = (2000.0, 2000.0);
    wanted.closed_loop.law = Law::GaussNewton;
    wanted.closed_loop.core.identifier = IdentifierSettings::UNSTATED;
    wanted.servo_changes = servo_changes;
    wanted
}

/// Commissions the servo, and closes the loop with its gains; their promise.
fn commissioned(drive: &mut Drive<'_>, servo_changes: ServoChanges) -> Tuning {
    drive.done(Command::Configure(stepping(servo_changes)));
    drive.done(Command::Commission(ORDER));
    over(drive);
    let outcome = outcome(drive);
    assert_eq!(outcome.commissioning.phase, Phase::Applied);
    drive.done(Command::Start);
    drive.pass(10);
    outcome.tuning.expect("gains")
}

/// Steps between random targets; the statuses that no request asked for.
fn moves(drive: &mut Drive<'_>, seconds: u32) -> Vec<Status> {
    let mut random = SplitMix64::new(7);
    let mut statuses = Vec::new();
    let mut left = 1000 * seconds;
    while left > 0 {
        let pause = (random.uniform(100.0, 600.0) as u32).min(left);
        left -= pause;
        assert_eq!(
            drive.supervisor.state(),
            State::Running,
            "{left} {:?}",
            drive.status().servo_change
        );
        drive.done(Command::Target(random.uniform(-0.5, 0.5)));
        statuses.extend(
            drive
                .pass(pause)
                .into_iter()
                .filter_map(|report| match report {
                    Report::Status { id: None, status } => Some(status),
                    _ => None,
                }),
        );
    }
    assert_eq!(drive.supervisor.state(), State::Running);
    statuses
}

fn gains(drive: &mut Drive<'_>) -> Gains {
    drive.status().gains.expect("gains")
}

/// The factor by which the gains have followed; one for those as commissioned.
fn factor(drive: &mut Drive<'_>, tuning: &Tuning) -> f64 {
    let gains = gains(drive);
    let factor = gains.controller.kp / tuning.kp;
    match gains.origin {
        Origin::Followed { factor: stated } => {
            assert!((f64::from(stated) / factor - 1.0).abs() < 1e-6);
        }
        Origin::Commissioned => assert!((factor - 1.0).abs() < 1e-12),
        Origin::Given => panic!("they are commissioned"),
    }
    for (gain, before) in [
        (gains.controller.kd, tuning.kd),
        (gains.controller.ki, tuning.ki),
    ] {
        assert!((gain / before / factor - 1.0).abs() < 1e-9);
    }
    factor
}

/// Steps up and down from rest, as the encoder and the true servo have them: within the promise as far as a trial checks it.
fn keeps_promise(drive: &mut Drive<'_>, tuning: &Tuning) {
    /// Beyond the promise, as a trial of a commissioning allows.
    const RISE: f64 = 0.15;
    const OVERSHOOT: f64 = 0.03;
    let promise = &tuning.promise;
    drive.done(Command::Target(-0.5 * promise.step));
    drive.pass(2000);
    for direction in [1.0, -1.0] {
        drive.done(Command::Target(0.5 * direction * promise.step));
        let from = drive.bench.position();
        let mut measure: StepMeasure<f64> = StepMeasure::new(promise.step, 0.0);
        for _ in 0..2000 {
            measure.take(direction * (drive.bench.position() - from));
            drive.pass(1);
        }
        let rise = SAMPLE_TIME * measure.rise().expect("it arrives");
        let quickest = (1.0 - RISE) * promise.quickest_rise_time;
        let slowest = (1.0 + RISE) * promise.slowest_rise_time;
        assert!((quickest..slowest).contains(&rise), "{rise} {promise:?}");
        let overshoot = measure.overshoot();
        assert!(
            overshoot < promise.overshoot + OVERSHOOT,
            "{overshoot} {promise:?}"
        );
    }
}

#[test]
fn gains_follow_the_inertia_in_motion_and_the_loop_keeps_its_promise() {
    for inertia in [2.0, 5.0, 0.5, 0.2] {
        let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
        boot!(drive, &bench, &flash);
        let tuning = commissioned(&mut drive, ServoChanges::Followed);
        assert_eq!(moves(&mut drive, 10), [], "the servo as it was");
        keeps_promise(&mut drive, &tuning);
        bench.change(&changed(inertia, 1.0));
        let [reported, followed] = moves(&mut drive, 60)[..] else {
            panic!("{inertia}: a report and what became of it");
        };
        let change = reported.servo_change.expect("it is reported first");
        assert_eq!(change.reason, Reason::InertiaChanged);
        assert_eq!((followed.servo_change, followed.not_followed), (None, None));
        let found = factor(&mut drive, &tuning);
        assert!((found / inertia - 1.0).abs() < 0.02, "{inertia}: {found}");
        keeps_promise(&mut drive, &tuning);

        // The found servo is the promised one from now on, and the commissioned one is another.
        assert_eq!(moves(&mut drive, 10), []);
        // From a fifth in two steps: its loop does not bear five times the inertia until the estimate is steady.
        if inertia < 0.4 {
            bench.change(&changed(0.4, 1.0));
            assert_eq!(moves(&mut drive, 30).len(), 2);
        }
        bench.change(&SERVO);
        assert_eq!(moves(&mut drive, 30).len(), 2);
        assert!((factor(&mut drive, &tuning) - 1.0).abs() < 0.02);
        keeps_promise(&mut drive, &tuning);
    }
}

#[test]
fn gains_follow_an_estimate_that_is_steady_and_not_one_that_is_only_certain() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    boot!(drive, &bench, &flash);
    let tuning = commissioned(&mut drive, ServoChanges::Followed);
    bench.change(&changed(2.0, 1.0));
    let mut seconds = (1..30).filter(|_| {
        moves(&mut drive, 1);
        drive.status().servo_change.is_some()
    });
    let reported = seconds.next().expect("it is reported");
    drop(seconds);
    moves(&mut drive, 3);
    assert!(
        (factor(&mut drive, &tuning) - 1.0).abs() < 1e-12,
        "{reported}"
    );
    moves(&mut drive, 20);
    assert!(factor(&mut drive, &tuning) > 1.9);
}

#[test]
fn gains_stay_unless_they_are_to_follow() {
    for servo_changes in [ServoChanges::Ignored, ServoChanges::Reported] {
        let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
        boot!(drive, &bench, &flash);
        commissioned(&mut drive, servo_changes);
        let before = gains(&mut drive);
        bench.change(&changed(2.0, 1.0));
        moves(&mut drive, 30);
        assert_eq!(gains(&mut drive), before);
        assert_eq!(drive.status().not_followed, None);
        keeps_no_promise(&mut drive);
    }
}

/// The commands of the run are those of the gains before: with twice the inertia the loop rings.
fn keeps_no_promise(drive: &mut Drive<'_>) {
    let overshoot = (0..2)
        .map(|k| {
            let target = if k == 0 { -0.25 } else { 0.25 };
            drive.done(Command::Target(target));
            (0..2000).fold(0.0, |most: f64, _| {
                drive.pass(1);
                most.max(drive.bench.position() / 0.25)
            })
        })
        .fold(0.0, f64::max);
    assert!(overshoot > 1.05, "{overshoot}");
}

#[test]
fn a_change_of_friction_changes_no_gains() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    boot!(drive, &bench, &flash);
    commissioned(&mut drive, ServoChanges::Followed);
    moves(&mut drive, 10);
    let before = gains(&mut drive);
    bench.change(&changed(1.0, 2.0));
    let reasons: Vec<_> = moves(&mut drive, 30)
        .iter()
        .map(|status| status.servo_change.map(|change| change.reason))
        .collect();
    assert_eq!(reasons, [Some(Reason::CoulombFrictionChanged)]);
    assert_eq!(gains(&mut drive), before);
    assert_eq!(drive.status().not_followed, None);
}

#[test]
fn friction_that_changes_with_the_inertia_is_reported_after_the_gains_have_followed() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    boot!(drive, &bench, &flash);
    let tuning = commissioned(&mut drive, ServoChanges::Followed);
    moves(&mut drive, 10);
    bench.change(&changed(2.0, 4.0));
    moves(&mut drive, 30);
    assert!((factor(&mut drive, &tuning) / 2.0 - 1.0).abs() < 0.05);
    let change = drive.status().servo_change.expect("friction");
    assert_eq!(change.reason, Reason::CoulombFrictionChanged);
}

#[test]
fn a_change_beyond_the_bounds_is_reported_with_the_reason() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    boot!(drive, &bench, &flash);
    commissioned(&mut drive, ServoChanges::Followed);
    moves(&mut drive, 10);
    let before = gains(&mut drive);
    bench.change(&changed(5.5, 1.0));
    moves(&mut drive, 30);
    assert_eq!(gains(&mut drive), before);
    let status = drive.status();
    assert_eq!(status.not_followed, Some(NotFollowed::TooFar));
    let change = status.servo_change.expect("the change stays reported");
    assert_eq!(change.reason, Reason::InertiaChanged);
    // Within them again, it follows.
    bench.change(&changed(3.0, 1.0));
    moves(&mut drive, 30);
    assert_eq!(drive.status().not_followed, None);
    assert!((gains(&mut drive).controller.kp / before.controller.kp / 3.0 - 1.0).abs() < 0.05);
}

#[test]
fn the_next_run_begins_with_the_gains_that_were_commissioned() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    boot!(drive, &bench, &flash);
    let tuning = commissioned(&mut drive, ServoChanges::Followed);
    let shown = drive.shown();
    bench.change(&changed(2.0, 1.0));
    moves(&mut drive, 30);
    assert!(factor(&mut drive, &tuning) > 1.9);
    assert_eq!(drive.shown(), shown, "the settings are as commissioned");
    drive.done(Command::Stop);
    drive.pass(10);
    assert_eq!(gains(&mut drive).origin, Origin::Commissioned);
    drive.done(Command::Save);
    drive.done(Command::Start);
    drive.pass(10);
    assert!((factor(&mut drive, &tuning) - 1.0).abs() < 1e-12);
    moves(&mut drive, 30);
    assert!(factor(&mut drive, &tuning) > 1.9, "found again");
}

#[test]
fn a_commissioning_in_place_of_the_run_goes_back_to_the_gains_that_followed_unless_it_has_new_ones()
{
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    boot!(drive, &bench, &flash);
    let tuning = commissioned(&mut drive, ServoChanges::Followed);
    bench.change(&changed(2.0, 1.0));
    moves(&mut drive, 30);
    let followed = gains(&mut drive);
    assert!(factor(&mut drive, &tuning) > 1.9);
    drive.done(Command::Commission(ORDER));
    drive.pass(300);
    // Another mode ends it.
    assert_eq!(drive.refusal(Command::Start), Refusal::EndedCommissioning);
    over(&mut drive);
    drive.pass(100);
    assert_eq!(drive.supervisor.state(), State::Running);
    assert_eq!(gains(&mut drive), followed);
    keeps_promise(&mut drive, &tuning);

    drive.done(Command::Commission(ORDER));
    over(&mut drive);
    drive.pass(100);
    assert_eq!(drive.supervisor.state(), State::Running);
    let new = gains(&mut drive);
    assert_eq!(new.origin, Origin::Commissioned);
    assert!((new.controller.kp / followed.controller.kp - 1.0).abs() < 0.05);
}
