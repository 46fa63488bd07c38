use std::fmt;

use identifier_core::parameters::Unknown;

macro_rules! causes {
    ($($(#[$doc:meta])* $cause:ident: $name:literal, $unknown:expr, $meaning:literal, $remedy:literal;)*) => {
        /// An effect of the servo that the model lacks.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Cause {
            $($(#[$doc])* $cause,)*
        }

        impl Cause {
            /// All.
            pub const ALL: &'static [Self] = &[$(Self::$cause),*];

            /// The first unknown of a model that has the effect; none where no model has it.
            const fn unknown(self) -> Option<Unknown> {
                match self {
                    $(Self::$cause => $unknown,)*
                }
            }

            /// Its name in results.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$cause => $name,)*
                }
            }

            /// A description.
            #[must_use]
            pub const fn meaning(self) -> &'static str {
                match self {
                    $(Self::$cause => $meaning,)*
                }
            }

            /// The remedy.
            #[must_use]
            pub const fn remedy(self) -> &'static str {
                match self {
                    $(Self::$cause => $remedy,)*
                }
            }
        }
    };
}

causes! {
    /// A delay between command and acceleration, or a current loop, which looks the same.
    Delay: "delay", Some(Unknown::Delay), "a delay or a current loop between command and motion",
        "set amplifier.delay, or have it estimated: required_terms = [\"delay\"]";
    /// Coulomb friction that is not estimated.
    Coulomb: "coulomb", Some(Unknown::Coulomb), "Coulomb friction",
        "estimate it too: \"coulomb\" in identifier.parameters, with an estimator that has it, such as law = \
         \"gauss-newton\"";
    /// A load that is not estimated.
    Load: "load", Some(Unknown::Load), "a constant load",
        "estimate it too: \"load\" in identifier.parameters, with an estimator that has it, such as law = \
         \"gauss-newton\"";
    /// Viscous friction that differs with the direction.
    Asymmetry: "asymmetry", Some(Unknown::Asymmetry), "viscous friction that differs with the direction",
        "have it estimated: required_terms = [\"asymmetry\"]";
    /// Friction that changes at low speed.
    LowSpeedFriction: "low-speed-friction", Some(Unknown::LowSpeed), "friction that changes at low speed",
        "have it estimated: required_terms = [\"low-speed\"] and low_speed_velocity";
    /// Friction that grows with the square of the velocity.
    QuadraticFriction: "quadratic-friction", None, "friction that grows with the square of the velocity",
        "have it estimated from the whole log, with law = \"fit\", or identify at the speeds that matter";
    /// A force that depends on the angle, with a period of one revolution.
    Gravity: "gravity", Some(Unknown::GravitySine), "gravity, or another force that depends on the angle",
        "have it estimated, on an absolute angle: required_terms = [\"gravity\"]";
    /// A force that repeats many times a revolution.
    Ripple: "ripple", Some(Unknown::RippleSine), "ripple (cogging)",
        "have it estimated: required_terms = [\"ripple\"] and ripple_order";
    /// A dead band of the bridge.
    DeadBand: "dead-band", Some(Unknown::DeadBand), "a dead band of the power stage",
        "set amplifier.dead_band, or have it estimated: required_terms = [\"dead-band\"]";
    /// Two masses with a spring between them.
    Resonance: "resonance", None, "a resonance of two masses",
        "have it estimated from the whole log, with law = \"fit\", or excite with sines well below the resonance";
    /// Play between motor and encoder.
    Backlash: "backlash", None, "backlash between motor and encoder",
        "measure the position at the motor";
    /// An encoder off its centre.
    Eccentricity: "eccentricity", None, "an eccentric encoder",
        "have it estimated from the whole log, with law = \"fit\", or centre the encoder";
    /// A gain that drifts: the supply, or the motor's temperature.
    GainDrift: "gain-drift", None, "a gain that drifts",
        "have it estimated from the whole log, with law = \"fit\", or stabilise the supply";
    /// Friction that drifts.
    FrictionDrift: "friction-drift", None, "friction that drifts",
        "have it estimated from the whole log, with law = \"fit\", or warm up first";
    /// A current loop whose time constant is no delay.
    CurrentLoop: "current-loop", None, "a current loop between command and motion",
        "set amplifier.current_loop, or have it estimated from the whole log, with law = \"fit\"";
    /// Friction that grows with the load.
    LoadFriction: "load-friction", None, "friction that grows with the load",
        "have it estimated from the whole log, with law = \"fit\", or identify at the loads that matter";
    /// A gain that differs between the directions.
    GainAsymmetry: "gain-asymmetry", None, "a gain that differs between the directions",
        "have it estimated from the whole log, with law = \"fit\", or calibrate the amplifier in both directions";
    /// A gain that depends on the angle.
    TorqueRipple: "torque-ripple", None, "a gain that depends on the angle (torque ripple)",
        "have it estimated from the whole log, with law = \"fit\", or check the offset of the commutation";
    /// An inertia that depends on the angle.
    VaryingInertia: "varying-inertia", None, "an inertia that depends on the angle",
        "have it estimated from the whole log, with law = \"fit\", or identify near the pose that matters";
    /// A load that steps.
    LoadSteps: "load-steps", None, "load steps",
        "leave out the parts with another load (--cut, or log.cut), or identify with one load";
    /// Sampling instants that are uneven.
    Jitter: "jitter", None, "uneven sampling instants",
        "read the encoder in a timer interrupt, or record the time of each reading";
    /// A limit of the command that the recorded command does not have.
    HiddenLimit: "hidden-limit", None, "a limit of the command that is not in the recorded command",
        "have it estimated from the whole log, with law = \"fit\", or keep the command away from the limit";
}

impl Cause {
    /// The effect that a model without an unknown lacks.
    #[must_use]
    pub fn lacking(unknown: Unknown) -> Option<Self> {
        let mut all = Self::ALL.iter().copied();
        all.find(|cause| cause.unknown() == Some(unknown))
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.meaning())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_without_an_unknown_lacks_something_with_a_name() {
        // A servo always has a and b; the second of two sizes belongs to the first.
        let own = [Unknown::A, Unknown::B];
        let second = [Unknown::GravityCosine, Unknown::RippleCosine];
        for unknown in Unknown::ALL {
            let is_exempt = own.contains(&unknown) || second.contains(&unknown);
            assert!(
                is_exempt || Cause::lacking(unknown).is_some(),
                "{unknown:?}"
            );
        }
    }
}
