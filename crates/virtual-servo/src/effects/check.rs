//! Which effects a servo can have.

use identifier_core::error::Allowed;
use identifier_core::parameters::ServoParameters;

use super::{EffectError, Effects, any};

impl Effects {
    /// Checks them for a servo of these parameters and a sample time, s.
    ///
    /// # Errors
    /// The first value that is not allowed or that lacks its companion.
    pub fn check(&self, servo: &ServoParameters, sample_time: f64) -> Result<(), EffectError> {
        self.check_ranges(servo, sample_time)?;
        self.check_companions()?;
        self.check_decay(servo, sample_time)
    }

    /// Refuses friction that brakes faster than can be integrated.
    fn check_decay(&self, servo: &ServoParameters, sample_time: f64) -> Result<(), EffectError> {
        if !self.change_the_motion() {
            return Ok(());
        }
        let [sine, cosine] = self.inertia_variation;
        let least_inertia = (1.0 - self.inertia_ratio) * (1.0 - libm::hypot(sine, cosine));
        let fastest = Self::FASTEST_DECAY * least_inertia / sample_time;
        Allowed::AtMost(fastest).check("a", servo.a)?;
        let slowest = self.low_speed_friction.abs() / fastest;
        Allowed::AtLeast(slowest).check("low_speed_velocity", self.low_speed_velocity)?;
        Ok(())
    }

    fn check_companions(&self) -> Result<(), EffectError> {
        let low_speed = (
            self.low_speed_friction != 0.0,
            self.low_speed_velocity != 0.0,
        );
        let ripple = (any(self.ripple), self.ripple_order != 0);
        let torque_ripple = (any(self.torque_ripple), self.torque_ripple_order != 0);
        let inertia = (any(self.inertia_variation), self.inertia_order != 0);
        let resonance = (self.resonance != 0.0, self.inertia_ratio != 0.0);
        together("low_speed_friction", "low_speed_velocity", low_speed)?;
        together("ripple", "ripple_order", ripple)?;
        together("torque_ripple", "torque_ripple_order", torque_ripple)?;
        together("inertia_variation", "inertia_order", inertia)?;
        together("resonance", "inertia_ratio", resonance)?;
        if self.encoder_on_load {
            together("encoder_on_load", "resonance", (true, resonance.0))?;
        }
        if self.load_friction > 0.0 {
            together("load_friction", "resonance", (true, resonance.0))?;
        }
        if self.resonance_damping.is_some() {
            together("resonance_damping", "resonance", (true, resonance.0))?;
        }
        let [deviation, time] = self.load_wander;
        if deviation > 0.0 {
            Allowed::Above(0.0).check("load_wander", time)?;
        }
        Ok(())
    }
}

/// Refuses one of two values without the other.
fn together(
    first: &'static str,
    second: &'static str,
    given: (bool, bool),
) -> Result<(), EffectError> {
    let (effect, needs) = match given {
        (true, false) => (first, second),
        (false, true) => (second, first),
        _ => return Ok(()),
    };
    Err(EffectError::Needs { effect, needs })
}
