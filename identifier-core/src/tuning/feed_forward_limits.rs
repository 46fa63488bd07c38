//! The reference model of a feed-forward.
//!
//! All three poles lie at −ω_m. With x = ω_m t its step of one is 1 − e^(−x) (1 + x + x²/2). The velocity is ω_m e^(−x)
//! x²/2, the acceleration ω_m² e^(−x) (x − x²/2). Both begin at zero, so a delay in the loop turns little of the step
//! into an error.

use super::possible_servos::PossibleServo;
use super::{StepMeasure, TuningSettings};
use crate::control::FeedForwardSettings;

/// The limits of a feed-forward for a servo, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FeedForwardLimits {
    a: f64,
    b: f64,
    coulomb: f64,
    /// The largest that Coulomb friction may be.
    most_coulomb: f64,
    /// The largest acceleration allowed for a step, over the step, 1/s².
    acceleration: f64,
    step: f64,
}

impl FeedForwardLimits {
    /// The largest ω_m over ω. Above it, a servo with the delay that its margins allow overshoots by more than 3 %. The
    /// PID responds to the delay as to an error.
    const MAX_BANDWIDTHS: f64 = 3.0;

    /// The part of the command that the feed-forward may take. The rest is for the corrections of the PID.
    const COMMAND: f64 = 0.9;

    /// The largest Coulomb friction over ω² times the step. After an earlier motion the integral may already balance
    /// friction. The feed-forward then compensates it a second time. This displaces the servo by 0.4/ω² times the
    /// friction: by 2 % of the step.
    const COULOMB: f64 = 0.05;

    /// The largest part of the filter's rise time that the model may take. Above it there is no benefit.
    const WORTHWHILE: f64 = 0.9;

    /// The time from 10 to 90 % of the model's step, times ω_m.
    const RISE: f64 = 4.22;

    /// The remaining part of the step within which friction is no longer compensated in full. Within this part the
    /// servo has settled.
    const SETTLED: f64 = StepMeasure::<f64>::BAND;

    /// Halvings of the range of ω_m, in which the largest is found to 0.02 %.
    const HALVINGS: u32 = 12;

    /// For Coulomb friction and the largest that it may be, rad/s².
    pub(super) fn new(
        servo: &PossibleServo,
        [coulomb, most_coulomb]: [f64; 2],
        settings: &TuningSettings,
    ) -> Self {
        let free = Self::COMMAND * settings.command * servo.b - coulomb;
        Self {
            a: servo.a,
            b: servo.b,
            coulomb,
            most_coulomb,
            acceleration: free / settings.step,
            step: settings.step,
        }
    }

    /// The feed-forward for a loop of a bandwidth ω (rad/s) whose step without it has a rise time `rise` (s). None if
    /// the step would not rise faster. None if friction is too large to be compensated whatever the integral holds.
    pub(super) fn along(&self, bandwidth: f64, rise: f64) -> Option<FeedForwardSettings> {
        let slowest = Self::RISE / (Self::WORTHWHILE * rise);
        let fastest = Self::MAX_BANDWIDTHS * bandwidth;
        let is_rough = self.most_coulomb > Self::COULOMB * bandwidth * bandwidth * self.step;
        let allowed = |own: f64| peak_acceleration(own, self.a) <= self.acceleration;
        if is_rough || !allowed(slowest) {
            return None;
        }
        let mut range = [slowest, fastest.max(slowest)];
        if allowed(range[1]) {
            range[0] = range[1];
        }
        for _ in 0..Self::HALVINGS {
            let [low, high] = range;
            let middle = libm::sqrt(low * high);
            range = if allowed(middle) {
                [middle, high]
            } else {
                [low, middle]
            };
        }
        let [own, _] = range;
        Some(FeedForwardSettings {
            bandwidth: own,
            acceleration: 1.0 / self.b,
            velocity: self.a / self.b,
            coulomb: self.coulomb / self.b,
            coulomb_speed: Self::SETTLED * own * self.step,
        })
    }
}

/// The largest ÿ + a ẏ of a step of one, 1/s².
///
/// Its derivative is zero where (κ − 1) x²/2 − (κ − 2) x − 1 = 0, κ = a/ω_m.
fn peak_acceleration(bandwidth: f64, a: f64) -> f64 {
    let ratio = a / bandwidth;
    let root = libm::sqrt((ratio - 2.0) * ratio + 2.0);
    let x = 2.0 / (2.0 - ratio + root);
    bandwidth * bandwidth * libm::exp(-x) * x * (1.0 + 0.5 * (ratio - 1.0) * x)
}

impl FeedForwardSettings {
    /// The largest command of a step of the reference, over the step, command units per rad, but for Coulomb friction.
    pub(super) fn command_of_step(&self) -> f64 {
        self.acceleration * peak_acceleration(self.bandwidth, self.velocity / self.acceleration)
    }

    /// The largest speed of a step of the reference, over the step, 1/s. It is 2 e⁻² ω_m, and an eighth more for servos
    /// at the corners of the uncertainty.
    pub(super) fn speed_of_step(&self) -> f64 {
        0.305 * self.bandwidth
    }
}
