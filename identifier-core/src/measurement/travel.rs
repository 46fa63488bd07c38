//! Whether the servo goes anywhere.

use crate::number::Number;
use crate::units::Units;

/// How far the servo has travelled of late, fading over about half a second.
///
/// A servo with friction that is left alone stands, and is broken loose by a count or two now and
/// then as the controller's integral grows. That is no excitation: within so few counts the encoder
/// does not show what the servo does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel<N> {
    fading: N,
    least: N,
}

impl<N: Number> Travel<N> {
    /// Time over which travel is forgotten, s.
    pub const MEMORY: f64 = 0.5;

    /// Counts (position units) within that time from which on the servo goes somewhere.
    pub const LEAST: f64 = 10.0;

    /// For a loop with these units.
    #[must_use]
    pub fn new(units: &Units) -> Self {
        let fading = (units.sample_time() / Self::MEMORY).min(1.0);
        Self {
            fading: N::from_f64(fading),
            least: N::from_f64(Self::LEAST),
        }
    }

    /// Takes in the increment of a sample; true while the servo stays where it is.
    #[inline]
    pub fn stays(&self, travelled: &mut N, increment: N) -> bool {
        *travelled += increment.magnitude() - self.fading * *travelled;
        *travelled < self.least
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_a_few_counts_is_no_travel_and_motion_is() {
        let units = Units::new(1e-3, 1e-3).expect("valid");
        let travel = Travel::<f32>::new(&units);
        let mut travelled = 0.0;
        for k in 0..10_000 {
            let slip = if k % 5000 < 3 { 1.0 } else { 0.0 };
            assert!(travel.stays(&mut travelled, slip));
        }
        let started = (0..100).position(|_| !travel.stays(&mut travelled, -2.0));
        assert_eq!(started, Some(5));
    }
}
