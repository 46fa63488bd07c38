//! The effects that a drawn log may have.

/// An effect of a servo, its sensor or its record beside a, b, c and d.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    /// A delay of the command.
    Delay,
    /// A first-order lag of the command.
    CurrentLoop,
    /// Viscous friction that differs with the direction.
    Asymmetry,
    /// Friction that grows with the square of the speed.
    QuadraticFriction,
    /// Stribeck friction.
    LowSpeedFriction,
    /// Gravity.
    Gravity,
    /// Cogging.
    Ripple,
    /// A gain that varies with the angle.
    TorqueRipple,
    /// A dead band of the bridge.
    DeadBand,
    /// Friction that grows with the motor's push.
    LoadDependentFriction,
    /// The command is recorded before a clip.
    HiddenLimit,
    /// A gain that differs with the direction.
    GainAsymmetry,
    /// A gain that drifts.
    GainDrift,
    /// Friction that drifts.
    FrictionDrift,
    /// Two masses with a spring.
    Resonance,
    /// Play before the encoder.
    Backlash,
    /// An inertia that varies with the angle.
    InertiaVariation,
    /// White noise of the encoder.
    Noise,
    /// An eccentric encoder.
    Eccentricity,
    /// The command is recorded late or early.
    Shift,
    /// The load steps.
    LoadSteps,
    /// Uneven sampling instants.
    Jitter,
}

impl Effect {
    /// All of them, with their names.
    pub const NAMES: [(Self, &'static str); 22] = [
        (Self::Delay, "delay"),
        (Self::CurrentLoop, "current-loop"),
        (Self::Asymmetry, "asymmetry"),
        (Self::QuadraticFriction, "quadratic-friction"),
        (Self::LowSpeedFriction, "low-speed-friction"),
        (Self::Gravity, "gravity"),
        (Self::Ripple, "ripple"),
        (Self::TorqueRipple, "torque-ripple"),
        (Self::DeadBand, "dead-band"),
        (Self::LoadDependentFriction, "load-dependent-friction"),
        (Self::HiddenLimit, "hidden-limit"),
        (Self::GainAsymmetry, "gain-asymmetry"),
        (Self::GainDrift, "gain-drift"),
        (Self::FrictionDrift, "friction-drift"),
        (Self::Resonance, "resonance"),
        (Self::Backlash, "backlash"),
        (Self::InertiaVariation, "inertia-variation"),
        (Self::Noise, "noise"),
        (Self::Eccentricity, "eccentricity"),
        (Self::Shift, "shift"),
        (Self::LoadSteps, "load-steps"),
        (Self::Jitter, "jitter"),
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize].1
    }

    /// True if the command's constant magnitude hides it: b is then smaller, and nothing contradicts.
    pub(super) const fn needs_several_commands(self) -> bool {
        matches!(self, Self::DeadBand | Self::HiddenLimit)
    }
}
