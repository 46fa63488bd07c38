//! Whether the servo stands, by its own counts and time alone.

use crate::number::Number;
use crate::units::Units;

/// A servo stands once it has not moved for [`Standstill::PATIENCE`].
///
/// No estimate has a say in it: a friction that is estimated too large would call every velocity
/// "standing", carry the model along, and never be found out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standstill<N> {
    patience: N,
    hidden: N,
}

impl<N: Number> Standstill<N> {
    /// How long the encoder must have shown no motion, s. A servo that creeps at fewer than
    /// 1/PATIENCE counts a second counts as standing.
    pub const PATIENCE: f64 = 0.05;

    /// For a loop with these units.
    #[must_use]
    pub fn new(units: &Units) -> Self {
        let patience = libm::ceil(Self::PATIENCE / units.sample_time());
        Self {
            patience: N::from_f64(patience),
            hidden: N::from_f64(2.0 / (patience * patience)),
        }
    }

    /// The acceleration (machine units) that moves a servo by no more than a count within that time.
    #[must_use]
    pub fn hidden_acceleration(&self) -> N {
        self.hidden
    }

    /// Takes in the increment of a sample; true while the servo stands. `still` counts the samples
    /// without motion.
    #[inline]
    pub fn stands(&self, still: &mut N, increment: N) -> bool {
        if increment != N::ZERO {
            *still = N::ZERO;
            return false;
        }
        let stands = *still >= self.patience;
        if !stands {
            *still += N::ONE;
        }
        stands
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_takes_a_time_and_not_a_number_of_samples() {
        for sample_time in [4e-3, 1e-3, 5e-5] {
            let units = Units::new(sample_time, 1e-3).expect("valid");
            let standstill = Standstill::<f32>::new(&units);
            let mut still = 0.0;
            for _ in 0..3 {
                assert!(!standstill.stands(&mut still, -1.0));
                let waited = (0..10_000)
                    .position(|_| standstill.stands(&mut still, 0.0))
                    .expect("it stands");
                let time = waited as f64 * sample_time;
                assert!(
                    (time - Standstill::<f32>::PATIENCE).abs() <= sample_time,
                    "{time}"
                );
            }
        }
    }
}
