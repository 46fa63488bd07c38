//! Changes of a servo after its commissioning, as the status has them.

mod support;

use commissioning::Phase;
use drive_link::{Command, Report, ServoChanges, Settings, State, Why};
use identifier_core::reason::Reason;
use support::commission::{ORDER, SERVO, changed, outcome, over};
use support::drive::Drive;
use support::{first_contact, settings};

/// Settings under which a servo is examined.
fn examined(servo_changes: ServoChanges) -> Settings {
    let mut wanted = first_contact();
    wanted.dither.amplitude = 0.0;
    wanted.servo_changes = servo_changes;
    wanted
}

/// Commissions the servo, and closes the loop with its gains.
fn commissioned(drive: &mut Drive, servo_changes: ServoChanges) {
    drive.done(Command::Configure(examined(servo_changes)));
    drive.done(Command::Commission(ORDER));
    over(drive);
    assert_eq!(outcome(drive).commissioning.phase, Phase::Applied);
    drive.done(Command::Start);
    drive.pass(10);
}

/// Moves to and fro; the changes of the statuses that no request asked for.
fn moves(drive: &mut Drive, seconds: u32) -> Vec<Option<Reason>> {
    let mut found = Vec::new();
    for k in 0..2 * seconds {
        drive.done(Command::Target(if k % 2 == 0 { 0.8 } else { -0.6 }));
        found.extend(drive.pass(500).iter().filter_map(|report| match report {
            Report::Status { id: None, status } => {
                Some(status.servo_change.map(|change| change.reason))
            }
            _ => None,
        }));
    }
    assert_eq!(drive.state(), State::Running);
    found
}

#[test]
fn another_inertia_or_friction_is_reported_once_with_its_value() {
    for (inertia, friction, reason) in [
        (0.5, 1.0, Reason::InertiaChanged),
        (2.0, 1.0, Reason::InertiaChanged),
        (1.0, 2.0, Reason::CoulombFrictionChanged),
    ] {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        commissioned(&mut drive, ServoChanges::Reported);
        assert_eq!(moves(&mut drive, 10), [], "the servo as it was");
        bench.change(&changed(inertia, friction));
        assert_eq!(moves(&mut drive, 15), [Some(reason)]);
        let change = drive.status().servo_change.expect("it was reported");
        let ratio = change.found / change.predicted;
        assert!(
            (ratio / (inertia * friction) - 1.0).abs() < 0.1,
            "{change:?}"
        );

        // It is the servo's that was commissioned again.
        bench.change(&SERVO);
        assert_eq!(moves(&mut drive, 20), [None]);
        assert_eq!(drive.status().servo_change, None);
    }
}

#[test]
fn nothing_is_looked_for_unless_it_is_asked_for() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    commissioned(&mut drive, ServoChanges::Ignored);
    bench.change(&changed(2.0, 1.0));
    moves(&mut drive, 15);
    assert_eq!(drive.status().servo_change, None);
}

#[test]
fn gains_that_were_given_prediction_nothing() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.run(examined(ServoChanges::Reported));
    moves(&mut drive, 5);
    bench.change(&changed(2.0, 1.0));
    moves(&mut drive, 15);
    assert_eq!(drive.status().servo_change, None);
}

#[test]
fn gains_that_are_given_after_a_commissioning_prediction_nothing() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    commissioned(&mut drive, ServoChanges::Reported);
    drive.done(Command::Stop);
    drive.pass(10);
    let mut given = drive.shown();
    given.closed_loop.core.controller = settings().closed_loop.core.controller;
    drive.run(given);
    drive.pass(10);
    bench.change(&changed(2.0, 1.0));
    moves(&mut drive, 15);
    assert_eq!(drive.status().servo_change, None);
}

#[test]
fn a_estimator_without_standard_errors_is_refused() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    let mut wanted = examined(ServoChanges::Reported);
    wanted.closed_loop.law = settings().closed_loop.law;
    wanted.closed_loop.core.identifier = settings().closed_loop.core.identifier;
    match drive.refusal(Command::Configure(wanted)) {
        drive_link::Refusal::Setting(refused) => {
            assert_eq!(
                (refused.name.as_str(), refused.why),
                ("servo_changes", Why::NotHere)
            );
        }
        other => panic!("{other:?}"),
    }
}
