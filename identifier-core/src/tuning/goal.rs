/// What is asked of a loop: one knob.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Goal {
    /// The time from 10 to 90 % of a step of the reference, s.
    ResponseTime(f64),
    /// The magnitude ω of the double pole, rad/s.
    Bandwidth(f64),
    /// As stiff as this servo bears.
    Stiffest,
}

/// What keeps a loop from being faster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Cap {
    /// The margins at this delay: hold, computation, servo and velocity filter.
    Delay,
    /// The encoder's noise in the command.
    EncoderNoise,
    /// The command that a step asks for.
    CommandLimit,
    /// A resonance.
    Resonance,
}
