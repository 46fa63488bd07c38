//! Why a drive stops what it is doing to its servo: the one table of core, drive, results and documentation.

use core::fmt;

/// Why a commissioning ended without new gains.
///
/// | number | reason |
/// |---|---|
/// | 100 | does not stand |
/// | 101 | does not move |
/// | 102 | one direction only |
/// | 110 | too little evidence |
/// | 111 | estimate at a bound |
/// | 120 | not predicted |
/// | 121–126 | not predicted, and the effect that the model lacks |
/// | 130 | no gains |
/// | 140 | slower or faster than promised |
/// | 141 | overshoots the promise |
/// | 142 | disturbed more than promised |
/// | 143 | never at rest |
/// | 150 | encoder stuck |
/// | 151 | encoder lost |
/// | 152 | encoder jumped |
/// | 153 | encoder or actuator reversed |
/// | 154 | actuator dead |
/// | 155 | actuator weak |
/// | 156 | oscillating |
/// | 157 | travel left |
/// | 158 | speed exceeded |
/// | 159 | overrun |
/// | 160 | time over |
/// | 170 | stopped |
/// | 171 | mode changed |
/// | 172 | link lost |
/// | 173 | power lost |
/// | 174 | limit switch |
/// | 175 | amplifier fault |
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
#[expect(missing_docs, reason = "each is described by its cause")]
pub enum StopReason {
    DoesNotStand,
    DoesNotMove,
    OneDirectionOnly,
    TooLittleEvidence,
    EstimateAtBound,
    NotPredicted,
    LacksResonance,
    LacksBacklash,
    LacksLowSpeedFriction,
    LacksGravity,
    LacksDeadBand,
    LacksRipple,
    NoGains,
    ResponseTimeMissed,
    OvershootExceeded,
    DisturbanceExceeded,
    NeverAtRest,
    EncoderStuck,
    EncoderLost,
    EncoderJumped,
    Reversed,
    ActuatorDead,
    ActuatorWeak,
    Oscillating,
    TravelLeft,
    SpeedExceeded,
    Overrun,
    TimeOver,
    Stopped,
    ModeChanged,
    LinkLost,
    PowerLost,
    LimitSwitch,
    AmplifierFault,
}

impl StopReason {
    /// All, by number.
    pub const ALL: [Self; 34] = [
        Self::DoesNotStand,
        Self::DoesNotMove,
        Self::OneDirectionOnly,
        Self::TooLittleEvidence,
        Self::EstimateAtBound,
        Self::NotPredicted,
        Self::LacksResonance,
        Self::LacksBacklash,
        Self::LacksLowSpeedFriction,
        Self::LacksGravity,
        Self::LacksDeadBand,
        Self::LacksRipple,
        Self::NoGains,
        Self::ResponseTimeMissed,
        Self::OvershootExceeded,
        Self::DisturbanceExceeded,
        Self::NeverAtRest,
        Self::EncoderStuck,
        Self::EncoderLost,
        Self::EncoderJumped,
        Self::Reversed,
        Self::ActuatorDead,
        Self::ActuatorWeak,
        Self::Oscillating,
        Self::TravelLeft,
        Self::SpeedExceeded,
        Self::Overrun,
        Self::TimeOver,
        Self::Stopped,
        Self::ModeChanged,
        Self::LinkLost,
        Self::PowerLost,
        Self::LimitSwitch,
        Self::AmplifierFault,
    ];

    /// Its number, the same in core, drive, results and documentation, in every version.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.entry().0
    }

    /// Its name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.entry().1
    }

    /// What happened.
    #[must_use]
    pub const fn cause(self) -> &'static str {
        self.entry().2
    }

    /// What to do about it.
    #[must_use]
    pub const fn remedy(self) -> &'static str {
        self.entry().3
    }

    /// Whether an effect that the model lacks, as this reason names it, may show as another reason.
    #[must_use]
    pub const fn may_show_as(self, other: Self) -> bool {
        let any_effect = matches!(
            other,
            Self::TooLittleEvidence
                | Self::NotPredicted
                | Self::ResponseTimeMissed
                | Self::OvershootExceeded
                | Self::DisturbanceExceeded
                | Self::NeverAtRest
                | Self::ActuatorWeak
                | Self::Oscillating
                | Self::TravelLeft
                | Self::SpeedExceeded
        );
        // What swings behind a spring, or lies in a play, moves against the command for a moment.
        let against = matches!(self, Self::LacksResonance | Self::LacksBacklash)
            && matches!(other, Self::Reversed);
        any_effect || against
    }

    /// Whether the servo is let go for it, whatever gains held it before: no gains help where encoder or
    /// actuator cannot be relied on, or somebody wants it to stand without force.
    #[must_use]
    pub const fn lets_go(self) -> bool {
        matches!(
            self,
            Self::EncoderStuck
                | Self::EncoderLost
                | Self::EncoderJumped
                | Self::Reversed
                | Self::ActuatorDead
                | Self::Overrun
                | Self::Stopped
                | Self::PowerLost
                | Self::LimitSwitch
                | Self::AmplifierFault
        )
    }

    /// The reason of a number.
    #[must_use]
    pub fn of_number(number: u8) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|reason| reason.number() == number)
    }

    /// The one table: number, name, cause, remedy.
    const fn entry(self) -> (u8, &'static str, &'static str, &'static str) {
        match self {
            Self::DoesNotStand => (
                100,
                "does-not-stand",
                "the servo moved on its own before the wiggle, faster than it can be caught within the travel",
                "hold it by a brake or by gains that work, or allow more travel",
            ),
            Self::DoesNotMove => (
                101,
                "does-not-move",
                "the servo did not move under the largest command",
                "free the axis, check encoder and amplifier, or allow a larger command",
            ),
            Self::OneDirectionOnly => (
                102,
                "one-direction-only",
                "the servo moved one way and not the other",
                "free the axis, or declare that it may only move one way",
            ),
            Self::TooLittleEvidence => (
                110,
                "too-little-evidence",
                "the motion within the limits does not determine the servo well enough",
                "allow more travel, speed or duration, or use a finer encoder",
            ),
            Self::EstimateAtBound => (
                111,
                "estimate-at-bound",
                "an estimate stands at a bound, so it is no result",
                "widen the bounds",
            ),
            Self::NotPredicted => (
                120,
                "not-predicted",
                "the identified model does not predict a motion that it was not fitted to; no single effect stands out",
                "record a log and have it replayed with further terms",
            ),
            Self::LacksResonance => (
                121,
                "lacks-resonance",
                "the servo does not follow as one mass: it resonates",
                "stiffen the coupling, or ask for a slower response",
            ),
            Self::LacksBacklash => (
                122,
                "lacks-backlash",
                "the servo has play at its reversals",
                "remove the play, or measure the position behind it",
            ),
            Self::LacksLowSpeedFriction => (
                123,
                "lacks-low-speed-friction",
                "friction is higher near standstill than the model has it",
                "lubricate, or ask for a slower response",
            ),
            Self::LacksGravity => (
                124,
                "lacks-gravity",
                "the load changes with the angle",
                "balance the axis, or commission it within less travel",
            ),
            Self::LacksDeadBand => (
                125,
                "lacks-dead-band",
                "small commands do not act",
                "compensate the amplifier's dead band",
            ),
            Self::LacksRipple => (
                126,
                "lacks-ripple",
                "the load ripples with the angle, as cogging does",
                "ask for a slower response, or allow more travel",
            ),
            Self::NoGains => (
                130,
                "no-gains",
                "no gains keep the margins at what was asked for",
                "ask for a slower response: the figure that would do is told",
            ),
            Self::ResponseTimeMissed => (
                140,
                "response-time-missed",
                "the rise time on the machine is not the promised one",
                "check for play, a changed load, or a limit of the current",
            ),
            Self::OvershootExceeded => (
                141,
                "overshoot-exceeded",
                "the overshoot on the machine is larger than promised",
                "ask for a slower response",
            ),
            Self::DisturbanceExceeded => (
                142,
                "disturbance-exceeded",
                "a disturbance moved the servo further than promised",
                "ask for a slower response, or check for play",
            ),
            Self::NeverAtRest => (
                143,
                "never-at-rest",
                "the servo did not come to rest under the new gains",
                "ask for a slower response, or check for play and stiction",
            ),
            Self::EncoderStuck => (
                150,
                "encoder-stuck",
                "the encoder stood still in motion",
                "check the encoder's coupling and wires",
            ),
            Self::EncoderLost => (
                151,
                "encoder-lost",
                "the encoder gave no valid reading",
                "check the encoder's supply and wires",
            ),
            Self::EncoderJumped => (
                152,
                "encoder-jumped",
                "the position jumped further than the servo can go in a sample",
                "check the encoder's shield and wires",
            ),
            Self::Reversed => (
                153,
                "reversed",
                "the servo moved against the command: encoder or actuator is reversed",
                "exchange two phases of the motor or the encoder's tracks",
            ),
            Self::ActuatorDead => (
                154,
                "actuator-dead",
                "the command moves nothing: the actuator is dead, or the encoder does not show the motion",
                "check the amplifier, its supply and its enable line, and then the encoder",
            ),
            Self::ActuatorWeak => (
                155,
                "actuator-weak",
                "the command acts less than it did or than was declared",
                "check the supply and the current limit of the amplifier",
            ),
            Self::Oscillating => (
                156,
                "oscillating",
                "the loop oscillates",
                "ask for a slower response",
            ),
            Self::TravelLeft => (
                157,
                "travel-left",
                "the servo left the travel",
                "allow more travel, or check what pushes the servo",
            ),
            Self::SpeedExceeded => (
                158,
                "speed-exceeded",
                "the servo was faster than it may be",
                "allow more speed, or check what pushes the servo",
            ),
            Self::Overrun => (
                159,
                "overrun",
                "several samples running took longer than the sample time",
                "lower the sample rate",
            ),
            Self::TimeOver => (
                160,
                "time-over",
                "the duration was over before there was enough evidence",
                "allow more time, travel or speed",
            ),
            Self::Stopped => (170, "stopped", "somebody stopped it", "order it again"),
            Self::ModeChanged => (
                171,
                "mode-changed",
                "another mode was asked for",
                "order it again",
            ),
            Self::LinkLost => (
                172,
                "link-lost",
                "the host was silent for too long",
                "check the line and the host",
            ),
            Self::PowerLost => (
                173,
                "power-lost",
                "the power was lost in the middle",
                "order it again",
            ),
            Self::LimitSwitch => (
                174,
                "limit-switch",
                "a limit switch opened",
                "move the axis off the switch, or allow less travel",
            ),
            Self::AmplifierFault => (
                175,
                "amplifier-fault",
                "the amplifier reports a fault",
                "check wiring and current limit of the amplifier",
            ),
        }
    }
}

impl fmt::Display for StopReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (number, _, cause, remedy) = self.entry();
        write!(f, "reason {number}: {cause}; {remedy}")
    }
}

#[cfg(test)]
mod tests {
    use super::StopReason;

    #[test]
    fn every_reason_has_a_number_and_a_name_of_its_own_in_their_order() {
        for pair in StopReason::ALL.windows(2) {
            assert!(pair[0].number() < pair[1].number(), "{pair:?}");
        }
        for (i, reason) in StopReason::ALL.iter().enumerate() {
            assert_eq!(StopReason::of_number(reason.number()), Some(*reason));
            for other in &StopReason::ALL[i + 1..] {
                assert_ne!(reason.name(), other.name());
            }
        }
        assert_eq!(StopReason::of_number(0), None);
    }

    #[test]
    fn an_effect_hides_no_fault_and_nobody_s_stop() {
        let plain = [
            StopReason::EncoderLost,
            StopReason::EncoderStuck,
            StopReason::EncoderJumped,
            StopReason::ActuatorDead,
            StopReason::Overrun,
            StopReason::Stopped,
            StopReason::LimitSwitch,
            StopReason::AmplifierFault,
        ];
        for effect in StopReason::ALL {
            assert!(!plain.iter().any(|&other| effect.may_show_as(other)));
            let moves = matches!(
                effect,
                StopReason::LacksResonance | StopReason::LacksBacklash
            );
            assert_eq!(effect.may_show_as(StopReason::Reversed), moves);
        }
        assert!(StopReason::LacksGravity.may_show_as(StopReason::NotPredicted));
    }
}
