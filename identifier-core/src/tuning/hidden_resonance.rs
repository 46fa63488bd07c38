//! A resonance that nothing has shown.
//!
//! About a mode the loop gain L, which barely changes there, becomes L + A/(1 + jx), where x is the distance from the
//! resonance in its half widths: a circle through L with the diameter A. As the mode grows from nothing, the circle grows
//! towards one side. Above the resonance the motor is alone, and L grows to (1 + β) L. If neither of both comes near −1
//! on the way, the loop is stable and within its margins as without the mode.

use core::f64::consts::TAU;

use super::TuningSettings;
use super::resonance::{Mode, Resonance};
use super::sampled_mode::SampledMode;
use super::sampled_response::{SampledServo, split};
use super::settings::EncoderSide;
use super::shown::{HiddenMode, Shown};
use crate::number::Complex;

/// The resonances that nothing has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HiddenResonances {
    /// The lowest that is stated, rad/s.
    lowest: Option<f64>,
    side: EncoderSide,
}

/// The servo below a resonance that nothing has shown.
#[derive(Debug, Clone, Copy)]
pub(super) struct ServoBelow<'a> {
    /// With the resonance that is known.
    pub(super) sampled: &'a SampledServo,
    /// S.
    pub(super) delay: f64,
    /// S.
    pub(super) sample_time: f64,
}

impl HiddenResonances {
    /// The ratio of successive frequencies.
    const RATIO: f64 = 1.1;

    /// Those of settings, above a resonance that is known.
    pub(super) fn new(known: Option<&Resonance>, settings: &TuningSettings) -> Self {
        Self {
            lowest: settings.resonance,
            // That which a resonance has shown.
            side: match known.map(|known| known.mode.ratio) {
                Some(ratio) if ratio < 0.0 => EncoderSide::Load,
                Some(_) => EncoderSide::Motor,
                None => settings.encoder,
            },
        }
    }

    /// That at a place in their list, which ends at the sampling frequency.
    fn get(&self, place: usize, shown: Shown<'_>, sample_time: f64) -> Option<HiddenMode> {
        let modes = match shown {
            Shown::Modes(modes) if self.lowest.is_none() => modes,
            _ => &[],
        };
        let mode = modes.get(place).copied().or_else(|| {
            let first = self
                .lowest
                .or_else(|| Some(Self::RATIO * modes.last()?.frequency))?;
            let above = place - modes.len();
            let factor = libm::pow(Self::RATIO, above as f64);
            Some(HiddenMode::any(factor * first))
        });
        mode.filter(|mode| mode.frequency * sample_time < TAU)
    }

    /// True if a controller, command units per rad at ν, bears those at a place in their list; none behind the last.
    pub(super) fn is_borne(
        &self,
        place: usize,
        shown: Shown<'_>,
        servo: ServoBelow<'_>,
        controller: impl Fn(f64) -> Complex,
    ) -> Option<bool> {
        let HiddenMode { frequency, ratios } = self.get(place, shown, servo.sample_time)?;
        let bears = |ratio| servo.bears(frequency, ratio, &controller);
        let [least, largest] = ratios;
        let on_motor = largest.min(TuningSettings::HIDDEN_RATIO);
        let on_load = (least..=largest).contains(&Mode::ON_LOAD);
        let bears_motor = self.side == EncoderSide::Load || on_motor <= 0.0 || bears(on_motor);
        let bears_load = self.side == EncoderSide::Motor || !on_load || bears(Mode::ON_LOAD);
        Some(bears_motor && bears_load)
    }
}

impl ServoBelow<'_> {
    fn bears(&self, frequency: f64, ratio: f64, controller: &impl Fn(f64) -> Complex) -> bool {
        const CLOSEST: f64 = 1.0 / TuningSettings::HIDDEN_SENSITIVITY;
        let mode = Mode {
            frequency,
            damping: TuningSettings::HIDDEN_DAMPING,
            ratio,
        };
        let (_, part) = split(self.delay / self.sample_time);
        let sampled = SampledMode::new(&mode, part, self.sample_time);
        let (nu, _) = sampled.resonance();
        let command = controller(nu);
        let gain = command * self.sampled.at(nu);
        let diameter = command * self.sampled.of_mode(&sampled, nu);
        let centre = gain + Complex::ONE + diameter.scaled(0.5);
        let off_circle = libm::sqrt(centre.power()) - 0.5 * libm::sqrt(diameter.power());
        let grown = gain.scaled(1.0 + ratio.max(0.0));
        off_circle >= CLOSEST && from_minus_one(gain, grown) >= CLOSEST
    }
}

/// The distance of −1 from the way between two points.
fn from_minus_one(one: Complex, other: Complex) -> f64 {
    let (way, from) = (other - one, one + 1.0);
    let along = -(way.re * from.re + way.im * from.im) / way.power().max(f64::MIN_POSITIVE);
    libm::sqrt((from + way.scaled(along.clamp(0.0, 1.0))).power())
}
