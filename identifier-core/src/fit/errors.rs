use super::autocorrelation::autocorrelated;
use super::early::{EarlyCommand, early_command};
use super::fit_result::{Errors, FitResult, MAX_UNEXPLAINED_BY_NOISE};
use super::fitter::{Fit, Fitter};
use super::levenberg_marquardt::Explanation;
use super::pass::PassSums;
use super::statistics::root;
use super::{A, B};
use crate::model::IdentifiableSet;
use crate::number::Number;
use crate::parameters::Unknown;

impl<N, S, const P: usize> Fitter<N, S, P>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    pub(super) fn result(&self, fit: &Fit<N, P>) -> Option<FitResult<N, P>> {
        /// Standard errors.
        const MIN_STANDARD_ERRORS: f64 = 3.0;
        let best = fit.best.as_ref()?;
        let mut covariance = self.covariance(fit, best);
        for i in 0..P {
            covariance[i][i] += fit.disagreement[i];
        }
        let per = &self.per_scale;
        let free = self.free_unknowns(&fit.prior);
        let stopped_at_zero: [bool; P] =
            core::array::from_fn(|i| best.unknowns[i] <= self.low[i] && self.low[i] == N::ZERO);
        let further = if (0..P).any(|i| free[i] && stopped_at_zero[i]) {
            best.equations.solve(N::ZERO, &free)
        } else {
            [N::ZERO; P]
        };
        let at_bound = core::array::from_fn(|i| {
            let value = best.unknowns[i];
            let below = -further[i];
            let certain = N::from_f64(MIN_STANDARD_ERRORS * MIN_STANDARD_ERRORS);
            let significant = below > N::ZERO && below * below > certain * covariance[i][i];
            let stopped = if stopped_at_zero[i] {
                significant
            } else {
                value <= self.low[i]
            };
            free[i] && (stopped || value >= self.high[i])
        });
        let speed = best.sums.speed_square;
        let bandwidth = if speed > N::ZERO {
            root(best.sums.acceleration_square * speed.reciprocal()) * per[A]
        } else {
            N::ZERO
        };
        let unexplained = self.errors(fit, best).unexplained;
        // Errors of which noise is the smaller part are the model's, and then it is not known.
        let is_noise = unexplained < N::from_f64(MAX_UNEXPLAINED_BY_NOISE) * fit.noise;
        let forces = [Unknown::Coulomb, Unknown::Load];
        let has_force = (0..P).any(|i| free[i] && forces.contains(&S::UNKNOWNS[i]));
        Some(FitResult {
            parameters: core::array::from_fn(|i| best.unknowns[i] * per[i]),
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| {
                    if free[i] && free[j] {
                        covariance[i][j] * per[i] * per[j]
                    } else {
                        N::ZERO
                    }
                })
            }),
            unexplained,
            noise: if is_noise {
                self.noise * self.relative(fit.noise)
            } else {
                self.noise
            },
            bandwidth,
            at_bound,
            path: fit.statistics.path,
            acceleration: fit.statistics.usual_command(fit.blocks) * best.unknowns[B] * per[B],
            left: fit.left,
            only_direction: fit.pass.turns.only_direction(),
            early: if S::UNKNOWNS.contains(&Unknown::Delay) {
                EarlyCommand::No
            } else {
                early_command(
                    &best.equations,
                    &best.sums.early,
                    &free,
                    self.scale[A],
                    fit.blocks,
                )
            },
            is_hardly_motion: fit.statistics.is_hardly_motion(),
            // The variance of an unknown on which nothing depends is zero.
            leaves_gain_open: free[B]
                && (covariance[B][B] <= N::ZERO
                    || fit.statistics.leaves_gain_open(fit.blocks, has_force)),
            command_share: fit.command_share,
        })
    }

    /// The errors that a pass leaves.
    pub(super) fn errors(
        &self,
        fit: &Fit<N, P>,
        pass: &Explanation<N, P, PassSums<N, P>>,
    ) -> Errors<N> {
        /// The largest correlation from block to block that can be distinguished from one.
        const MAX_CORRELATION: f64 = 0.999;
        let cost = pass.equations.cost();
        let products = pass.sums.autocorrelation.products;
        let freedom = N::from_count(fit.blocks.saturating_sub(P).max(1) as i32);
        let per_freedom = freedom.reciprocal();
        let unexplained = (cost * per_freedom).larger(self.noise);
        Errors {
            unexplained,
            noise: ((cost - products.larger(N::ZERO)) * per_freedom).larger(self.noise),
            autocorrelated: autocorrelated(unexplained, products, cost, MAX_CORRELATION),
        }
    }

    /// The covariance of the unknowns by a pass.
    fn covariance(&self, fit: &Fit<N, P>, pass: &Explanation<N, P, PassSums<N, P>>) -> [[N; P]; P] {
        let variance = self.errors(fit, pass).autocorrelated;
        let covariance = pass.equations.covariance();
        covariance.map(|row| row.map(|entry| variance * entry))
    }

    /// Compares a fit at another horizon with the best one. True if it leaves the unknowns less uncertain. If the two
    /// differ by more than chance explains, the model lacks an effect. The difference is then an error.
    pub(super) fn compare(
        &self,
        fit: &mut Fit<N, P>,
        pass: &Explanation<N, P, PassSums<N, P>>,
    ) -> bool {
        /// The square of the standard deviations that chance explains. The variance of the difference is the difference
        /// of the variances (Hausman, "Specification tests in econometrics", Econometrica 46(6), 1978).
        const CHANCE: f64 = 4.0;
        let Some(best) = fit.best else { return true };
        let free = self.free_unknowns(&fit.prior);
        let [own, other] = [pass, &best].map(|pass| self.covariance(fit, pass));
        let mut ratio = N::ONE;
        for i in (0..P).filter(|&i| free[i]) {
            let [own, other] = [own[i][i], other[i][i]];
            let apart = pass.unknowns[i] - best.unknowns[i];
            let beyond = apart * apart - N::from_f64(CHANCE) * (own - other).magnitude();
            if own > N::ZERO && other > N::ZERO {
                ratio = ratio * own * other.reciprocal();
                fit.disagreement[i] = fit.disagreement[i].larger(beyond);
            }
        }
        ratio < N::ONE
    }

    /// A noise relative to that in the settings, at least one. At low speed the variance of rounding alone, which is at
    /// most half of a count, may be three times as large.
    pub(crate) fn relative(&self, noise: N) -> N {
        const MAX_ROUNDING: f64 = 3.0;
        let relative = noise * self.noise.reciprocal();
        if relative > N::from_f64(MAX_ROUNDING) {
            relative
        } else {
            N::ONE
        }
    }
}
