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
        "set amplifier.delay, or let it be estimated with required_terms = [\"delay\"]";
    /// Coulomb friction that is not estimated.
    Coulomb: "coulomb", Some(Unknown::Coulomb), "Coulomb friction",
        "estimate it too: \"coulomb\" in identifier.parameters, of a law that has it, such as \"gauss-newton\"";
    /// A load that is not estimated.
    Load: "load", Some(Unknown::Load), "a constant load",
        "estimate it too: \"load\" in identifier.parameters, of a law that has it, such as \"gauss-newton\"";
    /// Viscous friction that differs with the direction.
    Asymmetry: "asymmetry", Some(Unknown::Asymmetry), "viscous friction that differs with the direction",
        "let it be estimated with required_terms = [\"asymmetry\"]";
    /// Friction that changes at low speed.
    LowSpeedFriction: "low-speed-friction", Some(Unknown::LowSpeed), "friction that changes at low speed",
        "let it be estimated with required_terms = [\"low-speed\"] and low_speed_velocity";
    /// Friction that grows with the square of the velocity.
    QuadraticFriction: "quadratic-friction", None, "friction that grows with the square of the velocity",
        "let one fit to the whole record estimate it, with law = \"fit\", or identify at the speeds that matter";
    /// A force that depends on the angle, with a period of one revolution.
    Gravity: "gravity", Some(Unknown::GravitySine), "gravity, or another force that goes with the angle",
        "let it be estimated with required_terms = [\"gravity\"], on an absolute angle";
    /// A force that repeats many times a revolution.
    Ripple: "ripple", Some(Unknown::RippleSine), "ripple (cogging)",
        "let it be estimated with required_terms = [\"ripple\"] and ripple_order";
    /// A dead band of the bridge.
    DeadBand: "dead-band", Some(Unknown::DeadBand), "a dead band of the bridge",
        "set amplifier.dead_band, or let it be estimated with required_terms = [\"dead-band\"]";
    /// Two masses with a spring between them.
    Resonance: "resonance", None, "a resonance of two masses",
        "let one fit to the whole record estimate it, with law = \"fit\", \
         or excite smoothly, with sines well below the resonance";
    /// Play between motor and encoder.
    Backlash: "backlash", None, "backlash between motor and encoder",
        "measure at the motor";
    /// An encoder off its centre.
    Eccentricity: "eccentricity", None, "an encoder off its centre",
        "let one fit to the whole record estimate it, with law = \"fit\", or centre the encoder";
    /// A gain that drifts: the supply, or the motor's temperature.
    GainDrift: "gain-drift", None, "a gain that drifts",
        "let one fit to the whole record estimate it, with law = \"fit\", or steady the supply";
    /// Friction that drifts.
    FrictionDrift: "friction-drift", None, "friction that drifts",
        "let one fit to the whole record estimate it, with law = \"fit\", or warm up first";
    /// A current loop whose time constant is no delay.
    CurrentLoop: "current-loop", None, "a current loop between command and motion",
        "set amplifier.current_loop, or let one fit to the whole record estimate it, with law = \"fit\"";
    /// Friction that grows with the load.
    LoadFriction: "load-friction", None, "friction that grows with the load",
        "let one fit to the whole record estimate it, with law = \"fit\", or identify at the loads that matter";
    /// A gain that differs between the directions.
    GainAsymmetry: "gain-asymmetry", None, "a gain that differs between the directions",
        "let one fit to the whole record estimate it, with law = \"fit\", \
         or calibrate the amplifier in both directions";
    /// A gain that depends on the angle.
    TorqueRipple: "torque-ripple", None, "a gain that goes with the angle (torque ripple)",
        "let one fit to the whole record estimate it, with law = \"fit\", or check the commutation's offset";
    /// An inertia that depends on the angle.
    VaryingInertia: "varying-inertia", None, "an inertia that goes with the angle",
        "let one fit to the whole record estimate it, with law = \"fit\", or identify about the pose that matters";
    /// A load that steps.
    LoadSteps: "load-steps", None, "a load that steps",
        "leave out the parts with other loads with log.cut, or identify with one load";
    /// Sampling instants that are uneven.
    Jitter: "jitter", None, "uneven sampling instants",
        "read the encoder by a timer's interrupt, or record the time of each reading";
    /// A limit of the command that the recorded command does not have.
    HiddenLimit: "hidden-limit", None, "a limit of the command that is not in the recorded command",
        "let one fit to the whole record estimate it, with law = \"fit\", or keep the command away from the limit";
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
        // A servo has a and b always; the second of two sizes goes with the first.
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
