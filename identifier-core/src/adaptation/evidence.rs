use crate::linalg::NormalEquations;
use crate::number::Number;
use crate::parameters::Terms;

/// Which terms of a model have entered, and where the evidence for the others is gathered.
///
/// A term is distinguished from the parameters only by motion in both directions, and one term from
/// another only when it is estimated; so they enter one after the other.
pub trait Evidence<N, const P: usize>: Copy + core::fmt::Debug + PartialEq {
    /// No evidence yet.
    const NONE: Self;

    /// The terms that have entered.
    fn entered(&self) -> Terms;

    /// Lets a term enter. The estimates then move, which is no evidence for another term.
    fn enter(&mut self, terms: Terms);

    /// Begins anew with the evidence for the terms that have not entered.
    fn begin_anew(&mut self);

    /// The next block does not follow the last.
    fn interrupt(&mut self) {}

    /// True while the estimates may still move because of the term that entered last.
    fn is_settling(&self) -> bool;

    /// Takes in a block in which the model moved in `direction` (its sign): the mean error and its
    /// sensitivity to every unknown, entered or not.
    fn observe(&mut self, sensitivity: &[N; P], error: N, direction: N);

    /// The fewest blocks that the model has moved in a direction, forwards or backwards.
    fn both_ways(&self) -> u16;

    /// The sum of squared errors of the gathered blocks that is left when only the unknowns `free` are
    /// fitted, over the sum of squared errors; none where it is not gathered.
    fn left_by(&self, free: &[bool; P]) -> Option<f64>;

    /// Independent blocks that were gathered.
    fn independent(&self) -> f64;

    /// The correlation of the errors of successive blocks, from 0 to 0.98.
    fn correlation(&self) -> f64 {
        0.0
    }
}

/// For models without terms.
impl<N: Number, const P: usize> Evidence<N, P> for () {
    const NONE: Self = ();

    #[inline]
    fn entered(&self) -> Terms {
        Terms::NONE
    }

    fn enter(&mut self, _: Terms) {}

    fn begin_anew(&mut self) {}

    fn is_settling(&self) -> bool {
        false
    }

    #[inline]
    fn observe(&mut self, _: &[N; P], _: N, _: N) {}

    #[inline]
    fn both_ways(&self) -> u16 {
        0
    }

    fn left_by(&self, _: &[bool; P]) -> Option<f64> {
        None
    }

    fn independent(&self) -> f64 {
        0.0
    }
}

/// For models whose terms enter on demand: only motion is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OnDemand {
    forwards: u16,
    backwards: u16,
    entered: Terms,
    settling: bool,
}

impl<N: Number, const P: usize> Evidence<N, P> for OnDemand {
    const NONE: Self = Self {
        forwards: 0,
        backwards: 0,
        entered: Terms::NONE,
        settling: false,
    };

    #[inline]
    fn entered(&self) -> Terms {
        self.entered
    }

    fn enter(&mut self, terms: Terms) {
        *self = Self {
            forwards: 0,
            backwards: 0,
            entered: self.entered.or(terms),
            settling: true,
        };
    }

    fn begin_anew(&mut self) {
        *self = Self {
            forwards: 0,
            backwards: 0,
            settling: false,
            ..*self
        };
    }

    fn is_settling(&self) -> bool {
        self.settling
    }

    #[inline]
    fn observe(&mut self, _: &[N; P], _: N, direction: N) {
        if direction > N::ZERO {
            self.forwards = self.forwards.saturating_add(1);
        } else {
            self.backwards = self.backwards.saturating_add(1);
        }
    }

    #[inline]
    fn both_ways(&self) -> u16 {
        self.forwards.min(self.backwards)
    }

    fn left_by(&self, _: &[bool; P]) -> Option<f64> {
        None
    }

    fn independent(&self) -> f64 {
        0.0
    }
}

/// For models whose terms enter when there is evidence for them: how well each would explain the
/// errors beyond the part explained by the unknowns that have entered (a score test on the blocks).
///
/// Errors that are correlated from block to block, as those of a drifting load, resemble any slow
/// sensitivity; so errors and sensitivities are whitened alike, to first order, before they are
/// compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScoreTest<N, const P: usize> {
    moved: OnDemand,
    equations: NormalEquations<N, P>,
    blocks: u32,
    /// False before the first block and after a gap.
    follows: bool,
    error: N,
    sensitivity: [N; P],
    /// The correlation of successive errors, raw and whitened.
    raw: LagOne<N>,
    white: LagOne<N>,
}

/// The correlation of a sequence from element to element.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LagOne<N> {
    square: N,
    product: N,
    last: N,
}

impl<N: Number> LagOne<N> {
    /// The largest correlation returned: one of 1 would leave nothing.
    const MAX_CORRELATION: f64 = 0.98;

    const NONE: Self = Self {
        square: N::ZERO,
        product: N::ZERO,
        last: N::ZERO,
    };

    fn observe(&mut self, value: N) {
        self.square += value * value;
        self.product += value * self.last;
        self.last = value;
    }

    /// From 0 to [`LagOne::MAX_CORRELATION`].
    fn correlation(&self) -> f64 {
        let square = self.square.to_f64();
        if square > 0.0 {
            (self.product.to_f64() / square).clamp(0.0, Self::MAX_CORRELATION)
        } else {
            0.0
        }
    }
}

impl<N: Number, const P: usize> ScoreTest<N, P> {
    /// Nothing was gathered yet.
    const fn empty(moved: OnDemand) -> Self {
        Self {
            moved,
            equations: NormalEquations::EMPTY,
            blocks: 0,
            follows: false,
            error: N::ZERO,
            sensitivity: [N::ZERO; P],
            raw: LagOne::NONE,
            white: LagOne::NONE,
        }
    }
}

impl<N: Number, const P: usize> Evidence<N, P> for ScoreTest<N, P> {
    const NONE: Self = Self::empty(<OnDemand as Evidence<N, P>>::NONE);

    #[inline]
    fn entered(&self) -> Terms {
        self.moved.entered
    }

    fn enter(&mut self, terms: Terms) {
        Evidence::<N, P>::enter(&mut self.moved, terms);
        *self = Self::empty(self.moved);
    }

    fn begin_anew(&mut self) {
        Evidence::<N, P>::begin_anew(&mut self.moved);
        *self = Self::empty(self.moved);
    }

    fn interrupt(&mut self) {
        self.follows = false;
    }

    fn is_settling(&self) -> bool {
        self.moved.settling
    }

    fn observe(&mut self, sensitivity: &[N; P], error: N, direction: N) {
        Evidence::<N, P>::observe(&mut self.moved, sensitivity, error, direction);
        let (last_error, last_sensitivity) = (self.error, self.sensitivity);
        (self.error, self.sensitivity) = (error, *sensitivity);
        if !core::mem::replace(&mut self.follows, true) {
            self.raw.last = error;
            self.white.last = N::ZERO;
            return;
        }
        self.raw.observe(error);
        let kept = N::from_f64(self.raw.correlation());
        let innovation = error - kept * last_error;
        let row = core::array::from_fn(|i| sensitivity[i] - kept * last_sensitivity[i]);
        self.white.observe(innovation);
        self.equations.add(&row, innovation);
        self.blocks = self.blocks.saturating_add(1);
    }

    #[inline]
    fn both_ways(&self) -> u16 {
        Evidence::<N, P>::both_ways(&self.moved)
    }

    fn left_by(&self, free: &[bool; P]) -> Option<f64> {
        let all = self.equations.cost().to_f64();
        let explained = self.equations.explained_by(free).to_f64();
        (all > 0.0).then(|| (1.0 - explained / all).max(0.0))
    }

    fn correlation(&self) -> f64 {
        self.raw.correlation()
    }

    fn independent(&self) -> f64 {
        let correlation = self.white.correlation();
        f64::from(self.blocks) * (1.0 - correlation) / (1.0 + correlation)
    }
}
