use super::law::GaussNewton;
use crate::constants::{Encode, encode};
use crate::number::Number;

/// Detects a step of the load by the mean of the output error.
///
/// The model is corrected with the bandwidth ω. After a load step Δd its output error tends to Δd/ω². Its mean over
/// [`LoadStepTest::MEAN_TIME`] is compared with [`LoadStepTest::MIN_DEVIATIONS`] times its standard deviation over
/// [`LoadStepTest::DEVIATION_TIME`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LoadStepTest<N> {
    weight: N,
    variance_weight: N,
    floor: N,
    /// A missed step must not hide the next. So a square counts as at most this many times the mean square.
    cap: N,
    threshold: N,
    /// The least square of a mean that counts.
    least: N,
}

encode! {
    [N: Encode] LoadStepTest<N> as "LoadStepTest" {
        weight, variance_weight, floor, cap, threshold, least,
    }
}

/// The state of the test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LoadStepDetector<N> {
    mean: N,
    variance: N,
    /// The load before the present search.
    pub(super) sought_from: N,
}

impl<N: Number> LoadStepTest<N> {
    /// The time of the mean, s.
    const MEAN_TIME: f64 = 0.01;

    /// The time over which the standard deviation is taken, s.
    const DEVIATION_TIME: f64 = 2.0;

    /// Standard deviations that a mean must be off.
    const MIN_DEVIATIONS: f64 = 6.0;

    /// Standard deviations of a single sample that a mean must be off as well. In slow motion the rounding, at most
    /// half of a count, is correlated from sample to sample and not noise.
    const MIN_SAMPLE_DEVIATIONS: f64 = 2.5;

    pub(crate) fn new(sample_time: f64, noise: f64) -> Self {
        let block = f64::from(GaussNewton::<N, 1>::BLOCK);
        let weight = (block * sample_time / Self::MEAN_TIME).min(1.0);
        Self {
            weight: N::from_f64(weight),
            variance_weight: N::from_f64((block * sample_time / Self::DEVIATION_TIME).min(0.1)),
            floor: N::from_f64(noise / block * weight / (2.0 - weight)),
            cap: N::from_f64(9.0),
            threshold: N::from_f64(Self::MIN_DEVIATIONS * Self::MIN_DEVIATIONS),
            least: N::from_f64(Self::MIN_SAMPLE_DEVIATIONS * Self::MIN_SAMPLE_DEVIATIONS * noise),
        }
    }

    /// The state after a fit that left errors of a variance `unexplained`.
    pub(super) fn start(&self, unexplained: N) -> LoadStepDetector<N> {
        LoadStepDetector {
            mean: N::ZERO,
            // The estimates are still uncertain: only a large deviation is a step.
            variance: unexplained,
            sought_from: N::ZERO,
        }
    }

    /// Takes the mean output error of a block; true if neither noise nor the uncertainty of the estimates explains it.
    /// That uncertainty gives it the variance `predicted`/`inflation`. The recent rise of P with the noise level is
    /// excluded, since a step of the load causes it.
    #[inline]
    pub(super) fn detects(
        &self,
        state: &mut LoadStepDetector<N>,
        error: N,
        predicted: N,
        inflation: N,
    ) -> bool {
        state.mean += self.weight * (error - state.mean);
        let square = state.mean * state.mean;
        let variance = if state.variance > self.floor {
            state.variance
        } else {
            self.floor
        };
        if square > self.least
            && square * inflation > self.threshold * (variance * inflation + predicted)
        {
            // After a false alarm the threshold adapts, so that it is not repeated.
            state.variance = variance + N::from_f64(0.1) * (square - variance);
            return true;
        }
        state.variance +=
            self.variance_weight * (square.smaller(self.cap * variance) - state.variance);
        false
    }
}

impl<N: Number> LoadStepDetector<N> {
    pub(super) fn clear(&mut self) {
        self.mean = N::ZERO;
    }
}
