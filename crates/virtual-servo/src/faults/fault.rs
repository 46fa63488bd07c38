use identifier_core::error::{Allowed, OutOfRange};

use crate::Effects;

/// A fault and when it is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InjectedFault {
    /// Its kind.
    pub kind: FaultKind,
    /// When it begins, s from the first sample.
    pub time: f64,
    /// Duration, s; infinite for one that stays. A jump has no duration.
    pub duration: f64,
    /// Size in the unit of its kind; without meaning for a kind without one.
    pub size: f64,
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident: $name:literal;)*) => {
        /// Kinds of failures.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum FaultKind {
            $($(#[$doc])* $kind,)*
        }

        impl FaultKind {
            /// All of them.
            pub const ALL: [Self; [$(Self::$kind),*].len()] = [$(Self::$kind),*];

            /// Its name in scenarios.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)*
                }
            }
        }
    };
}

kinds! {
    /// The encoder's counter is stuck; when it resumes, the counts between are lost.
    EncoderStuck: "encoder-stuck";
    /// The encoder gives no valid reading; its counter continues meanwhile.
    EncoderLost: "encoder-lost";
    /// The counter jumps by `size` counts.
    EncoderJump: "encoder-jump";
    /// The counter counts the other way.
    EncoderReversed: "encoder-reversed";
    /// No command acts.
    ActuatorDead: "actuator-dead";
    /// The share `size` of the command acts.
    ActuatorWeak: "actuator-weak";
    /// The command acts the other way.
    ActuatorReversed: "actuator-reversed";
    /// A load of `size`, rad/s², is there in addition.
    LoadStep: "load-step";
    /// Coulomb friction is higher by `size`, rad/s².
    FrictionRise: "friction-rise";
    /// Samples end too late: the command before acts for one more.
    Overrun: "overrun";
    /// A limit switch is open.
    LimitSwitch: "limit-switch";
    /// The amplifier reports a fault and disables its output.
    AmplifierFault: "amplifier-fault";
}

impl FaultKind {
    /// The allowed range of its size; none for a kind without one.
    #[must_use]
    pub fn sizes(self) -> Option<Allowed> {
        /// The largest jump: half the range of a counter of 32 bits.
        const MAX_JUMP: f64 = (1_u32 << 30) as f64;
        const MAX_ACCELERATION: f64 = Effects::LARGEST_ACCELERATION;
        match self {
            Self::EncoderJump => Some(Allowed::Within(-MAX_JUMP, MAX_JUMP)),
            Self::ActuatorWeak => Some(Allowed::Within(0.0, 1.0)),
            Self::LoadStep => Some(Allowed::Within(-MAX_ACCELERATION, MAX_ACCELERATION)),
            Self::FrictionRise => Some(Allowed::Within(0.0, MAX_ACCELERATION)),
            _ => None,
        }
    }
}

impl InjectedFault {
    /// One that stays.
    #[must_use]
    pub fn lasting(kind: FaultKind, time: f64, size: f64) -> Self {
        Self {
            kind,
            time,
            duration: f64::INFINITY,
            size,
        }
    }

    /// # Errors
    /// The value that is not allowed.
    pub fn check(&self) -> Result<(), OutOfRange> {
        Allowed::AtLeast(0.0).check("time", self.time)?;
        if self.duration != f64::INFINITY {
            Allowed::Above(0.0).check("duration", self.duration)?;
        }
        if let Some(allowed) = self.kind.sizes() {
            allowed.check("size", self.size)?;
        }
        Ok(())
    }
}
