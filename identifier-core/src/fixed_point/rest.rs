use super::arithmetic::{Word, word};
use super::ranges::FullScales;
use crate::constants::encode;
use crate::measurement::standstill::Standstill;
use crate::units::Units;

/// Detection of standstill: [`Standstill`] on words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedRest {
    /// The slip, of an increment's full scale, with 30 fraction bits.
    slip: i64,
    /// Samples.
    patience: u32,
    pause: u32,
    /// See [`Standstill::hidden_acceleration`].
    hidden: Word,
}

encode! {
    [] FixedRest as "FixedRest" { slip, patience, pause, hidden }
}

/// State of the standstill detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct FixedRestState {
    /// Distance of the servo from its possible place of standstill: at most a slip and an
    /// increment.
    away: i64,
    /// Samples since it came there.
    still: u32,
    /// Samples of standstill although the command should move it.
    pushed: u32,
}

impl FixedRest {
    pub(super) fn new(units: &Units, scales: &FullScales) -> Self {
        let standstill = Standstill::<f64>::new(units);
        let slip = Standstill::<f64>::SLIP as i64;
        Self {
            // An increment's full scale is at least one count, 2⁰.
            slip: (slip << 30) >> scales.velocity.clamp(0, 30),
            patience: libm::ceil(Standstill::<f64>::PATIENCE / units.sample_time()) as u32,
            pause: libm::ceil(Standstill::<f64>::PAUSE / units.sample_time()) as u32,
            hidden: word(standstill.hidden_acceleration(), scales.velocity),
        }
    }

    /// A servo at standstill from the start.
    pub(super) fn at_rest(&self) -> FixedRestState {
        FixedRestState {
            still: self.patience,
            ..FixedRestState::default()
        }
    }

    /// See [`Standstill::pauses`].
    #[inline]
    pub(super) fn pauses(&self, state: &FixedRestState) -> bool {
        state.still >= self.pause
    }

    /// Takes the increment of a sample; true at standstill.
    #[inline]
    pub(super) fn stands(&self, state: &mut FixedRestState, increment: Word) -> bool {
        state.away += i64::from(increment.to_bits());
        if state.away.abs() > self.slip {
            *state = FixedRestState::default();
            return false;
        }
        self.waits(state)
    }

    /// The same for a servo without friction: any count is motion.
    #[inline]
    pub(super) fn rests(&self, state: &mut FixedRestState, increment: Word) -> bool {
        if increment != Word::ZERO {
            *state = FixedRestState::default();
            return false;
        }
        self.waits(state)
    }

    #[inline]
    fn waits(&self, state: &mut FixedRestState) -> bool {
        let stands = state.still >= self.patience;
        if !stands {
            state.still += 1;
        }
        stands
    }

    /// See [`Standstill::resists`].
    pub(super) fn resists(&self, state: &mut FixedRestState, should_move: bool) -> bool {
        if !should_move {
            state.pushed = 0;
            return false;
        }
        let resists = state.pushed >= self.patience;
        if !resists {
            state.pushed += 1;
        }
        resists
    }

    /// The largest acceleration that standstill hides, of the velocity's full scale. It moves a
    /// servo by a slip within the time after which the servo counts as at standstill.
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
            phases in prop::collection::vec((-40_i32..40, 1_usize..300, 1_usize..30), 1..20),
        ) {
            let settings = Settings {
                controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
                ..Settings::new(1e-3, 10_000.0)
            };
            let units = settings.units().expect("valid");
            let scales = FullScales::from_settings(&settings).expect("it fits");
            let words = FixedRest::new(&units, &scales);
            let numbers = Standstill::<f64>::new(&units);
            let (mut slipping, mut resting) = (words.at_rest(), words.at_rest());
            let (mut slips, mut rests) = (numbers.at_rest(), numbers.at_rest());
            for (counts, length, every) in phases {
                for k in 0..length {
                    let moved = if k % every == 0 { f64::from(counts) } else { 0.0 };
                    let increment = word(moved, scales.velocity);
                    let exact = numbers.stands(&mut slips, moved);
                    prop_assert_eq!(words.stands(&mut slipping, increment), exact);
                    prop_assert_eq!(words.pauses(&slipping), numbers.pauses(&slips));
                    let exact = numbers.rests(&mut rests, moved);
                    prop_assert_eq!(words.rests(&mut resting, increment), exact);
                }
            }
        }
    }
}
