//! The end of a run looked at once more, as a batch: the model with the final estimates, driven by the
//! recorded command, with what a unit of each unknown, and of everything that a model may lack, would do
//! to its output error.
//!
//! It needs no model of the law's own, so every law is judged alike. All is whitened; standard errors
//! are by groups of samples, so that they count what colour is left.

mod candidates;
mod effect;
mod least_squares;
mod pass;
mod plan;
mod ringing;
mod score;
mod whitening;

use identifier_core::parameters::{PerQuantity, ServoParameters, Unknown};

use super::stretch::Kept;
use crate::experiment::TermEstimate;
use crate::result::{Finding, Residual};
use crate::scenario::Scenario;
use effect::Effect;
use least_squares::{Basis, dot};
use pass::{Blocks, pass};
use plan::Prepared;
use whitening::Whitening;

/// The run that is judged.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judged<'a> {
    pub(super) scenario: &'a Scenario,
    /// The estimates; of what is not estimated, what the model takes for it.
    pub(super) servo: ServoParameters,
    /// The terms that have entered.
    pub(super) terms: &'a [TermEstimate],
    /// The unknowns that are estimated.
    pub(super) unknowns: &'a [Unknown],
}

/// The extent of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Effort {
    /// Samples at most.
    pub(super) samples: usize,
    /// Blocks of samples at most.
    pub(super) blocks: usize,
}

impl Effort {
    /// For a single result.
    pub(super) const THOROUGH: Self = Self {
        samples: 1 << 17,
        blocks: 1 << 14,
    };
    /// For one of many.
    pub(super) const BRIEF: Self = Self {
        samples: 1 << 13,
        blocks: 1 << 12,
    };
}

/// The evidence of the end of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Batch {
    /// Of every unknown that is estimated.
    pub(super) unknowns: Vec<Asked>,
    /// The output error of the model.
    pub residual: Residual,
    /// Effects that the model may lack, by the part of the output error that they explain, most first; empty
    /// where the output error is the encoder's.
    pub findings: Vec<Finding>,
    /// The usual sizes beside which unknowns act.
    pub(super) scales: Scales,
}

/// A batch's evidence on an unknown, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Asked {
    pub(super) unknown: Unknown,
    /// The step of Gauss and Newton in it.
    pub(super) pull: f64,
    /// Infinite where the motion says nothing of it.
    pub(super) std_error: f64,
}

/// Usual sizes of the motion, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scales {
    /// Deviation of the velocity, rad/s.
    pub(super) velocity: f64,
    /// Deviation of the command.
    pub(super) command: f64,
    /// Deviation of the position, rad.
    pub(super) position: f64,
}

impl Scales {
    /// The size beside which an error of an unknown is small or large, in its unit.
    pub(super) fn scale_of(&self, unknown: Unknown, b: f64) -> f64 {
        let acceleration = b.abs() * self.command;
        let rate = acceleration / self.velocity.max(f64::MIN_POSITIVE);
        let scales = PerQuantity {
            rate,
            gain: b.abs(),
            acceleration,
            time: 1.0 / rate.max(f64::MIN_POSITIVE),
            command: self.command,
        };
        scales.get(unknown)
    }
}

/// The share of an encoder's rounding that may go with the motion, as if it were no noise at all, where the
/// position's deviation is one count: what no length of a run averages out. It falls with the square
/// root of the deviation, as the first harmonic of a rounded sine does (the asymptote of Bessel's
/// function).
const SYSTEMATIC_ROUNDING: f64 = 0.3;

/// The lowest frequency at which resonances are looked for, over the bandwidth of the correction.
const LOWEST_RESONANCE: f64 = 3.0;

/// Groups of samples from which standard errors are taken.
const GROUPS: usize = 32;

impl Batch {
    /// Looks at the end of a run; none where there is too little of it, or the estimates are no servo
    /// that a model can follow.
    pub(super) fn evaluate(
        judged: &Judged<'_>,
        samples: impl ExactSizeIterator<Item = Kept> + Clone,
        effort: Effort,
    ) -> Option<Self> {
        let prepared = Prepared::new(judged, samples, effort)?;
        let own: Vec<Effect> = judged.unknowns.iter().copied().map(Effect::Own).collect();
        let first = pass(&prepared.recorded, &prepared.plan, &own);
        let units = judged.scenario.units();
        let residual = Residual {
            rms: first.rms * units.position_unit(),
            resolution_rms: units.position_unit() / 12.0_f64.sqrt(),
            correlation: first.correlation,
        };
        if !first.rms.is_finite() || first.error.len() < 2 * GROUPS {
            return None;
        }
        let swing = prepared.scales.position * units.position();
        let fit = Fit::new(&first, swing);
        let findings = if residual.is_the_encoders() {
            Vec::new()
        } else {
            let block = prepared.plan.block as f64;
            let from = LOWEST_RESONANCE * prepared.plan.omega * block;
            let ringing =
                ringing::frequency(&fit.unexplained, from).map(|per_block| per_block / block);
            let candidates = candidates::all(judged, &prepared, residual.is_large(), ringing);
            let effects: Vec<Effect> = candidates.iter().flatten().copied().collect();
            let blocks = pass(&prepared.recorded, &prepared.plan, &effects);
            score::findings(judged, &fit, &candidates, &blocks.columns, swing)
        };
        Some(Self {
            unknowns: fit.asked(judged),
            residual,
            findings,
            scales: prepared.scales,
        })
    }
}

/// One step of Gauss and Newton from the estimates, machine units.
struct Fit {
    whitening: Whitening,
    /// The unknowns' columns, whitened.
    own: Basis,
    /// The step of the unknowns.
    step: Vec<f64>,
    /// The output error that the unknowns leave, unwhitened.
    unexplained: Vec<f64>,
    /// The whitened output error that they leave.
    rest: Vec<f64>,
    std_errors: Vec<f64>,
}

impl Fit {
    /// `swing` is the deviation of the position, counts.
    fn new(blocks: &Blocks, swing: f64) -> Self {
        let plain = Basis::new(blocks.columns.clone());
        let mut unexplained = blocks.error.clone();
        plain.take_from(&mut unexplained);
        let whitening = Whitening::new(&unexplained);
        let whitened = |column: &Vec<f64>| whitening.apply(column);
        let own = Basis::new(blocks.columns.iter().map(whitened).collect());
        let mut rest = whitening.apply(&blocks.error);
        let step = own.multiples(&own.take_from(&mut rest));
        let std_errors = std_errors(&own, &plain, &rest, swing);
        Self {
            whitening,
            own,
            step,
            unexplained,
            rest,
            std_errors,
        }
    }

    fn asked(&self, judged: &Judged<'_>) -> Vec<Asked> {
        let units = judged.scenario.units();
        let of = |(i, &unknown): (usize, &Unknown)| Asked {
            unknown,
            pull: self.step[i] / unknown.scale(&units),
            std_error: self.std_errors[i] / unknown.scale(&units),
        };
        judged.unknowns.iter().enumerate().map(of).collect()
    }
}

/// The standard errors: by how far groups of samples disagree, at least what white noise of the rest's
/// size would give; and what rounding does that goes with the motion.
fn std_errors(own: &Basis, plain: &Basis, rest: &[f64], swing: f64) -> Vec<f64> {
    let count = own.len();
    let groups = own.in_groups(rest, GROUPS);
    let freedom = (groups.len() as f64 / (groups.len() as f64 - count as f64).max(1.0)).max(1.0);
    let white = dot(rest, rest) / (rest.len() as f64 - count as f64).max(1.0);
    let mut by_groups = vec![0.0; count];
    for group in &groups {
        for (sum, multiple) in by_groups.iter_mut().zip(own.multiples(group)) {
            *sum += multiple * multiple * freedom;
        }
    }
    let by_noise = own.variances();
    let rounding =
        SYSTEMATIC_ROUNDING * SYSTEMATIC_ROUNDING / swing.max(1.0) / 12.0 * rest.len() as f64;
    let by_rounding = plain.variances();
    (0..count)
        .map(|i| {
            if own.is_known(i) && plain.is_known(i) {
                let chance = by_groups[i].max(white * by_noise[i]);
                (chance + rounding * by_rounding[i]).sqrt()
            } else {
                f64::INFINITY
            }
        })
        .collect()
}
