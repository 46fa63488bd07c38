//! The verdict on a run: whether the estimates have come to rest, and why it is thought so.

use identifier_core::parameters::Parameter;
use identifier_core::stability::sampled_loop::AMPLE_GAIN_MARGIN;

use super::estimate::{Estimate, tolerance, unit};
use crate::experiment::Outcome;
use crate::scenario::Scenario;

/// An estimate nearer to zero than this fraction of its tolerance is none.
const AT_ZERO: f64 = 0.5;

/// The fraction of slowed samples from which a result says that the guard sets the pace.
const MOSTLY_SLOWED: f64 = 0.5;

/// The parameters in the order of a run's estimates.
pub(super) const PARAMETERS: [Parameter; 4] = [
    Parameter::A,
    Parameter::B,
    Parameter::Coulomb,
    Parameter::Load,
];

/// Whether the estimates have come to rest. The truth plays no part in it: a drive does not know
/// it either.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Over the last quarter every estimate kept still.
    Converged,
    /// Some estimate still moved.
    NotConverged,
    /// The run ended early.
    Aborted,
}

impl Status {
    /// The status's name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::NotConverged => "not-converged",
            Self::Aborted => "aborted",
        }
    }
}

/// The status of a run, with the reason and what else a user should know; `acceleration` is what
/// friction and load are small beside, rad/s².
pub(super) fn verdict(
    estimates: &[Estimate; 4],
    scenario: &Scenario,
    acceleration: f64,
    outcome: &Outcome,
) -> (Status, String) {
    if let Some(abort) = &outcome.abort {
        let cause = match scenario.unstable_loop() {
            Some(unstable) => unstable.to_string(),
            None => abort.error.to_string(),
        };
        return (
            Status::Aborted,
            format!("aborted after {:.3} s: {cause}", abort.time),
        );
    }
    if estimates.iter().any(|estimate| !estimate.last.is_finite()) {
        let why = outcome
            .failure
            .unwrap_or("what it found at the end cannot be a servo");
        return (Status::NotConverged, format!("no estimate: {why}"));
    }
    let of_law = PARAMETERS
        .into_iter()
        .zip(estimates)
        .filter(|(parameter, _)| scenario.identifier.estimates(*parameter))
        .map(|(parameter, estimate)| {
            let limit = tolerance(parameter, estimate.tail_mean, acceleration);
            (parameter, estimate, limit)
        });
    let restless = of_law
        .clone()
        .find(|(_, estimate, limit)| estimate.tail_std.max(estimate.to_go) > *limit);
    // A lower bound of zero on friction is no obstacle but a fact: it is never negative.
    let held = of_law.clone().find(|(_, estimate, limit)| {
        estimate.at_bound && estimate.tail_mean.abs() > AT_ZERO * limit
    });
    let (status, mut reason) = match (restless, held) {
        (None, None) => (
            Status::Converged,
            "every estimate kept still over the last quarter of the run".to_owned(),
        ),
        (Some((parameter, estimate, limit)), _) => (
            Status::NotConverged,
            format!(
                "{} still moved over the last quarter of the run: standard deviation {:.4}, \
                 distance to go {:.4}, at rest below {limit:.4} {}",
                parameter.name(),
                estimate.tail_std,
                estimate.to_go,
                unit(parameter)
            ),
        ),
        (None, Some((parameter, estimate, _))) => (
            Status::NotConverged,
            format!(
                "{} = {:.4} {} stands at a bound: widen it, or look for what the model lacks",
                parameter.name(),
                estimate.tail_mean,
                unit(parameter),
            ),
        ),
    };
    let slowed = outcome.events.slowed as f64 / outcome.samples.max(1) as f64;
    if slowed > MOSTLY_SLOWED {
        reason.push_str(&format!(
            "; the guard slowed {:.0} % of the updates: gamma is larger than the sample time bears",
            100.0 * slowed
        ));
    }
    if let Some(margin) = outcome.gain_margin
        && margin < AMPLE_GAIN_MARGIN
    {
        reason.push_str(&format!(
            "; the sampled loop keeps a gain margin of only {margin:.1} over the box: below \
             {AMPLE_GAIN_MARGIN} the estimates may wander, sample faster or lower the gains"
        ));
    }
    let events = &outcome.events;
    if events.restarted > 0 {
        reason.push_str(&format!(
            "; the model loop ran away and was started again {} times: check gains and sample time",
            events.restarted
        ));
    }
    if events.not_following > 0 {
        reason.push_str(&format!(
            "; in {} samples the servo did not follow its command: check the amplifier, and that the \
             command is the one that acted",
            events.not_following
        ));
    }
    (status, reason)
}
