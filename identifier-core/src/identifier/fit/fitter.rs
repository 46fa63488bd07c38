use super::pass::{Pass, direction};
use super::record::Record;
use super::survey::{MOVED, Survey};
use super::trial::Best;
use super::{A, COULOMB, FitResult, UNKNOWNS};
use crate::model::{FrictionStep, Innovation};
use crate::number::Number;

/// Levenberg–Marquardt fit of the model, driven by the recorded command, to the recorded motion.
///
/// **Start.** With the model's parameters at zero and the *measured* motion in place of its own, the
/// output error is linear in the parameters, and the tangents are its regressors: one pass gives a
/// least-squares estimate that needs no first guess (equation error behind the filter 1/(p + ω)²;
/// Young, Recursive Estimation and Time-Series Analysis, 2nd edition 2011, chapter 8). It is solved
/// with and without friction. Given initial values are further starts, and if none of these explains
/// the motion, a geometric series of gains is tried.
///
/// **Passes.** From each start at most [`Fitter::PASSES`] passes of the
/// [`ListeningModel`](crate::model::ListeningModel); the start that explains the motion best wins. The
/// correction of the model keeps its output error bounded for every trial.
///
/// All is computed in units of a block: with m samples to a block, a m T, b (m T)²/ρ and so on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fitter<N> {
    pub(super) step: FrictionStep<N>,
    /// Variance of the position noise, counts².
    pub(super) noise: N,
    pub(super) low: [N; 4],
    pub(super) high: [N; 4],
    /// The given initial values.
    pub(super) prior: Prior<N>,
    pub(super) free: [bool; 4],
    /// Units of a block per unit of a sample.
    pub(super) scale: [f64; 4],
    pub(super) bandwidth: Option<N>,
}

/// What a fitter is made from, machine units of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FitterConfig {
    pub(crate) block: u32,
    pub(crate) noise: f64,
    pub(crate) low: [f64; 4],
    pub(crate) high: [f64; 4],
    pub(crate) initial: [Option<f64>; 4],
    pub(crate) deviation: [Option<f64>; 4],
    /// Parameters that are fitted; the others keep their initial value, or zero.
    pub(crate) free: [bool; 4],
    pub(crate) bandwidth: Option<f64>,
}

/// What is known before a fit, units of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Prior<N> {
    /// Initial values: one more start.
    pub(super) initial: [Option<N>; 4],
    /// Standard deviation of the noise over those of the initial values; zero where nothing is known.
    pub(super) weight: [N; 4],
}

/// A fit under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit<N> {
    pub(super) prior: Prior<N>,
    pub(super) blocks: usize,
    pub(super) next: usize,
    pub(super) stage: Stage,
    pub(super) survey: Survey<N>,
    pub(super) omega: N,
    pub(super) correction: Innovation<N>,
    pub(super) pass: Pass<N>,
    pub(super) linear: [[N; UNKNOWNS]; 2],
    /// The cost of a model at rest.
    pub(super) standing_cost: N,
    pub(super) trial: [N; UNKNOWNS],
    pub(super) damping: N,
    pub(super) passes: u32,
    pub(super) this: Option<Best<N>>,
    pub(super) best: Option<Best<N>>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stage {
    Survey,
    Linear,
    From(u32),
}

impl<N: Number> Fitter<N> {
    /// The most passes from one start.
    pub(super) const PASSES: u32 = 12;

    /// Levenberg's and Marquardt's damping at the start.
    pub(super) const FIRST_DAMPING: f64 = 1e-3;

    /// A fit explains the motion if the variance of the errors is below this many times the
    /// encoder's; then no further start is tried.
    const EXPLAINED: f64 = 2.0;

    pub(crate) fn new(config: &FitterConfig) -> Self {
        let m = f64::from(config.block.max(1));
        let scale = [m, m * m, m * m, m * m];
        let of = |values: &[f64; 4]| core::array::from_fn(|i| N::from_f64(values[i] * scale[i]));
        let mut high: [N; 4] = of(&config.high);
        let most = N::from_f64(crate::model::ZeroOrderHoldStep::<N>::LARGEST_RATE);
        high[A] = high[A].limited(-most, most);
        let mut low: [N; 4] = of(&config.low);
        low[A] = low[A].limited(-most, most);
        Self {
            step: FrictionStep::new(),
            noise: N::from_f64(config.noise),
            low,
            high,
            prior: Prior {
                initial: core::array::from_fn(|i| {
                    config.initial[i].map(|value| N::from_f64(value * scale[i]))
                }),
                weight: core::array::from_fn(|i| {
                    N::from_f64(config.deviation[i].map_or(0.0, |deviation| {
                        libm::sqrt(config.noise) / (deviation * scale[i])
                    }))
                }),
            },
            free: config.free,
            scale,
            bandwidth: config.bandwidth.map(|omega| N::from_f64(omega * m)),
        }
    }

    /// The prior from the settings.
    pub(crate) fn given(&self) -> Prior<N> {
        self.prior
    }

    /// A fit result as the prior of the next fit: with ten times its standard deviations, and a
    /// fiftieth of the value on top, so that a servo may change.
    pub(crate) fn known_from(&self, result: &FitResult<N>) -> Prior<N> {
        let noise = libm::sqrt(self.noise.to_f64());
        Prior {
            initial: core::array::from_fn(|i| {
                Some(N::from_f64(result.parameters[i].to_f64() * self.scale[i]))
            }),
            weight: core::array::from_fn(|i| {
                let deviation = 10.0 * libm::sqrt(result.covariance[i][i].to_f64())
                    + 0.02 * libm::fabs(result.parameters[i].to_f64());
                if self.free[i] && deviation > 0.0 {
                    N::from_f64(noise / (deviation * self.scale[i]))
                } else {
                    N::ZERO
                }
            }),
        }
    }

    /// Begins a fit to the record.
    pub(super) fn begin(&self, blocks: usize, prior: Prior<N>) -> Fit<N> {
        Fit {
            prior,
            blocks,
            next: 0,
            stage: Stage::Survey,
            survey: Survey::NONE,
            omega: N::ZERO,
            correction: Innovation::critically_damped(N::ZERO),
            pass: Pass::at(&[N::ZERO; UNKNOWNS]),
            linear: [[N::ZERO; UNKNOWNS]; 2],
            standing_cost: N::ZERO,
            trial: [N::ZERO; UNKNOWNS],
            damping: N::ZERO,
            passes: 0,
            this: None,
            best: None,
        }
    }

    /// Continues a fit by one block of the record, or by the work between two passes. Returns once it
    /// has ended: with its result, or none if the servo has not moved.
    pub(super) fn work<const W: usize>(
        &self,
        fit: &mut Fit<N>,
        record: &Record<N, W>,
    ) -> Option<Option<FitResult<N>>> {
        if fit.next < fit.blocks {
            if let Some(block) = record.get(fit.next) {
                match fit.stage {
                    Stage::Survey => fit.survey.observe(block),
                    Stage::Linear => {
                        let direction = direction(record, fit.next);
                        self.linear_block(fit, block, direction);
                    }
                    Stage::From(_) => self.model_block(fit, block),
                }
            }
            fit.next += 1;
            return None;
        }
        fit.next = 0;
        match fit.stage {
            Stage::Survey => {
                if fit.survey.path < N::from_f64(MOVED) {
                    return Some(None);
                }
                let blocks = fit.blocks as f64;
                let least = 6.0 / blocks;
                let most = 0.3;
                let turning = core::f64::consts::PI * f64::from(fit.survey.reversals) / blocks;
                let omega = self
                    .bandwidth
                    .map_or(turning, N::to_f64)
                    .max(least)
                    .min(most);
                fit.omega = N::from_f64(omega);
                fit.correction = Innovation::critically_damped(fit.omega);
                fit.stage = Stage::Linear;
                fit.pass = Pass::at(&[N::ZERO; UNKNOWNS]);
                self.add_initial(fit);
            }
            Stage::Linear => {
                let none = N::ZERO;
                fit.standing_cost = fit.pass.equations.cost();
                let mut free = self.free_unknowns();
                fit.linear[0] = fit.pass.equations.solve(none, &free);
                free[COULOMB] = false;
                fit.linear[1] = fit.pass.equations.solve(none, &free);
                fit.stage = Stage::From(0);
                self.begin_start(fit, 0);
            }
            Stage::From(start) => {
                if !self.end_pass(fit) {
                    self.begin_pass(fit);
                    return None;
                }
                let better =
                    |a: &Best<N>, b: &Best<N>| a.pass.equations.cost() < b.pass.equations.cost();
                if let Some(this) = fit.this.take()
                    && fit.best.is_none_or(|best| better(&this, &best))
                {
                    fit.best = Some(this);
                }
                let explained = fit.best.is_some_and(|best| {
                    best.pass.equations.cost().to_f64()
                        < Self::EXPLAINED * self.noise.to_f64() * fit.blocks as f64
                });
                let guesses = 3;
                let last = guesses + Self::LADDER.len() as u32;
                let next = start + 1;
                if next >= last || (explained && next >= guesses) {
                    return Some(self.result(fit));
                }
                fit.stage = Stage::From(next);
                self.begin_start(fit, next);
            }
        }
        None
    }

    pub(super) fn free_unknowns(&self) -> [bool; UNKNOWNS] {
        let [a, b, c, d] = self.free;
        [a, b, c, d, true, true]
    }
}
