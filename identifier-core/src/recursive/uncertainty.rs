use crate::number::Number;

/// The output error over the noise that it was weighed with, for standard errors: sums over blocks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct WeighedErrors<N> {
    square: N,
    lag_one: N,
    last: N,
}

impl<N: Number> WeighedErrors<N> {
    /// The number of blocks at which the sums are halved. The past fades, and no sum grows so large that rounding loses
    /// a block.
    pub(super) const FADING: u16 = 4000;

    /// Takes in a block's mean error; `precision` is the reciprocal of its noise variance.
    #[inline]
    pub(super) fn observe(&mut self, error: N, precision: N) {
        let weighted = error * precision;
        self.square += error * weighted;
        self.lag_one += self.last * weighted;
        self.last = error;
    }

    #[cold]
    pub(super) fn fade(&mut self) {
        let half = N::from_f64(0.5);
        self.square = self.square * half;
        self.lag_one = self.lag_one * half;
    }
}

/// The errors of Gauss–Newton's estimates before scaling, machine units. An interrupt copies them without a root or a
/// division; the background computes standard errors from them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EstimateUncertainty<N, const P: usize> {
    /// The variances by P.
    pub(super) variances: [N; P],
    pub(super) weighed: WeighedErrors<N>,
    pub(super) blocks: u16,
}

impl<N: Number, const P: usize> EstimateUncertainty<N, P> {
    /// The standard errors, machine units.
    pub(crate) fn standard_errors(&self) -> [f64; P] {
        let factor = self.covariance_scale();
        self.variances
            .map(|variance| libm::sqrt(factor * variance.to_f64()))
    }

    /// The factor on the variances of P: the mean square of the error over its noise, times (1 + ρ)/(1 − ρ). The
    /// autocorrelation of the errors over k blocks is ρᵏ.
    fn covariance_scale(&self) -> f64 {
        /// The range of correlations that is used. The errors of a corrected model alternate. At the low frequencies of
        /// the sensitivities they are below their mean square.
        const CORRELATED: (f64, f64) = (-0.5, 0.98);
        let square = self.weighed.square.to_f64();
        if square > 0.0 {
            let correlation =
                (self.weighed.lag_one.to_f64() / square).clamp(CORRELATED.0, CORRELATED.1);
            square / f64::from(self.blocks) * (1.0 + correlation) / (1.0 - correlation)
        } else {
            1.0
        }
    }
}
