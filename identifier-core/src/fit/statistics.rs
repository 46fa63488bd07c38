use super::block::Block;
use crate::number::Number;

/// The shortest travel from which anything can be learnt, counts.
pub(crate) const MIN_TRAVEL_COUNTS: f64 = 8.0;

/// Figures of the record without a model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct RecordStatistics<N> {
    pub(super) path: N,
    command: N,
    command_square: N,
    /// Sum of the squares of the travels, counts²: more than the square of any velocity.
    pub(super) travel_square: N,
    position: N,
    lowest: N,
    highest: N,
    last_travel: N,
    /// Sum of the products of successive travels, counts²: negative for noise, positive for motion.
    travel_product: N,
}

impl<N: Number> RecordStatistics<N> {
    pub(super) fn observe(&mut self, block: &Block<N>) {
        self.path += block.travel.magnitude();
        self.travel_square += block.travel * block.travel;
        self.position += block.travel;
        self.lowest = -(-self.lowest).larger(-self.position);
        self.highest = self.highest.larger(self.position);
        self.travel_product += block.travel * self.last_travel;
        self.last_travel = block.travel;
        self.command += block.command;
        self.command_square += block.command * block.command;
    }

    /// The gain from the amplitude of the command to that of the motion at the frequency ω.
    pub(super) fn gain(&self, omega: N, blocks: usize) -> N {
        let per_block = per(blocks);
        let mean = self.command * per_block;
        let unrest = (self.command_square * per_block - mean * mean).larger(N::from_f64(1e-12));
        omega * root(self.travel_square * per_block) * unrest.reciprocal_root()
    }

    /// True if the position barely exceeds the steps and the noise of the encoder.
    pub(super) fn is_hardly_motion(&self) -> bool {
        /// The distance between the ends of a motion of which more than the rounding is seen, counts.
        const MIN_EXTENT_COUNTS: f64 = 20.0;
        /// The correlation of successive travels is −0.5 for white noise of the position alone.
        const NOISE_CORRELATION: f64 = -0.25;
        self.highest - self.lowest < N::from_f64(MIN_EXTENT_COUNTS)
            || self.travel_product < N::from_f64(NOISE_CORRELATION) * self.travel_square
    }

    /// True if any gain explains the motion. There is no command, or it is so constant that a force of the model
    /// compensates for the gain.
    pub(super) fn leaves_gain_open(&self, blocks: usize, has_force: bool) -> bool {
        /// The square of the command's deviation from its mean, over that of the command.
        const MAX_VARIANCE: f64 = 1e-4;
        let mean = self.command * per(blocks);
        let square = self.command_square * per(blocks);
        let most = N::from_f64(if has_force { MAX_VARIANCE } else { 0.0 });
        square <= N::ZERO || square - mean * mean < most * square
    }

    /// A usual command: its root mean square.
    pub(super) fn usual_command(&self, blocks: usize) -> N {
        root(self.command_square * per(blocks))
    }
}

/// Reversals of the measured motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turns<N> {
    /// The least distance back that is a reversal.
    back: N,
    /// The furthest since the last reversal, relative to the present position.
    extreme: N,
    /// Zero before the first motion.
    direction: N,
    has_reversed: bool,
}

impl<N: Number> Turns<N> {
    /// No motion yet. A distance of more than `back` against the direction is a reversal.
    pub(super) fn beyond(back: N) -> Self {
        Self {
            back,
            extreme: N::ZERO,
            direction: N::ZERO,
            has_reversed: false,
        }
    }

    /// Takes the travel of a block.
    #[inline]
    pub(super) fn observe(&mut self, travel: N) {
        self.extreme += travel;
        let ahead = self.extreme * self.direction;
        if ahead > N::ZERO {
            self.extreme = N::ZERO;
        } else if self.extreme.magnitude() > self.back {
            self.has_reversed |= self.direction != N::ZERO;
            self.direction = if self.extreme > N::ZERO {
                N::ONE
            } else {
                -N::ONE
            };
            self.extreme = N::ZERO;
        }
    }

    /// The direction of a motion that never reversed, ±1; else zero.
    pub(super) fn only_direction(&self) -> N {
        if self.has_reversed {
            N::ZERO
        } else {
            self.direction
        }
    }
}

fn per<N: Number>(blocks: usize) -> N {
    N::from_count(blocks.max(1) as i32).reciprocal()
}

/// √x, zero if x is not positive.
pub(super) fn root<N: Number>(x: N) -> N {
    if x > N::ZERO {
        x * x.reciprocal_root()
    } else {
        N::ZERO
    }
}
