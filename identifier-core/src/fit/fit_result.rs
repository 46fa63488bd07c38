use super::B;
use super::early::EarlyCommand;
use crate::number::Number;
use crate::reason::Reason;

/// Noise explains errors of less than this many times its variance.
pub(super) const MAX_UNEXPLAINED_BY_NOISE: f64 = 4.0;

/// A fit result, machine units of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitResult<N, const P: usize = 4> {
    /// The unknowns of the set; without terms a, b, c, d.
    pub parameters: [N; P],
    /// Their covariance; zero for unknowns that were not fitted.
    pub covariance: [[N; P]; P],
    /// Variance of the fit's errors, counts²; at least the encoder's.
    pub(crate) unexplained: N,
    /// The part of it that changes from block to block, as the noise of the position does. It is half of the mean
    /// square of successive differences. Source: von Neumann, "Distribution of the ratio of the mean square successive
    /// difference to the variance", Annals of Mathematical Statistics 12(4), 1941.
    pub(crate) noise: N,
    /// Root mean square of acceleration over that of velocity, 1/sample.
    pub(crate) bandwidth: N,
    /// True for an unknown that a bound stopped. A bound of zero counts only if the motion demands significantly less
    /// than zero. The truth may be zero.
    pub at_bound: [bool; P],
    /// The sum of all distances moved, counts.
    pub(crate) path: N,
    /// Root mean square of the acceleration that the command gives, counts per sample².
    pub(crate) acceleration: N,
    /// The part of the motion that the fit leaves unexplained, 0 to 1. It is the mean square of its errors over that of
    /// a model at rest.
    pub(crate) left: N,
    /// The direction of the motion if it never reversed, ±1; else zero.
    pub(crate) only_direction: N,
    pub(crate) early: EarlyCommand,
    pub(super) is_hardly_motion: bool,
    pub(super) leaves_gain_open: bool,
    /// The part of the motion that the command explains beyond friction and load, with the sign of the gain.
    pub(super) command_share: N,
}

/// The errors of a pass, counts².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Errors<N> {
    pub(super) unexplained: N,
    pub(super) noise: N,
    /// The variance of white errors that say as little.
    pub(super) autocorrelated: N,
}

impl<N: Number, const P: usize> FitResult<N, P> {
    /// True if any of them was.
    pub(crate) fn is_at_bound(&self) -> bool {
        self.at_bound.contains(&true)
    }

    /// True if a recursion can continue from it. The motion is explained, and the relative standard error of b is at
    /// most `most`.
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

    /// True if more of the motion would separate friction from load, or show when the command acts.
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
    pub(crate) fn rejection_reason(&self) -> Reason {
        /// The command acts if it explains at least this part of the residual of friction and load.
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
