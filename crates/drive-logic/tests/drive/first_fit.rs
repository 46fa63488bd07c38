//! A run whose first fit does not succeed reports why, over the line and of its own accord.

use crate::support::drive::{Drive, SERVO};
use crate::support::first_contact;
use drive_link::{Command, Report, Settings};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;

/// The same with bounds within which the servo's b is not.
fn bounded_beyond_the_servo() -> Settings {
    let mut bounded = first_contact();
    bounded.closed_loop.core.identifier.bounds.b = Some([2.0 * SERVO.b, 8.0 * SERVO.b]);
    bounded
}

/// The rejection reasons in the statuses among unrequested reports.
fn rejection_reasons(reports: &[Report]) -> Vec<Option<Reason>> {
    let of_status = |report: &Report| match report {
        Report::Status { id: None, status } => Some(status.rejection_reason),
        _ => None,
    };
    reports.iter().filter_map(of_status).collect()
}

#[test]
fn the_status_has_the_reason_until_a_first_fit_succeeds() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.run(bounded_beyond_the_servo());
    assert_eq!(rejection_reasons(&drive.pass(950)), []);
    assert_eq!(drive.status().rejection_reason, None);
    let expected = Some(Reason::EstimateAtBound);
    assert_eq!(rejection_reasons(&drive.pass(1050)), [expected]);
    assert_eq!(drive.status().rejection_reason, expected);

    // The servo becomes one that the bounds allow.
    bench.change(&ServoParameters {
        b: 4.0 * SERVO.b,
        ..SERVO
    });
    assert_eq!(rejection_reasons(&drive.pass(8000)), [None]);
    assert_eq!(drive.status().rejection_reason, None);
}

#[test]
fn a_new_run_begins_without_the_reason_of_the_last() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    drive.run_for(bounded_beyond_the_servo(), 2000);
    drive.order(Command::Stop, 1);
    assert_eq!(
        drive.status().rejection_reason,
        Some(Reason::EstimateAtBound)
    );

    drive.run(first_contact());
    assert_eq!(drive.status().rejection_reason, None);
    assert_eq!(drive.status().noise, None);
    let rejection_reasons = rejection_reasons(&drive.pass(3000));
    assert!(
        rejection_reasons.iter().all(Option::is_none),
        "{rejection_reasons:?}"
    );
    drive.order(Command::Stop, 1);
    let noise = drive.status().noise.expect("known by the first fit");
    assert!((0.2..0.4).contains(&noise), "rounding alone, not {noise}");
    let found = drive.supervisor.estimates().expect("identified").servo;
    assert!((found.b / SERVO.b - 1.0).abs() < 0.01, "{found:?}");
}
