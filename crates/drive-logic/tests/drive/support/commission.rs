//! Orders to commission, and their outcomes.

use commissioning::{CommissionSettings, Limits, Phase};
use drive_link::{Command, Commissioning, Fault, Origin, Outcome, Report, Settings, State, Status};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use identifier_core::tuning::Goal;

use super::drive::Drive;
use super::harms::{self, Harm};
use super::{Bench, COUNTS, Flash, SAMPLE_TIME, settings};

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

/// A harm, the number of its reason, and its fault, if it is one.
pub(crate) const HARMS: [(Harm, u8, Option<Fault>); 8] = [
    (harms::stop, 170, None),
    (|drive| drive.ends_commissioning(Command::Start), 171, None),
    (
        |drive| drive.ends_commissioning(Command::Configure(settings())),
        171,
        None,
    ),
    (harms::high_switch_opens, 11, Some(Fault::LimitSwitch)),
    (harms::amplifier_fails, 10, Some(Fault::AmplifierFault)),
    (harms::supply_sags, 13, Some(Fault::SupplyLow)),
    (harms::samples_are_late, 30, None),
    (harms::encoder_fails, 20, Some(Fault::EncoderLost)),
];

/// The outcome of a commissioning that ended in a phase for the reason of a number.
pub(crate) fn cut_short(drive: &mut Drive, phase: Phase, number: u8) -> Outcome {
    let came_to = outcome(drive);
    let Commissioning { phase: end, reason } = came_to.commissioning;
    let wanted: &[Phase] = match phase {
        Phase::Trial => &[Phase::RolledBack],
        // A trial may follow before the harm shows.
        Phase::Gains => &[Phase::Aborted, Phase::RolledBack],
        _ => &[Phase::Aborted],
    };
    assert!(wanted.contains(&end), "{end:?} in {phase:?}");
    assert_eq!(reason.map(Reason::number), Some(number), "in {phase:?}");
    came_to
}

/// The longest commissioning, s.
const MAX_TIME: f64 = 60.0;

/// Runs until the commissioning has ended.
pub(crate) fn over(drive: &mut Drive) -> Vec<Report> {
    let mut reports = Vec::new();
    for _ in 0..drive.bench.samples(MAX_TIME) {
        reports.extend(drive.pass(1));
        if drive.state() != State::Commissioning {
            return reports;
        }
    }
    panic!("the commissioning has no end: {:?}", drive.status());
}

/// Runs until it has ended: its outcome.
pub(crate) fn ended(drive: &mut Drive) -> Outcome {
    over(drive);
    outcome(drive)
}

/// A whole one: its outcome.
pub(crate) fn commission(drive: &mut Drive, order: CommissionSettings) -> Outcome {
    drive.done(Command::Commission(order));
    ended(drive)
}

/// Begins one, and runs until it reports a phase.
pub(crate) fn commission_until(drive: &mut Drive, order: CommissionSettings, phase: Phase) {
    drive.done(Command::Commission(order));
    until(drive, phase);
}

/// The end of one that was aborted for a reason.
pub(crate) const fn aborted(reason: Reason) -> Commissioning {
    Commissioning {
        phase: Phase::Aborted,
        reason: Some(reason),
    }
}

/// Outcome of the last commissioning.
pub(crate) fn outcome(drive: &mut Drive) -> Outcome {
    match drive.ask(Command::Outcome) {
        Report::Outcome { outcome, .. } => outcome,
        other => panic!("{other:?} is no outcome"),
    }
}

/// The flash of a drive that was configured and saved.
pub(crate) fn ready() -> Vec<u8> {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    let mut drive = Drive::boot(bench, &flash);
    drive.done(Command::Save);
    flash.bytes.borrow().clone()
}

/// Runs, with requests that keep the link alive, until the drive reports a phase.
pub(crate) fn until(drive: &mut Drive, phase: Phase) {
    for _ in 0..drive.bench.samples(MAX_TIME) {
        drive.ask(Command::KeepAlive);
        for report in drive.pass(1) {
            if let Report::Status { status, .. } = report
                && let Some(stands) = status.commissioning
            {
                assert!(
                    !stands.phase.is_end(),
                    "{stands} {:?} before {phase:?}",
                    drive.state()
                );
                if stands.phase == phase {
                    return;
                }
            }
        }
    }
    panic!("it never comes to {phase:?}");
}

/// Cuts the power after every step of the flash of a commissioning: afterwards the settings before are in force, without
/// estimates, or those that it leaves. Each status is checked further, with whether the settings are the new ones.
pub(crate) fn cut_anywhere(
    servo: &ServoParameters,
    cold: &[u8],
    old: &Settings,
    commissioned: impl Fn(&Flash) -> Settings,
    check: impl Fn(&Status, bool, usize),
) {
    let whole = Flash::with(cold.to_vec());
    let new = commissioned(&whole);
    assert_ne!(new, *old);
    let (mut old_holds, mut new_holds) = (0, 0);
    for cut in 0..=whole.steps.get() {
        let flash = Flash::with(cold.to_vec());
        flash.steps_left.set(cut);
        commissioned(&flash);
        let mut drive = Drive::as_it_comes(Bench::new(servo), &flash.powered_again());
        let (shown, status) = (drive.shown(), drive.status());
        let is_new = shown == new;
        assert!(is_new || shown == *old, "cut after {cut}: a mixture");
        let origin = if is_new {
            Origin::Commissioned
        } else {
            Origin::Given
        };
        assert_eq!(
            status.gains.map(|gains| gains.origin),
            Some(origin),
            "cut after {cut}"
        );
        assert_eq!(status.estimates.is_some(), is_new, "cut after {cut}");
        check(&status, is_new, cut);
        *if is_new {
            &mut new_holds
        } else {
            &mut old_holds
        } += 1;
    }
    assert!(old_holds > 100 && new_holds > 0, "{old_holds}, {new_holds}");
}
