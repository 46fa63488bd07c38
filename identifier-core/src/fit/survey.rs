use super::block::Block;
use crate::number::Number;

/// The shortest travel from which anything can be learnt, counts.
pub(crate) const MIN_TRAVEL_COUNTS: f64 = 8.0;

/// Figures of the record without a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Survey<N> {
    pub(super) path: N,
    pub(super) command: N,
    pub(super) command_square: N,
    pub(super) travel_square: N,
    /// The furthest since the last reversal, relative to the present position.
    pub(super) extreme: N,
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
        let count = blocks as f64;
        let mean = self.command.to_f64() / count;
        let unrest = (self.command_square.to_f64() / count - mean * mean).max(1e-12);
        let speed = self.travel_square.to_f64() / count;
        N::from_f64(omega.to_f64() * libm::sqrt(speed / unrest))
    }
}
