//! The evidence for the estimates of a run, as the core's verdict asks for it.

use crate::verdict::{Evidence, MissingEffect, Motion, UnknownEvidence, Verdict, VerdictReason};
use identifier_core::parameters::{Parameter, ServoParameters, Term, Terms, Unknown};
use identifier_core::stability::{SampledLoop, SampledLoopError};

use super::assessment::Assessment;
use crate::experiment::{AbortCause, Outcome, TermEstimate};
use crate::motion_unit::MotionUnit;
use crate::result::Estimate;

/// The fraction of slowed samples from which a result says that the guard sets the pace.
const MAX_SLOWED_SHARE: f64 = 0.5;

/// The sources of the evidence.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    pub(super) motion: Motion,
    pub(super) outcome: &'a Outcome,
    /// The terms that are required.
    pub(super) required: Terms,
    /// The parameters that are estimated, their values, and how each went, with a tolerance.
    pub(super) parameters: &'a [Parameter],
    pub(super) servo: &'a ServoParameters,
    pub(super) course: &'a dyn Fn(Parameter, f64) -> Estimate,
    pub(super) assessment: Option<&'a Assessment>,
}

/// The evidence.
pub(super) fn gather(known: &Known<'_>) -> Evidence {
    let (outcome, assessment, servo) = (known.outcome, known.assessment, known.servo);
    let mut evidence = Evidence::from_motion(known.motion);
    evidence.aborted = outcome.abort.is_some();
    evidence.rejection_reason = outcome.rejection_reason;
    evidence.missing_term = Term::ALL.into_iter().find(|&term| {
        let has_size = |estimate: &TermEstimate| estimate.unknown.term() == Some(term);
        let has_entered = outcome.entered.iter().any(|(entered, _)| *entered == term)
            || outcome.terms.iter().any(has_size);
        known.required.has(term) && !has_entered
    });
    let b = match known.parameters.contains(&Parameter::B) {
        true => servo.b,
        false => 0.0,
    };
    let begin = |unknown: Unknown, estimate: f64| {
        let asked = assessment.and_then(|found| found.of(unknown));
        let scale = assessment.map_or(0.0, |found| found.scales.scale_of(unknown, b));
        UnknownEvidence {
            estimate,
            std_error: Some(asked.map_or(f64::INFINITY, |asked| asked.std_error)),
            refit_difference: asked.map(|asked| asked.refit_difference),
            needs_more_amplitudes: asked.is_some_and(|asked| asked.needs_more_amplitudes),
            ..UnknownEvidence::at(scale)
        }
    };
    let finding = assessment.and_then(|found| found.finding.as_ref());
    for &parameter in known.parameters {
        let unknown = Unknown::from(parameter);
        let mut of = begin(unknown, servo.get(parameter));
        let tolerance = of.still(unknown);
        let course = (known.course)(parameter, tolerance);
        // Where the data have an estimate that moved, it has arrived.
        if !of.is_in_place(unknown, finding.is_some()) {
            of.movement = course.tail_std.max(course.remaining_change);
        }
        of.at_bound = course.at_bound;
        evidence.add(unknown, of);
    }
    for TermEstimate { unknown, value, .. } in &outcome.terms {
        evidence.add(*unknown, begin(*unknown, *value));
    }
    evidence.residual = assessment.and_then(|found| found.residual);
    evidence.lack = finding.map(|finding| {
        let cause = finding.or.is_none().then_some(finding.cause);
        let share = finding.share;
        MissingEffect { cause, share }
    });
    evidence
}

/// The verdict in words, with why a fit was refused, if one was, and what else a user should know.
pub(super) fn reason(
    verdict: &Verdict,
    refused: Option<VerdictReason>,
    unit: MotionUnit,
    unstable_loop: Option<SampledLoopError>,
    outcome: &Outcome,
) -> String {
    if let Some(abort) = &outcome.abort {
        let cause = match unstable_loop {
            Some(unstable) if abort.cause != AbortCause::NoReading => unstable.to_string(),
            _ => abort.cause.to_string(),
        };
        return format!("aborted after {:.3} s: {cause}", abort.time);
    }
    let mut reason = verdict.reason.text(unit);
    if let Some(refused) = refused {
        reason.push_str(&format!("; for the exact fit: {}", refused.text(unit)));
    }
    let slowed = outcome.events.slowed as f64 / outcome.samples.max(1) as f64;
    if slowed > MAX_SLOWED_SHARE {
        reason.push_str(&format!(
            "; the guard slowed {:.0} % of the updates: gamma is too large for the sample time",
            100.0 * slowed
        ));
    }
    if let Some(margin) = outcome.gain_margin
        && margin < SampledLoop::AMPLE_GAIN_MARGIN
    {
        reason.push_str(&format!(
            "; the sampled loop has a gain margin of only {margin:.1} over the parameter range: below {} the \
             estimates may wander, so sample faster or lower the gains",
            SampledLoop::AMPLE_GAIN_MARGIN
        ));
    }
    if let Err(unstated) = unit.axis() {
        reason.push_str(&format!("; {unstated}"));
    }
    let events = &outcome.events;
    if events.restarted > 0 {
        reason.push_str(&format!(
            "; its errors were too large for too long, and the model was restarted: {}",
            match events.restarted {
                1 => "once".to_owned(),
                times => format!("{times} times"),
            }
        ));
    }
    if events.not_following > 0 {
        reason.push_str(&format!(
            "; in {} samples the servo did not follow its command: check the amplifier, and that the \
             command is the one that acted",
            events.not_following
        ));
    }
    reason
}
