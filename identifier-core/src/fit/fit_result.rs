use super::colour::coloured;
use super::early::{EarlyCommand, early_command};
use super::fitter::{Fit, Fitter};
use super::levenberg_marquardt::Explanation;
use super::pass::PassSums;
use super::survey::root;
use super::{A, B};
use crate::adaptation::IdentifiableSet;
use crate::number::Number;
use crate::parameters::Unknown;
use crate::reason::Reason;

/// Noise explains errors of less than this many times its variance.
const MAX_UNEXPLAINED_BY_NOISE: f64 = 4.0;

/// A fit result, machine units of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitResult<N, const P: usize = 4> {
    /// The unknowns of the set; without terms a, b, c, d.
    pub parameters: [N; P],
    /// Their covariance; zero for unknowns that were not fitted.
    pub covariance: [[N; P]; P],
    /// Variance of the fit's errors, counts²; at least the encoder's.
    pub(crate) unexplained: N,
    /// The part of it that changes from block to block, as the noise of the position does: half of the mean square of
    /// successive differences (von Neumann, "Distribution of the ratio of the mean square successive difference to the
    /// variance", Annals of Mathematical Statistics 12(4), 1941).
    pub(crate) noise: N,
    /// Root mean square of acceleration over that of velocity, 1/sample.
    pub(crate) bandwidth: N,
    /// True for an unknown that a bound stopped. Where zero is the bound, it counts only if the motion
    /// asks for significantly less than zero: the truth may be zero.
    pub at_bound: [bool; P],
    /// The sum of all distances moved, counts.
    pub(crate) path: N,
    /// Root mean square of the acceleration that the command gives, counts per sample².
    pub(crate) acceleration: N,
    /// The part of the motion that the fit leaves unexplained, 0 to 1: mean square of its errors over
    /// that of a model at rest.
    pub(crate) left: N,
    /// The direction of the motion if it never reversed, ±1; else zero.
    pub(crate) only_direction: N,
    pub(crate) early: EarlyCommand,
    is_hardly_motion: bool,
    leaves_gain_open: bool,
    /// See [`Fit::command_share`].
    command_share: N,
}

/// The errors of a pass, counts².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Errors<N> {
    unexplained: N,
    pub(super) noise: N,
    /// The variance of white errors that say as little.
    coloured: N,
}

impl<N: Number, const P: usize> FitResult<N, P> {
    /// True if any of them was.
    pub(crate) fn is_at_bound(&self) -> bool {
        self.at_bound.contains(&true)
    }

    /// True if a recursion can continue from it: the motion is explained, and the relative standard
    /// error of b is at most `most`.
    pub(crate) fn is_good(&self, most: f64) -> bool {
        let b = self.parameters[B] * N::from_f64(most);
        let variance = self.covariance[B][B];
        let numbers = self
            .covariance
            .as_flattened()
            .iter()
            .chain(&self.parameters);
        let finite = numbers.into_iter().all(|number| number.is_finite());
        let known = self.early != EarlyCommand::Certain
            && !self.leaves_gain_open
            && !self.at_bound[B]
            && variance <= b * b;
        finite && self.is_explained() && known
    }

    /// True if more of the motion would tell friction from load, or when the command acts.
    pub(crate) fn is_open(&self) -> bool {
        self.only_direction != N::ZERO || self.early == EarlyCommand::Perhaps
    }

    fn is_explained(&self) -> bool {
        /// The largest part of the motion that a fit may leave unexplained.
        const MAX_UNEXPLAINED: f64 = 0.1;
        self.left < N::from_f64(MAX_UNEXPLAINED)
            || self.unexplained < N::from_f64(MAX_UNEXPLAINED_BY_NOISE) * self.noise
    }

    /// Why a result from which nothing can continue is none.
    pub(crate) fn objection(&self) -> Reason {
        /// The command acts if it explains at least this part of what friction and load leave over.
        const MIN_COMMAND_SHARE: f64 = 0.5;
        let acts = N::from_f64(MIN_COMMAND_SHARE);
        let is_bounded = self.is_at_bound();
        if self.leaves_gain_open && !self.is_hardly_motion {
            Reason::ConstantCommand
        } else if self.command_share < -acts {
            Reason::Reversed
        } else if self.is_hardly_motion {
            Reason::TooLittleMotion
        } else if self.command_share < acts && (is_bounded || !self.is_explained()) {
            Reason::DoesNotFollow
        } else if self.early == EarlyCommand::Certain {
            Reason::EarlyCommand
        } else if is_bounded {
            Reason::EstimateAtBound
        } else if !self.is_explained() {
            Reason::PartlyExplained
        } else if self.only_direction != N::ZERO {
            Reason::OneWayMotion
        } else {
            Reason::TooLittleEvidence
        }
    }
}

impl<N, S, const P: usize> Fitter<N, S, P>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    pub(super) fn result(&self, fit: &Fit<N, S::Inputs<N>, P>) -> Option<FitResult<N, P>> {
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
            path: fit.survey.path,
            acceleration: fit.survey.usual_command(fit.blocks) * best.unknowns[B] * per[B],
            left: fit.left,
            only_direction: fit.pass.turns.only_direction(),
            early: if S::UNKNOWNS.contains(&Unknown::Delay) {
                EarlyCommand::No
            } else {
                early_command(best, &free, self.scale[A], fit.blocks)
            },
            is_hardly_motion: fit.survey.is_hardly_motion(),
            // The variance of an unknown on which nothing depends is zero.
            leaves_gain_open: free[B]
                && (covariance[B][B] <= N::ZERO
                    || fit.survey.leaves_gain_open(fit.blocks, has_force)),
            command_share: fit.command_share,
        })
    }

    /// The errors that a pass leaves.
    pub(super) fn errors(
        &self,
        fit: &Fit<N, S::Inputs<N>, P>,
        pass: &Explanation<N, P, PassSums<N, P>>,
    ) -> Errors<N> {
        /// The largest correlation from block to block that can be distinguished from one.
        const MAX_CORRELATION: f64 = 0.999;
        let cost = pass.equations.cost();
        let products = pass.sums.colour.products;
        let freedom = N::from_count(fit.blocks.saturating_sub(P).max(1) as i32);
        let per_freedom = freedom.reciprocal();
        let unexplained = (cost * per_freedom).larger(self.noise);
        Errors {
            unexplained,
            noise: ((cost - products.larger(N::ZERO)) * per_freedom).larger(self.noise),
            coloured: coloured(unexplained, products, cost, MAX_CORRELATION),
        }
    }

    /// The covariance of the unknowns by a pass.
    fn covariance(
        &self,
        fit: &Fit<N, S::Inputs<N>, P>,
        pass: &Explanation<N, P, PassSums<N, P>>,
    ) -> [[N; P]; P] {
        let variance = self.errors(fit, pass).coloured;
        let covariance = pass.equations.covariance();
        covariance.map(|row| row.map(|entry| variance * entry))
    }

    /// Compares a fit at another horizon with the best one. True if it leaves the unknowns less uncertain; where the two
    /// differ by more than chance explains, the model lacks something, and the difference is an error.
    pub(super) fn compare(
        &self,
        fit: &mut Fit<N, S::Inputs<N>, P>,
        pass: &Explanation<N, P, PassSums<N, P>>,
    ) -> bool {
        /// The square of the standard deviations that chance explains (Hausman, "Specification tests in econometrics",
        /// Econometrica 46(6), 1978: the variance of the difference is the difference of the variances).
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

    /// A noise relative to that in the settings, at least one: rounding alone, which is at most half of a count, may have
    /// three times the variance at low speed.
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
