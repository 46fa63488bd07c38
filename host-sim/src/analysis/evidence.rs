//! The evidence for the estimates of a run, as the core's verdict asks for it.

use crate::verdict::{Evidence, Lack, Motion, Residual, UnknownEvidence, Verdict};
use identifier_core::parameters::{Parameter, Term, Terms, Unknown};
use identifier_core::stability::SampledLoop;

use super::batch::Batch;
use super::estimate::Tracked;
use super::whole_record::WholeRecord;
use crate::experiment::{AbortCause, Outcome, TermEstimate};
use crate::result::{Finding, Residual as Left};
use crate::scenario::Scenario;

/// A finding that explains less of the rest than this is none.
const MIN_SHARE: f64 = 0.04;

/// Standard errors by which a finding must differ from nothing.
const MIN_SIGNIFICANCE: f64 = 4.0;

/// A finding stands out if what it leaves over is this much smaller than what the next leaves.
const MAX_REST_RATIO: f64 = 0.97;

/// The fraction of slowed samples from which a result says that the guard sets the pace.
const MAX_SLOWED_SHARE: f64 = 0.5;

/// The sources of the evidence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known<'a> {
    pub(super) motion: Motion,
    pub(super) outcome: &'a Outcome,
    /// The terms that are required.
    pub(super) required: Terms,
    /// The parameters that are estimated, and how each went.
    pub(super) parameters: &'a [(Parameter, &'a Tracked, f64)],
    pub(super) batch: Option<&'a Batch>,
    pub(super) whole: Option<&'a WholeRecord>,
}

/// The evidence.
pub(super) fn gather(known: &Known<'_>) -> Evidence {
    let Known {
        motion,
        outcome,
        required,
        parameters,
        batch,
        whole,
    } = *known;
    let mut evidence = Evidence::from_motion(motion);
    evidence.aborted = outcome.abort.is_some();
    evidence.obstacle = outcome.obstacle;
    evidence.missing_term = Term::ALL.into_iter().find(|&term| {
        let has_size = |estimate: &TermEstimate| estimate.unknown.term() == Some(term);
        let has_entered = outcome.entered.iter().any(|(entered, _)| *entered == term)
            || outcome.terms.iter().any(has_size);
        required.has(term) && !has_entered
    });
    let b = parameters
        .iter()
        .find(|(parameter, ..)| *parameter == Parameter::B)
        .map_or(0.0, |(.., value)| *value);
    let scales = batch
        .map(|batch| &batch.scales)
        .or(whole.map(|whole| &whole.scales));
    evidence.fit = whole.map(|whole| whole.evidence);
    let begin = |unknown: Unknown, estimate: f64| {
        let asked = batch.and_then(|batch| batch.unknowns.iter().find(|of| of.unknown == unknown));
        UnknownEvidence {
            estimate,
            // An unknown that the batch lacks has an infinite standard error.
            std_error: Some(match whole {
                Some(whole) => whole.std_error(unknown),
                None => asked.map_or(f64::INFINITY, |asked| asked.std_error),
            }),
            pull: asked.map(|asked| asked.pull),
            ..UnknownEvidence::at(scales.map_or(0.0, |scales| scales.scale_of(unknown, b)))
        }
    };
    for (parameter, tracked, value) in parameters {
        let unknown = Unknown::from(*parameter);
        let mut of = begin(unknown, *value);
        let tolerance = of.still(unknown);
        let course = tracked.estimate(|_| tolerance);
        of.movement = course.tail_std.max(course.to_go);
        of.at_bound = course.at_bound;
        evidence.add(unknown, of);
    }
    for TermEstimate { unknown, value, .. } in &outcome.terms {
        evidence.add(*unknown, begin(*unknown, *value));
    }
    if let Some(batch) = batch {
        let Left {
            rms,
            resolution_rms,
            correlation,
        } = batch.residual;
        evidence.residual = Some(Residual {
            beyond_encoder: rms / resolution_rms,
            correlation,
        });
        evidence.lack = lack(batch);
    }
    evidence
}

/// The lack of the model: the finding that stands out, or else that something does.
fn lack(batch: &Batch) -> Option<Lack> {
    let found = batch
        .findings
        .iter()
        .find(|finding| is_significant(finding))?;
    let cause = cause(batch).map(|named| named.cause);
    Some(Lack::new(cause, found.share, &found.shifts))
}

fn is_significant(finding: &Finding) -> bool {
    finding.share >= MIN_SHARE && finding.significance >= MIN_SIGNIFICANCE
}

/// The finding that stands out, if one does.
pub(super) fn cause(batch: &Batch) -> Option<&Finding> {
    let mut significant = batch
        .findings
        .iter()
        .filter(|finding| is_significant(finding));
    let best = significant.next()?;
    let left = |finding: &Finding| 1.0 - finding.share;
    let stands_out = significant
        .next()
        .is_none_or(|next| left(best) < MAX_REST_RATIO * left(next));
    stands_out.then_some(best)
}

/// The verdict in words, with what else a user should know.
pub(super) fn reason(verdict: &Verdict, scenario: &Scenario, outcome: &Outcome) -> String {
    if let Some(abort) = &outcome.abort {
        let cause = match scenario.unstable_loop() {
            Some(unstable) if abort.cause != AbortCause::NoReading => unstable.to_string(),
            _ => abort.cause.to_string(),
        };
        return format!("aborted after {:.3} s: {cause}", abort.time);
    }
    let mut reason = verdict.reason.to_string();
    if let Some(failure) = outcome.failure {
        reason.push_str(&format!(": {failure}"));
    }
    let slowed = outcome.events.slowed as f64 / outcome.samples.max(1) as f64;
    if slowed > MAX_SLOWED_SHARE {
        reason.push_str(&format!(
            "; the guard slowed {:.0} % of the updates: gamma is larger than the sample time bears",
            100.0 * slowed
        ));
    }
    if let Some(margin) = outcome.gain_margin
        && margin < SampledLoop::AMPLE_GAIN_MARGIN
    {
        reason.push_str(&format!(
            "; the sampled loop keeps a gain margin of only {margin:.1} over the box: below \
             {} the estimates may wander, sample faster or lower the gains",
            SampledLoop::AMPLE_GAIN_MARGIN
        ));
    }
    let events = &outcome.events;
    if events.restarted > 0 {
        reason.push_str(&format!(
            "; on the way its errors were too large for too long, and the model was started again: {}",
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
