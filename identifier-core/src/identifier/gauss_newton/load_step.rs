use crate::adaptation::GaussNewton;
use crate::number::Number;

/// Notices a step of the load by the mean of the output error.
///
/// The model, corrected with the bandwidth ω, follows a load that changed by Δd with an output error
/// that tends to Δd/ω². Its mean over [`LoadStepTest::MEAN`] is compared with
/// [`LoadStepTest::DEVIATIONS`] times the unrest it had over [`LoadStepTest::UNREST`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LoadStepTest<N> {
    weight: N,
    unrest_weight: N,
    falling: N,
    floor: N,
    /// What is not noticed must not hide what comes after it: a square counts as no more than this
    /// many times what is usual.
    cap: N,
    threshold: N,
}

/// What the test remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Suspicion<N> {
    mean: N,
    unrest: N,
    /// What the uncertainty of the estimates has lately given the mean, a variance.
    young: N,
    /// The load before the search that is under way.
    pub(super) sought_from: N,
}

impl<N: Number> LoadStepTest<N> {
    /// The time of the mean, s.
    const MEAN: f64 = 0.01;

    /// The time of the unrest, s.
    const UNREST: f64 = 2.0;

    /// The time in which better estimates are believed, s.
    const YOUNG: f64 = 0.2;

    /// Standard deviations that a mean must be off.
    const DEVIATIONS: f64 = 6.0;

    pub(super) fn new(sample_time: f64, noise: f64) -> Self {
        let block = f64::from(GaussNewton::<N, 1>::BLOCK);
        let weight = (block * sample_time / Self::MEAN).min(1.0);
        Self {
            weight: N::from_f64(weight),
            unrest_weight: N::from_f64((block * sample_time / Self::UNREST).min(0.1)),
            falling: N::from_f64((block * sample_time / Self::YOUNG).min(0.1)),
            floor: N::from_f64(noise / block * weight / (2.0 - weight)),
            cap: N::from_f64(9.0),
            threshold: N::from_f64(Self::DEVIATIONS * Self::DEVIATIONS),
        }
    }

    pub(super) fn start(&self) -> Suspicion<N> {
        Suspicion {
            mean: N::ZERO,
            // The estimates are young: only what stands out far is a step.
            unrest: self.floor,
            young: self.floor * self.threshold,
            sought_from: N::ZERO,
        }
    }

    /// Takes in the mean output error of a block; true if it cannot be noise.
    #[inline]
    pub(super) fn suspects(&self, state: &mut Suspicion<N>, error: N, predicted: N) -> bool {
        state.mean += self.weight * (error - state.mean);
        let square = state.mean * state.mean;
        let unrest = if state.unrest > self.floor {
            state.unrest
        } else {
            self.floor
        };
        // Followed down quickly and up slowly: the very step that is looked for makes the estimates
        // less certain.
        let pace = if predicted < state.young {
            self.falling
        } else {
            self.unrest_weight
        };
        state.young += pace * (smaller(predicted, self.cap * state.young) - state.young);
        if square > self.threshold * (unrest + state.young) {
            // A test that was wrong must not go on being wrong.
            state.unrest = unrest + N::from_f64(0.1) * (square - unrest);
            return true;
        }
        state.unrest += self.unrest_weight * (smaller(square, self.cap * unrest) - state.unrest);
        false
    }
}

#[inline]
fn smaller<N: Number>(x: N, y: N) -> N {
    if x < y { x } else { y }
}

impl<N: Number> Suspicion<N> {
    pub(super) fn clear(&mut self) {
        self.mean = N::ZERO;
    }
}
