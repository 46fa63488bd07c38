//! From measurements to what a loop computes with: differences of positions, in its number format.

use identifier_core::control::Setpoint;
use identifier_core::number::Number;

use super::Measurement;

/// Remembers the last measurement.
pub(super) struct Feedback<N> {
    start: i32,
    count: i32,
    position: N,
}

/// The motion that a measurement shows, position units.
pub(super) struct Motion<N> {
    /// Reference less position.
    pub(super) error: N,
    /// Motion since the last sample.
    pub(super) increment: N,
}

impl<N: Number> Feedback<N> {
    /// At a count where references are zero.
    pub(super) fn starting_at(start: i32) -> Self {
        Self {
            start,
            count: start,
            position: N::ZERO,
        }
    }

    /// Takes a measurement in, against a reference (position units).
    pub(super) fn read(&mut self, reference: f64, measured: Measurement) -> Motion<N> {
        let wanted = N::from_f64(reference);
        match measured {
            Measurement::Count(count) => {
                let moved = count.wrapping_sub(self.count);
                self.count = count;
                Motion {
                    error: Setpoint {
                        count: self.start,
                        offset: wanted,
                    }
                    .error(count),
                    increment: N::from_count(moved),
                }
            }
            Measurement::Position(position) => {
                let position = N::from_f64(position);
                let increment = position - self.position;
                self.position = position;
                Motion {
                    error: wanted - position,
                    increment,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Feedback, Measurement};

    #[test]
    fn a_counter_that_wraps_does_not_break_the_motion() {
        let start = i32::MAX - 1;
        let mut feedback = Feedback::<f64>::starting_at(start);
        for moved in 1..5_i32 {
            let motion = feedback.read(2.5, Measurement::Count(start.wrapping_add(moved)));
            let found = [motion.error, motion.increment].map(f64::to_bits);
            assert_eq!(found, [2.5 - f64::from(moved), 1.0].map(f64::to_bits));
        }
    }

    #[test]
    fn an_ideal_position_is_taken_to_the_loops_number() {
        let mut feedback = Feedback::<f32>::starting_at(0);
        let third = 1.0 / 3.0;
        let motion = feedback.read(0.0, Measurement::Position(third));
        assert_eq!(motion.increment.to_bits(), (third as f32).to_bits());
    }
}
