use super::{IdentifiedServo, Limits};
use crate::control::{CommandLimit, Controller, Gains, Pid};
use crate::error::OutOfRange;
use crate::measurement::velocity::LowPass;
use crate::number::Number;
use crate::settings::ControllerSettings;
use crate::tuning::Tuning;
use crate::units::Units;

/// The PID that every half of a commissioning closes: with a low-pass velocity estimate.
pub(super) type Loop<N> = Controller<N, LowPass<N>>;

/// Gains that hold a servo, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HoldingGains {
    /// The PID.
    pub controller: ControllerSettings,
    /// The cut-off of its velocity estimate, rad/s.
    pub cutoff: f64,
}

impl HoldingGains {
    /// The ω T of the gains that hold a servo of which little is known: unknown delays of some samples
    /// cost them little phase.
    const CAREFUL: f64 = 0.08;

    /// Their largest ω, rad/s: a servo at rest asks for no more.
    const BRISK: f64 = 250.0;

    /// The part of the command that a count of the encoder may change.
    const OF_A_COUNT: f64 = 0.1;

    /// The cut-off over ω.
    const CUTOFF: f64 = 6.0;

    /// That hold a servo while it is studied: a double pole at −ω and one at −ω/5, placed for what is
    /// known of it.
    pub(super) fn careful(servo: &IdentifiedServo, units: &Units, limits: &Limits) -> Self {
        let b = servo.parameters.b.max(f64::MIN_POSITIVE);
        let [low, high] = limits.command;
        let authority = b * high.min(-low);
        let sampled = Self::CAREFUL / (units.sample_time() + servo.delay / 4.0);
        let noise = authority * Self::OF_A_COUNT / units.position_unit();
        // A count, seen through the filter, changes the command by (k_p + k_d ω_c) ρ.
        let quiet = libm::sqrt(noise / (1.4 + 2.2 * Self::CUTOFF));
        let omega = sampled.min(quiet).min(Self::BRISK);
        let kd = ((2.2 * omega - servo.parameters.a) / b).max(0.0);
        Self {
            controller: ControllerSettings {
                kp: 1.4 * omega * omega / b,
                kd,
                ki: 0.2 * omega * omega * omega / b,
                limit: limits.command,
            },
            cutoff: Self::CUTOFF * omega,
        }
    }

    /// Those that were tuned.
    pub(super) fn tuned(tuning: &Tuning, limits: &Limits) -> Self {
        Self {
            controller: ControllerSettings {
                kp: tuning.kp,
                kd: tuning.kd,
                ki: tuning.ki,
                limit: limits.command,
            },
            cutoff: tuning.cutoff,
        }
    }

    /// The loop in machine units.
    ///
    /// # Errors
    /// The gain or the cut-off that is out of its range.
    pub(super) fn build<N: Number>(&self, units: &Units) -> Result<Loop<N>, OutOfRange> {
        let ControllerSettings { kp, kd, ki, limit } = self.controller;
        let gains = Gains::new(kp, kd, ki)?;
        let limit = CommandLimit::of(limit)?;
        Ok(Controller::new(
            Pid::new(units, &gains, &limit),
            LowPass::new(units, self.cutoff)?,
        ))
    }
}
