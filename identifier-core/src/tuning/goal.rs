use core::fmt;

/// The goal of a tuning: one knob.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Goal {
    /// The time from 10 to 90 % of a step of the reference, s.
    ResponseTime(f64),
    /// The magnitude ω of the loop's poles, rad/s.
    Bandwidth(f64),
    /// The stiffest loop that this servo allows.
    Stiffest,
}

/// The limit that keeps a loop from being faster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Cap {
    /// The margins at this delay: hold, computation, servo and velocity filter.
    Delay,
    /// The encoder's noise in the command.
    EncoderNoise,
    /// The command that a step needs.
    CommandLimit,
    /// A resonance.
    Resonance,
    /// A resonance that nothing has shown: between measured lines that show it in part, or above those that are known.
    UnseenResonance,
}

impl Cap {
    /// Its name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::EncoderNoise => "encoder-noise",
            Self::CommandLimit => "command-limit",
            Self::Resonance => "resonance",
            Self::UnseenResonance => "unseen-resonance",
        }
    }
}

impl fmt::Display for Cap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Delay => "the delay of hold, computation, servo and velocity estimate",
            Self::EncoderNoise => "the encoder's noise in the command",
            Self::CommandLimit => "the command that the step needs",
            Self::Resonance => "the resonance",
            Self::UnseenResonance => "a resonance that the motion did not show",
        })
    }
}
