//! Orders to commission, and their outcomes.

use commissioning::{CommissionSettings, Limits, Phase};
use drive_link::{Command, Fault, Outcome, Report, State};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use identifier_core::tuning::Goal;

use super::drive::Drive;
use super::{Bench, COUNTS, Flash, SAMPLE_TIME};

/// A servo that lies still when it is released.
pub(crate) const SERVO: ServoParameters = ServoParameters {
    a: 0.2174,
    b: 257.7,
    coulomb: 15.0,
    load: 0.0,
};

/// The servo with its inertia and its friction times these factors.
pub(crate) fn changed(inertia: f64, friction: f64) -> ServoParameters {
    ServoParameters {
        a: SERVO.a / inertia,
        b: SERVO.b / inertia,
        coulomb: friction * SERVO.coulomb / inertia,
        load: SERVO.load / inertia,
    }
}

/// An order that fits it and the settings of the bench.
pub(crate) const ORDER: CommissionSettings = CommissionSettings {
    goal: Goal::Bandwidth(40.0),
    ..CommissionSettings::new(
        SAMPLE_TIME,
        core::f64::consts::TAU / COUNTS,
        Limits {
            duration: 2.0,
            ..Limits::new([-2.0, 2.0], 60.0, [-10.0, 10.0])
        },
    )
};

/// The phases in which something may come between, in their order.
pub(crate) const PHASES: [Phase; 6] = [
    Phase::Rest,
    Phase::Probe,
    Phase::Fit,
    Phase::FrequencyResponse,
    Phase::Gains,
    Phase::Trial,
];

/// The longest commissioning, samples.
const MAX_SAMPLES: u32 = 60_000;

/// Runs until the commissioning has ended.
pub(crate) fn over(drive: &mut Drive<'_>) -> Vec<Report> {
    let mut reports = Vec::new();
    for _ in 0..MAX_SAMPLES {
        reports.extend(drive.pass(1));
        if drive.supervisor.state() != State::Commissioning {
            return reports;
        }
    }
    panic!("the commissioning has no end: {:?}", drive.status());
}

/// Sends nothing more: the stage is disabled, and state and outcome give the reason.
pub(crate) fn link_falls_silent(drive: &mut Drive<'_>, bench: &Bench, phase: Phase) {
    over(drive);
    assert_eq!(bench.held.get(), None, "{phase:?}");
    let silent = State::Faulted(Fault::LinkLost);
    assert_eq!(drive.supervisor.state(), silent, "{phase:?}");
    let reason = outcome(drive).commissioning.reason;
    assert_eq!(reason, Some(Reason::LinkLost), "{phase:?}");
}

/// Outcome of the last commissioning.
pub(crate) fn outcome(drive: &mut Drive<'_>) -> Outcome {
    match drive.ask(Command::Outcome) {
        Report::Outcome { outcome, .. } => outcome,
        other => panic!("{other:?} is no outcome"),
    }
}

/// The flash of a drive that was configured and saved.
pub(crate) fn ready() -> Vec<u8> {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    boot!(drive, &bench, &flash);
    drive.done(Command::Save);
    flash.bytes.borrow().clone()
}

/// Runs, with requests that keep the link alive, until the drive reports a phase.
pub(crate) fn until(drive: &mut Drive<'_>, phase: Phase) {
    for _ in 0..MAX_SAMPLES {
        drive.ask(Command::KeepAlive);
        for report in drive.pass(1) {
            if let Report::Status { status, .. } = report
                && let Some(stands) = status.commissioning
            {
                assert!(
                    !stands.phase.is_end(),
                    "{stands} {:?} before {phase:?}",
                    drive.supervisor.state()
                );
                if stands.phase == phase {
                    return;
                }
            }
        }
    }
    panic!("it never comes to {phase:?}");
}
