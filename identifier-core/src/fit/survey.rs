use super::block::Block;
use crate::number::Number;

/// The shortest travel from which anything can be learnt, counts.
pub(crate) const MIN_TRAVEL_COUNTS: f64 = 8.0;

/// Figures of the record without a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Survey<N> {
    pub(super) path: N,
    command: N,
    command_square: N,
    travel_square: N,
    /// The furthest since the last reversal, relative to the present position.
    extreme: N,
    pub(super) direction: N,
    pub(super) reversals: u32,
}

impl<N: Number> Survey<N> {
    pub(super) const NONE: Self = Self {
        path: N::ZERO,
        command: N::ZERO,
        command_square: N::ZERO,
        travel_square: N::ZERO,
        extreme: N::ZERO,
        direction: N::ZERO,
        reversals: 0,
    };

    pub(super) fn observe(&mut self, block: &Block<N>) {
        /// A reversal is a travel back of more counts than an edge of the encoder can produce at rest.
        const REVERSAL_COUNTS: f64 = 2.0;
        let back = N::from_f64(REVERSAL_COUNTS);
        self.path += block.travel.magnitude();
        self.travel_square += block.travel * block.travel;
        self.command += block.command;
        self.command_square += block.command * block.command;
        self.extreme += block.travel;
        let ahead = self.extreme * self.direction;
        if self.direction == N::ZERO {
            if self.extreme.magnitude() > back {
                self.direction = if self.extreme > N::ZERO {
                    N::ONE
                } else {
                    -N::ONE
                };
                self.extreme = N::ZERO;
            }
        } else if ahead > N::ZERO {
            self.extreme = N::ZERO;
        } else if ahead < -back {
            self.direction = -self.direction;
            self.extreme = N::ZERO;
            self.reversals += 1;
        }
    }

    /// The gain from the amplitude of the command to that of the motion at the frequency ω.
    pub(super) fn gain(&self, omega: N, blocks: usize) -> N {
        let per_block = per(blocks);
        let mean = self.command * per_block;
        let unrest = larger(
            self.command_square * per_block - mean * mean,
            N::from_f64(1e-12),
        );
        omega * root(self.travel_square * per_block) * unrest.reciprocal_root()
    }

    /// A usual command: its root mean square.
    pub(super) fn usual_command(&self, blocks: usize) -> N {
        root(self.command_square * per(blocks))
    }
}

fn per<N: Number>(blocks: usize) -> N {
    N::from_count(blocks.max(1) as i32).reciprocal()
}

/// √x, zero for what is not positive.
pub(super) fn root<N: Number>(x: N) -> N {
    if x > N::ZERO {
        x * x.reciprocal_root()
    } else {
        N::ZERO
    }
}

pub(super) fn larger<N: Number>(x: N, y: N) -> N {
    if x > y { x } else { y }
}
