//! The parts that a build has: `--no-default-features` is that of a small board, for which this is built alone.

#[allow(dead_code, reason = "the bench of all tests of the drive")]
#[path = "drive/support/mod.rs"]
mod support;

use drive_link::{Command, NotAllowed, Refusal, Why};
use identifier_core::parameters::{Term, Terms};
use support::commission::ORDER;
use support::drive::{Drive, SERVO};
use support::{Bench, Flash, first_contact, settings};

/// What a drive says to a command that only a build with a part obeys.
fn answer_of(part: &str, has_part: bool, command: Command) {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    let mut drive = Drive::boot(bench, &flash);
    if has_part {
        return drive.done(command);
    }
    let refusal = drive.refusal(command);
    assert_eq!(
        refusal,
        Refusal::Setting(NotAllowed::new(part, Why::NotBuilt))
    );
    assert!(refusal.to_string().contains(&format!("feature {part}")));
    // What it was asked for leaves it as it was.
    drive.run(settings());
    drive.pass(20_000);
    drive.done(Command::Stop);
    drive.pass(1);
    let found = drive.supervisor.estimates().expect("estimates");
    assert!((found.servo.b / SERVO.b - 1.0).abs() < 0.02, "{found:?}");
}

#[test]
fn a_build_without_commissioning_says_so_and_identifies() {
    let order = Command::Commission(ORDER);
    answer_of("commissioning", cfg!(feature = "commissioning"), order);
}

#[test]
fn a_build_without_terms_says_so_and_identifies() {
    let mut wanted = first_contact();
    wanted.closed_loop.core.identifier.terms.demanded = Terms::NONE.with(Term::Delay);
    let order = Command::Configure(wanted);
    answer_of("terms", cfg!(feature = "terms"), order);
}
