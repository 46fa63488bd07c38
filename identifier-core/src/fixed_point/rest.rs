use super::arithmetic::{WORD_BITS, Word, word};
use super::ranges::Scales;
use crate::measurement::standstill::Standstill;
use crate::measurement::travel::Travel;
use crate::units::Units;

/// Whether the servo stands or stays where it is: [`Travel`] and [`Standstill`] on words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedRest {
    fading: Word,
    /// Counts that the full scale of an increment is.
    full: i32,
    /// Samples.
    patience: u32,
    /// See [`Standstill::hidden_acceleration`].
    hidden: Word,
}

/// What it remembers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct FixedRestState {
    /// Counts with 16 fraction bits.
    travelled: i64,
    /// Samples without motion.
    still: u32,
}

impl FixedRest {
    const FRACTION: i32 = 16;
    const LEAST: i64 = (Travel::<f64>::LEAST as i64) << Self::FRACTION;
    /// As far as the product below bears: 65 536 counts.
    const MOST: i64 = 1 << 32;

    pub(super) fn new(units: &Units, scales: &Scales) -> Self {
        let time = units.sample_time();
        let standstill = Standstill::<f64>::new(units);
        Self {
            fading: word(time / Travel::<f64>::MEMORY, 0),
            full: 1 << scales.velocity.clamp(0, WORD_BITS),
            patience: libm::ceil(Standstill::<f64>::PATIENCE / time) as u32,
            hidden: word(standstill.hidden_acceleration(), scales.velocity),
        }
    }

    /// Takes in the increment of a sample, at most one in magnitude; true while the servo stays where
    /// it is.
    #[inline]
    pub(super) fn stays(&self, state: &mut FixedRestState, increment: Word) -> bool {
        // At most 2^32 times 2^30, and 2^30 times 2^30.
        let faded = (state.travelled * i64::from(self.fading.to_bits())) >> WORD_BITS;
        let moved = (i64::from(increment.to_bits().unsigned_abs()) * i64::from(self.full))
            >> (WORD_BITS - Self::FRACTION);
        state.travelled = (state.travelled + moved - faded).min(Self::MOST);
        state.travelled < Self::LEAST
    }

    /// Takes in the increment of a sample; true while the servo stands.
    #[inline]
    pub(super) fn stands(&self, state: &mut FixedRestState, increment: Word) -> bool {
        if increment != Word::ZERO {
            state.still = 0;
            return false;
        }
        let stands = state.still >= self.patience;
        if !stands {
            state.still += 1;
        }
        stands
    }

    /// The acceleration that moves a servo by no more than a count before it counts as standing, of
    /// the velocity's full scale.
    pub(super) fn hidden_acceleration(&self) -> Word {
        self.hidden
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{ControllerSettings, Settings};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_decides_as_numbers_do(
            phases in prop::collection::vec((0_i32..40, 1_usize..300, 1_usize..30), 1..20),
        ) {
            let settings = Settings {
                controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
                ..Settings::new(1e-3, 10_000.0)
            };
            let units = settings.units().expect("valid");
            let scales = Scales::of(&settings).expect("it fits");
            let rest = FixedRest::new(&units, &scales);
            let (travel, standstill) = (Travel::<f64>::new(&units), Standstill::<f64>::new(&units));
            let (mut state, mut travelled, mut still) = (FixedRestState::default(), 0.0, 0.0);
            for (counts, length, every) in phases {
                for k in 0..length {
                    let moved = if k % every == 0 { counts } else { 0 };
                    let increment = word(f64::from(moved), scales.velocity);
                    let exact = travel.stays(&mut travelled, f64::from(moved));
                    let stays = rest.stays(&mut state, increment);
                    // Where the two fade past ten counts a rounding may decide.
                    if (travelled - Travel::<f64>::LEAST).abs() > 1e-2 {
                        prop_assert_eq!(stays, exact, "{}", travelled);
                    }
                    let exact = standstill.stands(&mut still, f64::from(moved));
                    prop_assert_eq!(rest.stands(&mut state, increment), exact);
                }
            }
        }
    }
}
