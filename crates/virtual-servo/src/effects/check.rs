//! Which effects a servo can have.

use identifier_core::error::Allowed;
use identifier_core::parameters::ServoParameters;

use super::{EffectError, Effects, any};

impl Effects {
    /// Checks them for a servo of these parameters and a sample time, s.
    ///
    /// # Errors
    /// The first value that is not allowed, that lacks its companion or that contradicts another.
    pub fn check(&self, servo: &ServoParameters, sample_time: f64) -> Result<(), EffectError> {
        const NOT_NEGATIVE: Allowed = Allowed::AtLeast(0.0);
        const ANGULAR: Allowed = Allowed::Within(
            -Effects::LARGEST_ACCELERATION,
            Effects::LARGEST_ACCELERATION,
        );
        const DRIFT: Allowed = Allowed::Within(-Effects::FASTEST_DRIFT, Effects::FASTEST_DRIFT);

        let longest = Self::LONGEST_DELAY.min(Self::MAX_DELAYED_SAMPLES as f64 * sample_time);
        Allowed::Within(0.0, longest).check("delay", self.delay)?;
        if self.current_loop != 0.0 {
            let fastest = sample_time / Self::FASTEST_DECAY;
            Allowed::Within(fastest, Self::SLOWEST_CURRENT_LOOP)
                .check("current_loop", self.current_loop)?;
        }
        Allowed::Within(-servo.a, servo.a).check("asymmetry", self.asymmetry)?;
        Allowed::AtLeast(-servo.coulomb).check("low_speed_friction", self.low_speed_friction)?;
        NOT_NEGATIVE.check("low_speed_velocity", self.low_speed_velocity)?;
        for value in self.gravity {
            ANGULAR.check("gravity", value)?;
        }
        for value in self.ripple {
            ANGULAR.check("ripple", value)?;
        }
        let order = f64::from(self.ripple_order);
        Allowed::Within(0.0, f64::from(Self::HIGHEST_ORDER)).check("ripple_order", order)?;
        NOT_NEGATIVE.check("dead_band", self.dead_band)?;
        Allowed::Within(0.0, Self::HIGHEST_RESONANCE).check("resonance", self.resonance)?;
        if let Some(damping) = self.resonance_damping {
            Allowed::Within(0.0, 1.0).check("resonance_damping", damping)?;
        }
        if self.inertia_ratio != 0.0 {
            let [least, most] = Self::INERTIA_RATIOS;
            Allowed::Within(least, most).check("inertia_ratio", self.inertia_ratio)?;
        }
        NOT_NEGATIVE.check("backlash", self.backlash)?;
        DRIFT.check("gain_drift", self.gain_drift)?;
        DRIFT.check("friction_drift", self.friction_drift)?;
        NOT_NEGATIVE.check("hidden_limit", self.hidden_limit)?;
        for value in self.load_wander {
            NOT_NEGATIVE.check("load_wander", value)?;
        }
        self.check_companions()?;
        self.check_decay(servo, sample_time)
    }

    /// Refuses friction that brakes faster than can be integrated.
    fn check_decay(&self, servo: &ServoParameters, sample_time: f64) -> Result<(), EffectError> {
        if !self.change_the_motion() {
            return Ok(());
        }
        let fastest = Self::FASTEST_DECAY * (1.0 - self.inertia_ratio) / sample_time;
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
        let resonance = (self.resonance != 0.0, self.inertia_ratio != 0.0);
        together("low_speed_friction", "low_speed_velocity", low_speed)?;
        together("ripple", "ripple_order", ripple)?;
        together("resonance", "inertia_ratio", resonance)?;
        if self.resonance_damping.is_some() {
            together("resonance_damping", "resonance", (true, resonance.0))?;
        }
        let [deviation, time] = self.load_wander;
        if deviation > 0.0 {
            Allowed::Above(0.0).check("load_wander", time)?;
        }
        if self.backlash > 0.0 && resonance.0 {
            return Err(EffectError::Contradiction {
                effect: "backlash",
                other: "resonance",
            });
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
