//! Changes of a servo after its commissioning, as the status has them.

use crate::support::commission::{ORDER, SERVO, changed, commission};
use crate::support::drive::Drive;
use crate::support::{first_contact, settings};
use commissioning::Phase;
use drive_link::{Command, Report, ServoChanges, Settings, State};
use identifier_core::reason::Reason;

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
    let phase = commission(drive, ORDER).commissioning.phase;
    assert_eq!(phase, Phase::Applied);
    drive.order(Command::Start, 10);
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
fn a_change_is_reported_only_of_commissioned_gains_and_where_it_is_asked_for() {
    const REPORTED: ServoChanges = ServoChanges::Reported;
    let begins: [fn(&mut Drive); 3] = [
        |drive| commissioned(drive, ServoChanges::Ignored),
        // Gains that were given predict nothing, before a commissioning and after it.
        |drive| drive.run(examined(REPORTED)),
        |drive| {
            commissioned(drive, REPORTED);
            drive.order(Command::Stop, 10);
            let mut given = drive.shown();
            given.closed_loop.core.controller = settings().closed_loop.core.controller;
            drive.run_for(given, 10);
        },
    ];
    for begin in begins {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        begin(&mut drive);
        moves(&mut drive, 5);
        bench.change(&changed(2.0, 1.0));
        moves(&mut drive, 15);
        assert_eq!(drive.status().servo_change, None);
    }
}
