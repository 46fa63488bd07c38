//! The resonance of two masses, as a frequency response shows it, and the servos that resonate alike.

use super::possible_servos::{PossibleServo, PossibleServos};
use crate::number::Complex;

/// The mode of a servo of two masses, in addition to the motion of both as one. From a command to the motor's position
/// the servo is b (1/(s (s + a)) + β/(s² + 2 ζ ω s + ω²)) e^(−sτ). The antiresonance lies at ω/√(1 + β).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// ω, rad/s.
    pub frequency: f64,
    /// ζ.
    pub damping: f64,
    /// β, the load's inertia over the motor's for an encoder on the motor; −1 for one on the load, whatever the inertias
    /// are.
    pub ratio: f64,
}

/// A mode that was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resonance {
    /// Its frequency, damping and inertias.
    pub mode: Mode,
    /// Standard errors of ln ω and ln ζ.
    pub errors: [f64; 2],
    /// True if its damping is that of the spring alone, and the servo's viscous friction damps the motor. False if a frequency
    /// response shows all of its damping.
    pub friction_on_motor: bool,
}

impl Mode {
    /// The largest ζ that is computed with.
    const MAX_DAMPING: f64 = 0.99;

    /// The pole −ζω + jω√(1 − ζ²), rad/s.
    pub(super) fn pole(&self) -> Complex {
        let damping = self.damping.min(Self::MAX_DAMPING);
        Complex {
            re: -damping * self.frequency,
            im: self.frequency * libm::sqrt(1.0 - damping * damping),
        }
    }

    /// β of an encoder on the load.
    pub const ON_LOAD: f64 = -1.0;

    /// ω/√(1 + β), the frequency at which the load holds the motor, rad/s; infinite for an encoder on the load.
    #[must_use]
    pub fn antiresonance(&self) -> f64 {
        self.frequency / libm::sqrt(1.0 + self.ratio)
    }
}

/// A servo of two masses that the measured one may be. Its largest sensitivity has an excess over 1, stated as a ratio
/// to that of the measured one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ResonantServo {
    pub(super) servo: PossibleServo,
    pub(super) mode: Mode,
    pub(super) excess: f64,
}

impl Resonance {
    /// The search range of ω in standard errors, and the least and largest part of ω for it. Backlash and wear move a
    /// resonance by per cents.
    const FREQUENCY: f64 = 3.0;
    const FREQUENCIES: (f64, f64) = (0.02, 0.15);

    /// The same for ln ζ. Friction of the motor and lines that are far apart make the measured damping too large.
    const DAMPING: f64 = 2.0;
    const DAMPINGS: (f64, f64) = (0.9, 1.4);

    /// The part by which b may differ.
    const GAIN: f64 = 0.05;

    /// The largest sensitivity's excess over 1 for a servo that differs, over that for the measured one.
    pub(super) const DIFFERING: f64 = 1.25;

    /// A possible servo, by its place: the identified one first, then those with the least possible damping.
    pub(super) fn servo(&self, servos: &PossibleServos, place: usize) -> Option<ResonantServo> {
        let identified = servos.identified();
        let a = if place == 0 {
            identified.a
        } else {
            servos.least_friction()
        };
        let [frequency_error, damping_error] = self.errors;
        let (least, most) = Self::FREQUENCIES;
        let off = (Self::FREQUENCY * frequency_error).max(least).min(most);
        let (least, most) = Self::DAMPINGS;
        let less = libm::exp(-(Self::DAMPING * damping_error).max(least).min(most));
        // Factors on ω, ζ and b, and the excess.
        let [frequency, damping, gain, excess] = match place {
            0 => [1.0, 1.0, 1.0, 1.0],
            1 => [1.0 - off, less, 1.0, Self::DIFFERING],
            2 => [1.0 + off, less, 1.0, Self::DIFFERING],
            3 => [1.0, less, 1.0 - Self::GAIN, Self::DIFFERING],
            4 => [1.0, less, 1.0 + Self::GAIN, Self::DIFFERING],
            _ => return None,
        };
        Some(ResonantServo {
            servo: PossibleServo {
                a,
                b: gain * identified.b,
                ..identified
            },
            mode: Mode {
                frequency: frequency * self.mode.frequency,
                damping: damping * self.mode.damping,
                ratio: self.mode.ratio,
            },
            excess,
        })
    }
}
