use std::fmt;

/// An effect of the servo that the model lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cause {
    /// A delay between command and acceleration, or a current loop, which looks the same.
    Delay,
    /// Coulomb friction that is not estimated.
    Coulomb,
    /// A load that is not estimated.
    Load,
    /// Viscous friction that differs with the direction.
    Asymmetry,
    /// Friction that changes at low speed.
    LowSpeedFriction,
    /// Friction that grows with the square of the velocity.
    QuadraticFriction,
    /// A force that goes with the angle, once a revolution.
    Gravity,
    /// A force that repeats many times a revolution.
    Ripple,
    /// A dead band of the bridge.
    DeadBand,
    /// Two masses with a spring between them.
    Resonance,
    /// Play between motor and encoder.
    Backlash,
    /// An encoder off its centre.
    Eccentricity,
    /// A gain that drifts: the supply, or the motor's temperature.
    GainDrift,
    /// Friction that drifts.
    FrictionDrift,
    /// A limit of the command that the recorded command does not have.
    HiddenLimit,
}

impl Cause {
    /// Its name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::Coulomb => "coulomb",
            Self::Load => "load",
            Self::Asymmetry => "asymmetry",
            Self::LowSpeedFriction => "low-speed-friction",
            Self::QuadraticFriction => "quadratic-friction",
            Self::Gravity => "gravity",
            Self::Ripple => "ripple",
            Self::DeadBand => "dead-band",
            Self::Resonance => "resonance",
            Self::Backlash => "backlash",
            Self::Eccentricity => "eccentricity",
            Self::GainDrift => "gain-drift",
            Self::FrictionDrift => "friction-drift",
            Self::HiddenLimit => "hidden-limit",
        }
    }

    /// A description.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Delay => "a delay or a current loop between command and motion",
            Self::Coulomb => "Coulomb friction",
            Self::Load => "a constant load",
            Self::Asymmetry => "viscous friction that differs with the direction",
            Self::LowSpeedFriction => "friction that changes at low speed",
            Self::QuadraticFriction => "friction that grows with the square of the velocity",
            Self::Gravity => "gravity, or another force that goes with the angle",
            Self::Ripple => "ripple (cogging)",
            Self::DeadBand => "a dead band of the bridge",
            Self::Resonance => "a resonance of two masses",
            Self::Backlash => "backlash between motor and encoder",
            Self::Eccentricity => "an encoder off its centre",
            Self::GainDrift => "a gain that drifts",
            Self::FrictionDrift => "friction that drifts",
            Self::HiddenLimit => "a limit of the command that is not in the recorded command",
        }
    }

    /// The remedy.
    #[must_use]
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::Delay => "set amplifier.delay, or let it be estimated with terms = [\"delay\"]",
            Self::Coulomb => "add \"coulomb\" to identifier.parameters",
            Self::Load => "add \"load\" to identifier.parameters",
            Self::Asymmetry => "let it be estimated with terms = [\"asymmetry\"]",
            Self::LowSpeedFriction => {
                "let it be estimated with terms = [\"low-speed\"] and low_speed_velocity"
            }
            Self::QuadraticFriction => {
                "the model has no such term: identify at the speeds that matter"
            }
            Self::Gravity => "let it be estimated with terms = [\"gravity\"], on an absolute angle",
            Self::Ripple => "let it be estimated with terms = [\"ripple\"] and ripple_order",
            Self::DeadBand => {
                "set amplifier.dead_band, or let it be estimated with terms = [\"dead-band\"]"
            }
            Self::Resonance => {
                "the model has one mass: excite more slowly, well below the resonance"
            }
            Self::Backlash => "the model has no play: measure at the motor, or preload the gear",
            Self::Eccentricity => "centre the encoder, or leave it: it hardly moves the estimates",
            Self::GainDrift => {
                "let the estimates follow with identifier.memory, or steady the supply"
            }
            Self::FrictionDrift => {
                "let the estimates follow with identifier.memory, or warm up first"
            }
            Self::HiddenLimit => "record the command behind every limit, or keep it away from them",
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.meaning())
    }
}
