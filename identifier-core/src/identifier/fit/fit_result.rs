use super::fitter::{Fit, Fitter};
use super::{A, B, UNKNOWNS};
use crate::number::Number;

/// A fit result, machine units of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FitResult<N> {
    /// a, b, c, d.
    pub(crate) parameters: [N; 4],
    pub(crate) covariance: [[N; 4]; 4],
    /// Variance of the fit's errors, counts²; at least the encoder's.
    pub(crate) unexplained: N,
    /// Root mean square of acceleration over that of velocity, 1/sample.
    pub(crate) bandwidth: N,
    /// Whether a parameter was stopped by a bound.
    pub(crate) at_bound: [bool; 4],
    /// The sum of all distances moved, counts.
    pub(crate) path: N,
    /// The last output error, counts.
    pub(crate) output_error: N,
    /// Root mean square of the acceleration that the command gives, counts per sample².
    pub(crate) acceleration: N,
    /// The part of the motion that the fit leaves unexplained, 0 to 1: mean square of its errors over
    /// that of a model at rest.
    pub(crate) left: f64,
    /// The direction of the motion if it never reversed, ±1; else zero.
    pub(crate) only_direction: N,
    noise: N,
}

impl<N: Number> FitResult<N> {
    /// Whether a recursion can continue from it: the motion is explained, and the relative standard
    /// error of b is at most `most`.
    pub(crate) fn is_good(&self, most: f64) -> bool {
        /// The largest part of the motion that a fit may leave unexplained.
        const LEFT: f64 = 0.1;
        let b = self.parameters[B].to_f64();
        let variance = self.covariance[B][B].to_f64();
        let explained = self.left < LEFT || self.unexplained.to_f64() < 4.0 * self.noise.to_f64();
        let finite = (0..4).all(|i| {
            self.parameters[i].is_finite()
                && self.covariance[i].iter().all(|entry| entry.is_finite())
        });
        finite && explained && !self.at_bound[B] && variance <= most * most * b * b
    }
}

impl<N: Number> Fitter<N> {
    pub(super) fn result(&self, fit: &Fit<N>) -> Option<FitResult<N>> {
        /// The largest correlation from block to block that can be distinguished from one.
        const MOST_CORRELATED: f64 = 0.999;
        let best = fit.best.as_ref()?;
        let cost = best.pass.equations.cost().to_f64();
        let freedom = fit.blocks.saturating_sub(UNKNOWNS).max(1) as f64;
        let unexplained = (cost / freedom).max(self.noise.to_f64());
        // Errors correlated from block to block as ρᵏ carry less information than white ones.
        let correlation = if cost > 0.0 {
            (best.pass.lag_one.to_f64() / cost).clamp(0.0, MOST_CORRELATED)
        } else {
            0.0
        };
        let coloured = unexplained * (1.0 + correlation) / (1.0 - correlation);
        let covariance = best.pass.equations.covariance();
        let per = self.scale.map(|scale| 1.0 / scale);
        let at_bound = core::array::from_fn(|i| {
            let value = best.unknowns[i];
            self.free[i] && (value <= self.low[i] || value >= self.high[i])
        });
        let speed = best.pass.speed_square.to_f64();
        let acceleration = best.pass.acceleration_square.to_f64();
        let bandwidth = if speed > 0.0 {
            libm::sqrt(acceleration / speed) * per[A]
        } else {
            0.0
        };
        Some(FitResult {
            parameters: core::array::from_fn(|i| N::from_f64(best.unknowns[i].to_f64() * per[i])),
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| {
                    if self.free[i] && self.free[j] {
                        let value = covariance[i][j].to_f64();
                        N::from_f64(coloured * value * per[i] * per[j])
                    } else {
                        N::ZERO
                    }
                })
            }),
            unexplained: N::from_f64(unexplained),
            bandwidth: N::from_f64(bandwidth),
            at_bound,
            path: fit.survey.path,
            output_error: best.pass.last_error,
            acceleration: N::from_f64(
                libm::sqrt(fit.survey.command_square.to_f64() / fit.blocks as f64)
                    * best.unknowns[B].to_f64()
                    * per[B],
            ),
            left: cost / fit.standing_cost.to_f64().max(cost).max(f64::MIN_POSITIVE),
            only_direction: if fit.survey.reversals == 0 {
                fit.survey.direction
            } else {
                N::ZERO
            },
            noise: self.noise,
        })
    }
}
