//! Gains from a bandwidth, by pole placement, and the conditions that need no frequency response.
//!
//! A mass without friction, q̈ = b u, gets the poles of a Butterworth filter. Its polynomial is s³ + 2ω s² + 2ω² s +
//! ω³. The gains follow from b k_d = 2ω, b k_p = 2ω², b k_i = ω³. Its sensitivity s³/(s³ + 2ω s² + 2ω² s + ω³) is
//! maximally flat and nowhere exceeds one. Among poles of magnitude ω without a peak these reject a load at low
//! frequency best.
//!
//! The same loop around a servo with friction, b/(s (s + a)), takes that controller times (s + a)/s. Without the second
//! integral that this needs,
//!
//! b k_d = 2ω, b k_p = 2ω (ω + a), b k_i = ω² (ω + 2a),
//!
//! with the characteristic polynomial s³ + (2ω + a) s² + 2ω (ω + a) s + ω² (ω + 2a). For a far above ω it tends to a
//! Butterworth filter of second order, s² + 2ω s + 2ω², and a pole at −a. The a used is the least that the servo may
//! have: more friction only damps.
//!
//! The zero of the integral would make a step of the reference overshoot. The reference filter, 1/(1 + s T_r) with T_r
//! = 1.5 k_p/k_i, is the second degree of freedom. It removes the zero and half of its speed. So no step of the
//! identified servo overshoots, whatever a is. Steps of servos with much friction overshoot very little.

use super::feed_forward_limits::FeedForwardLimits;
use super::possible_servos::PossibleServos;
use super::{Cap, Tuning, TuningSettings};
use crate::control::{FeedForwardSettings, Gains};

/// Gains for a bandwidth, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Design {
    pub(super) bandwidth: f64,
    pub(super) kp: f64,
    pub(super) kd: f64,
    pub(super) ki: f64,
    pub(super) cutoff: f64,
    /// Its place among those that are tried.
    pub(super) cutoff_place: u8,
    /// Time constant of the filter of the reference, s; zero for none.
    pub(super) reference_filter: f64,
    /// Frequency of the notch filter of the command, rad/s; zero for none.
    pub(super) notch: f64,
    /// None if only the filter shapes a step.
    pub(super) feed_forward: Option<FeedForwardSettings>,
    /// True if the cut-off is lower than it would be without the encoder's noise.
    pub(super) smoothed: bool,
    /// Standard deviation of the command from the encoder's rounding, command units.
    pub(super) noise: f64,
}

impl Design {
    /// The resulting gains.
    pub(super) fn from_tuning(tuning: &Tuning) -> Self {
        Self {
            bandwidth: tuning.bandwidth,
            kp: tuning.kp,
            kd: tuning.kd,
            ki: tuning.ki,
            cutoff: tuning.cutoff,
            cutoff_place: 0,
            reference_filter: tuning.reference_filter,
            notch: tuning.notch,
            feed_forward: tuning.feed_forward,
            smoothed: false,
            noise: tuning.predicted_response.noise,
        }
    }

    /// ω/(ω + a), which k_d and k_p have in them: one without friction, and zero with much.
    fn free(&self) -> f64 {
        self.bandwidth * self.kd / self.kp
    }

    /// The rise time of a step that only the reference filter shapes, s: 3.4/ω without friction to 2.2/ω with much.
    fn rise(&self) -> f64 {
        (2.2 + 1.2 * self.free()) / self.bandwidth
    }

    /// The largest command of a step of the reference, over the step, command units per rad. The acceleration is 0.33
    /// ω² without friction to 0.65 ω a with much, over b. The delay is the largest that the margins allow.
    pub(super) fn command_of_step(&self) -> f64 {
        match &self.feed_forward {
            Some(led) => led.command_of_step(),
            None => self.kp * (0.325 - 0.16 * self.free()),
        }
    }

    /// The largest speed of a step of the reference, over the step, 1/s. It is 0.34 ω without friction to 0.65 ω with
    /// much. An eighth is added for servos at the corners of the uncertainty.
    pub(super) fn speed_of_step(&self) -> f64 {
        match &self.feed_forward {
            Some(led) => led.speed_of_step(),
            None => self.bandwidth * (0.73 - 0.35 * self.free()),
        }
    }
}

/// The gains for a bandwidth by pole placement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    a: f64,
    b: f64,
    feed_forward_limits: FeedForwardLimits,
    settings: TuningSettings,
}

impl Placement {
    /// Cut-offs of the velocity estimate that are tried, as multiples of ω. The first costs a tenth of a radian of
    /// phase at the gain crossover. The last of those for noise uses the third's share of the margins. Lower ones take more
    /// gain from a resonance above than bandwidth from the loop.
    const CUTOFFS: [f64; 6] = [20.0, 14.0, 10.0, 7.0, 5.0, 3.5];
    const CUTOFFS_FOR_NOISE: u8 = 3;

    /// The time constant of the reference's filter, over that of the integral's zero.
    const REFERENCE_FILTER: f64 = 1.5;

    /// The gain crossover over ω.
    const CROSSOVER: f64 = 2.0;

    /// The highest cut-off that is chosen, per sample. Above it the estimate is nearly a plain difference of positions.
    const HIGHEST_CUTOFF: f64 = 2.0;

    /// The largest ω, per sample. No loop with a hold keeps its margins there.
    pub(super) const LARGEST_BANDWIDTH: f64 = 0.5;

    pub(super) fn new(
        servos: &PossibleServos,
        coulomb: [f64; 2],
        settings: &TuningSettings,
    ) -> Self {
        let identified = servos.identified();
        Self {
            a: servos.least_friction(),
            b: identified.b,
            feed_forward_limits: FeedForwardLimits::new(&identified, coulomb, settings),
            settings: *settings,
        }
    }

    /// The gains for a bandwidth ω, rad/s, with the cut-off that noise asks for.
    pub(super) fn design(&self, bandwidth: f64) -> Design {
        self.design_from(bandwidth, 0)
    }

    /// The gains of a design with the next lower cut-off of the velocity estimate, if there is one to choose.
    pub(super) fn with_lower_cutoff(&self, design: &Design) -> Option<Design> {
        let place = design.cutoff_place + 1;
        let may_be = self.settings.cutoff.is_none() && usize::from(place) < Self::CUTOFFS.len();
        may_be.then(|| Design {
            notch: design.notch,
            ..self.design_from(design.bandwidth, place)
        })
    }

    fn design_from(&self, bandwidth: f64, lowest: u8) -> Design {
        let square = bandwidth * bandwidth;
        let kp = 2.0 * bandwidth * (bandwidth + self.a) / self.b;
        let ki = square * (bandwidth + 2.0 * self.a) / self.b;
        let mut design = Design {
            bandwidth,
            kp,
            kd: 2.0 * bandwidth / self.b,
            ki,
            cutoff: 0.0,
            cutoff_place: lowest,
            reference_filter: Self::REFERENCE_FILTER * kp / ki,
            notch: 0.0,
            feed_forward: None,
            smoothed: false,
            noise: 0.0,
        };
        match self.settings.cutoff {
            Some(cutoff) => self.filter(&mut design, cutoff),
            None => {
                for (i, multiple) in (0..).zip(Self::CUTOFFS).skip(lowest.into()) {
                    let highest = Self::HIGHEST_CUTOFF / self.settings.sample_time;
                    self.filter(&mut design, (multiple * bandwidth).min(highest));
                    design.smoothed = i > 0;
                    design.cutoff_place = i;
                    let is_last = i + 1 >= Self::CUTOFFS_FOR_NOISE;
                    if is_last || design.noise <= self.settings.allowed_noise() {
                        break;
                    }
                }
            }
        }
        if self.settings.has_reference_model() {
            design.feed_forward = self.feed_forward_limits.along(bandwidth, design.rise());
        }
        if design.feed_forward.is_some() {
            design.reference_filter = 0.0;
        }
        design
    }

    /// The cap that forbids a design, of those that need no frequency response.
    pub(super) fn forbids(&self, design: &Design) -> Option<Cap> {
        let settings = &self.settings;
        let largest = settings.step * design.command_of_step();
        if design.bandwidth * settings.sample_time > Self::LARGEST_BANDWIDTH {
            Some(Cap::Delay)
        } else if largest > settings.command
            || design.kp.max(design.kd).max(design.ki) > Gains::LARGEST
        {
            Some(Cap::CommandLimit)
        } else if design.noise > settings.allowed_noise() {
            Some(Cap::EncoderNoise)
        } else {
            None
        }
    }

    /// The gain crossover of a design around one mass, rad/s.
    pub(super) fn crossover(design: &Design) -> f64 {
        Self::CROSSOVER * design.bandwidth
    }

    /// Sets a cut-off and the noise that it leaves.
    ///
    /// The encoder's noise and its rounding are white; the rounding's standard deviation is a count over √12. They pass
    /// k_p + (k_d/T) g (z − 1)/(z − p), g = 1 − p. Its impulse response is k_p + k_d g/T, then −(k_d g/T) g pᵏ. Their
    /// squares sum up to (k_p + k_d g/T)² + (k_d g/T)² g/(2 − g). The integral's part is as small as k_i T.
    fn filter(&self, design: &mut Design, cutoff: f64) {
        let g = -libm::expm1(-cutoff * self.settings.sample_time);
        let damping = design.kd * g / self.settings.sample_time;
        let first = design.kp + damping;
        let later = damping * damping * g / (2.0 - g);
        design.cutoff = cutoff;
        let (resolution, noise) = (self.settings.resolution, self.settings.noise);
        let variance = resolution * resolution / 12.0 + noise * noise;
        design.noise = libm::sqrt(variance * (first * first + later));
    }
}

impl Tuning {
    /// The largest command of a step of the reference, over the step, command units per rad.
    #[must_use]
    pub fn command_of_step(&self) -> f64 {
        Design::from_tuning(self).command_of_step()
    }

    /// The gain crossover around one mass, rad/s.
    #[must_use]
    pub fn crossover(&self) -> f64 {
        Placement::crossover(&Design::from_tuning(self))
    }

    /// The largest speed of a step of the reference, over the step, 1/s.
    #[must_use]
    pub fn speed_of_step(&self) -> f64 {
        Design::from_tuning(self).speed_of_step()
    }
}
