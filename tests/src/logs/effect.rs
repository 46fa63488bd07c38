//! The effects that a drawn log may have.

use identifier_log::named;

named! {
    /// An effect of a servo, its sensor or its record beside a, b, c and d.
    #[derive(PartialOrd, Ord, Hash)]
    pub enum Effect {
        /// A delay of the command.
        Delay = "delay",
        /// A first-order lag of the command.
        CurrentLoop = "current-loop",
        /// Viscous friction that differs with the direction.
        Asymmetry = "asymmetry",
        /// Friction that grows with the square of the speed.
        QuadraticFriction = "quadratic-friction",
        /// Stribeck friction.
        LowSpeedFriction = "low-speed-friction",
        /// Gravity.
        Gravity = "gravity",
        /// Cogging.
        Ripple = "ripple",
        /// A gain that varies with the angle.
        TorqueRipple = "torque-ripple",
        /// A dead band of the bridge.
        DeadBand = "dead-band",
        /// Friction that grows with the motor's push.
        LoadDependentFriction = "load-dependent-friction",
        /// The command is recorded before a clip.
        HiddenLimit = "hidden-limit",
        /// A gain that differs with the direction.
        GainAsymmetry = "gain-asymmetry",
        /// A gain that drifts.
        GainDrift = "gain-drift",
        /// Friction that drifts.
        FrictionDrift = "friction-drift",
        /// Two masses with a spring.
        Resonance = "resonance",
        /// Play before the encoder.
        Backlash = "backlash",
        /// An inertia that varies with the angle.
        InertiaVariation = "inertia-variation",
        /// White noise of the encoder.
        Noise = "noise",
        /// An eccentric encoder.
        Eccentricity = "eccentricity",
        /// The command is recorded late or early.
        Shift = "shift",
        /// The load steps.
        LoadSteps = "load-steps",
        /// Uneven sampling instants.
        Jitter = "jitter",
    }
}

impl Effect {
    /// True if the command's constant magnitude hides it: b is then smaller, and nothing contradicts.
    pub(super) const fn needs_several_commands(self) -> bool {
        matches!(self, Self::DeadBand | Self::HiddenLimit)
    }
}
