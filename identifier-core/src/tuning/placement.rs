//! Gains from a bandwidth, by pole placement, and the conditions that need no frequency response.
//!
//! The characteristic polynomial of the loop in continuous time is
//! s³ + (a + b k_d) s² + b k_p s + b k_i. A double pole at −ω and a real pole at −p ask for
//!
//! b k_d = 2ω + p − a, b k_p = ω² + 2ω p, b k_i = ω² p, with p = ω/5.
//!
//! Where the servo's own friction damps more than that, k_d is zero and the friction places the third pole,
//! p = a − 2ω. For a the least is taken that the servo may have: friction that turns out to be more only
//! damps.

use super::possible_servos::PossibleServos;
use super::{Cap, Tuning, TuningSettings};
use crate::control::Gains;

/// The third pole, as a part of the double pole's ω.
pub(super) const THIRD_POLE: f64 = 0.2;

/// Gains for a bandwidth, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Design {
    pub(super) bandwidth: f64,
    pub(super) kp: f64,
    pub(super) kd: f64,
    pub(super) ki: f64,
    pub(super) cutoff: f64,
    /// Time constant of the filter of the reference, s; zero for none.
    pub(super) reference_filter: f64,
    /// True if the cut-off is lower than it would be without the encoder's noise.
    pub(super) smoothed: bool,
    /// Standard deviation of the command from the encoder's rounding, command units.
    pub(super) noise: f64,
}

impl Design {
    /// The gains that were found.
    pub(super) fn from_tuning(tuning: &Tuning) -> Self {
        Self {
            bandwidth: tuning.bandwidth,
            kp: tuning.kp,
            kd: tuning.kd,
            ki: tuning.ki,
            cutoff: tuning.cutoff,
            reference_filter: tuning.reference_filter,
            smoothed: false,
            noise: tuning.promise.noise,
        }
    }
}

/// The gains for a bandwidth by pole placement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    a: f64,
    b: f64,
    delay: f64,
    settings: TuningSettings,
}

impl Placement {
    /// Cut-offs of the velocity estimate that are tried, as multiples of ω. The first takes a tenth of
    /// a radian of phase at ω; with the last the third's share of the margins is spent.
    const CUTOFFS: [f64; 3] = [10.0, 7.0, 5.0];

    /// The highest cut-off that is chosen, per sample: from there on the estimate is hardly more than a
    /// difference of positions.
    const HIGHEST_CUTOFF: f64 = 2.0;

    /// The largest ω, per sample. No loop with a hold keeps its margins there.
    pub(super) const LARGEST_BANDWIDTH: f64 = 0.5;

    /// The least ratio of the lowest resonance to the gain crossover: at the resonance the gain of the
    /// rigid servo is then a quarter.
    const RESONANCE_OVER_CROSSOVER: f64 = 4.0;

    pub(super) fn new(servos: &PossibleServos, settings: &TuningSettings) -> Self {
        let identified = servos.identified();
        Self {
            a: servos.least_friction(),
            b: identified.b,
            delay: identified.delay,
            settings: *settings,
        }
    }

    /// The gains for a bandwidth ω, rad/s.
    pub(super) fn design(&self, bandwidth: f64) -> Design {
        let needed = 2.0 * bandwidth + THIRD_POLE * bandwidth - self.a;
        let third = if needed > 0.0 {
            THIRD_POLE * bandwidth
        } else {
            self.a - 2.0 * bandwidth
        };
        let square = bandwidth * bandwidth;
        let mut design = Design {
            bandwidth,
            kp: (square + 2.0 * bandwidth * third) / self.b,
            kd: needed.max(0.0) / self.b,
            ki: square * third / self.b,
            cutoff: 0.0,
            reference_filter: 0.0,
            smoothed: false,
            noise: 0.0,
        };
        match self.settings.cutoff {
            Some(cutoff) => self.filter(&mut design, cutoff),
            None => {
                for (i, multiple) in Self::CUTOFFS.into_iter().enumerate() {
                    let highest = Self::HIGHEST_CUTOFF / self.settings.sample_time;
                    self.filter(&mut design, (multiple * bandwidth).min(highest));
                    design.smoothed = i > 0;
                    if design.noise <= self.settings.allowed_noise() {
                        break;
                    }
                }
            }
        }
        design
    }

    /// The cap that forbids a design, of those that need no frequency response.
    pub(super) fn forbids(&self, design: &Design) -> Option<Cap> {
        let TuningSettings {
            sample_time,
            command,
            step,
            resonance,
            ..
        } = self.settings;
        // Until the servo answers, the integral takes in the whole step.
        let largest = step * (design.kp + design.ki * (self.delay + sample_time));
        let crossover = Self::crossover(design);
        let resonates =
            resonance.is_some_and(|lowest| Self::RESONANCE_OVER_CROSSOVER * crossover > lowest);
        if design.bandwidth * sample_time > Self::LARGEST_BANDWIDTH {
            Some(Cap::Delay)
        } else if largest > command || design.kp.max(design.kd).max(design.ki) > Gains::LARGEST {
            Some(Cap::CommandLimit)
        } else if resonates {
            Some(Cap::Resonance)
        } else if design.noise > self.settings.allowed_noise() {
            Some(Cap::EncoderNoise)
        } else {
            None
        }
    }

    /// The gain crossover of a design around one mass, rad/s.
    pub(super) fn crossover(design: &Design) -> f64 {
        (2.0 + THIRD_POLE) * design.bandwidth
    }

    /// Sets a cut-off and the noise that it leaves.
    ///
    /// The encoder's noise and its rounding, white with a standard deviation of a count over √12, pass
    /// k_p + (k_d/T) g (z − 1)/(z − p), g = 1 − p: its impulse response is k_p + k_d g/T, then
    /// −(k_d g/T) g pᵏ, and the squares of these sum up to
    /// (k_p + k_d g/T)² + (k_d g/T)² g/(2 − g). The integral's part is as small as k_i T.
    fn filter(&self, design: &mut Design, cutoff: f64) {
        let g = -libm::expm1(-cutoff * self.settings.sample_time);
        let damping = design.kd * g / self.settings.sample_time;
        let first = design.kp + damping;
        let later = damping * damping * g / (2.0 - g);
        design.cutoff = cutoff;
        let TuningSettings {
            resolution, noise, ..
        } = self.settings;
        let variance = resolution * resolution / 12.0 + noise * noise;
        design.noise = libm::sqrt(variance * (first * first + later));
    }
}
