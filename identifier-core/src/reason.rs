//! The one catalogue of reasons: why a drive or a commissioning stops, a first fit fails, or gains have no valid
//! prediction. Each reason has a number, name, cause and remedy. They are the same in core, drive, results and
//! documentation.

use core::fmt;

/// The count of an encoder after a reason.
enum Position {
    /// It is that of the axis, as before: the reason is no sign of an encoder that counts wrong, as a test shows.
    Known,
    /// It may be another: counts were lost, or may have been.
    Uncertain,
}

/// How power is taken from an axis with a holding brake, by the categories of IEC 60204-1, 9.2.2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopCategory {
    /// Category 0: at once, because encoder, actuator, timing or loop may not hold the axis any longer.
    Immediate,
    /// Category 1: the loop holds the axis until the brake has closed.
    Controlled,
}

/// Defines [`Reason`] and its rows from one table: variant, number, name, position afterwards and stop category, cause,
/// remedy.
macro_rules! catalogue {
    ($($reason:ident = $number:literal, $name:literal, $position:ident, $category:ident: $cause:literal, $remedy:literal;)+) => {
        /// Why a drive disabled its stage or a commissioning ended without new gains. Also why a first fit failed, or
        /// gains have no valid prediction.
        ///
        /// Numbers below 100 are faults of the drive and its axis. On such a fault the drive disables its stage until
        /// the fault is cleared. Numbers from 100 on are outcomes of a commissioning, from 180 on of a first fit.
        /// Numbers from 190 on are changes of a commissioned servo, which end nothing.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[non_exhaustive]
        pub enum Reason {
            $(#[doc = concat!($cause, " (", $number, ").")] $reason,)+
        }

        impl Reason {
            /// All, by number.
            pub const ALL: &[Self] = &[$(Self::$reason),+];

            /// Number, name, cause and remedy.
            const fn row(self) -> (u8, &'static str, &'static str, &'static str) {
                match self {
                    $(Self::$reason => ($number, $name, $cause, $remedy),)+
                }
            }

            /// The position afterwards, and the stop category: apart, for a drive that needs no text.
            const fn effect(self) -> (Position, StopCategory) {
                match self {
                    $(Self::$reason => (Position::$position, StopCategory::$category),)+
                }
            }
        }
    };
}

catalogue! {
    ClockNotStable = 1, "clock-not-stable", Uncertain, Immediate:
        "the crystal or the PLL did not become ready",
        "check the crystal and its frequency in the board file, then reset";
    SelfTestFailed = 2, "self-test-failed", Uncertain, Immediate:
        "the chip computed a wrong result in its self-test",
        "flash the firmware again; if the fault returns, replace the chip";
    ResetByWatchdog = 3, "reset-by-watchdog", Uncertain, Immediate:
        "the watchdog reset the drive: a sample did not end in time",
        "lower the sample rate and start again";
    ImageDamaged = 4, "image-damaged", Uncertain, Immediate:
        "the program in the drive's flash is damaged: its checksum differs",
        "flash the firmware again; if the fault returns, replace the chip";
    AmplifierFault = 10, "amplifier-fault", Known, Immediate:
        "the amplifier reports a fault or an overcurrent",
        "check the amplifier's wiring and current limit";
    LimitSwitch = 11, "limit-switch", Known, Controlled:
        "a limit switch opened during motion",
        "move the axis off the switch by hand, or allow less travel";
    LimitSwitchesStuck = 12, "limit-switches-stuck", Known, Immediate:
        "a limit switch is open before motion begins",
        "free the switch or repair its wire (it is closed within the travel)";
    SupplyLow = 13, "supply-low", Uncertain, Immediate:
        "the supply of the drive's chip fell below 2.9 V",
        "check the supply's rating, its wires and its other loads";
    HomeSwitchStuck = 15, "home-switch-stuck", Uncertain, Controlled:
        "the home switch stayed closed although the axis moved off it",
        "free the switch or repair its wire (it is open away from home), change the sign of the homing speed, or \
         allow more clearance";
    HomeNotFound = 16, "home-not-found", Uncertain, Controlled:
        "the home switch did not close within the travel",
        "check the switch and its wire, change the sign of the homing speed, or allow more travel";
    IndexNotFound = 17, "index-not-found", Uncertain, Controlled:
        "no index pulse came within a revolution after the home switch",
        "check the encoder's index and its wire, or home without it";
    IndexAtSwitch = 18, "index-at-switch", Uncertain, Controlled:
        "the index pulse is within an eighth of a revolution of the home switch's edge",
        "turn the encoder on its shaft or move the switch by a quarter of a revolution, and home again";
    IndexShifted = 19, "index-shifted", Uncertain, Immediate:
        "an index pulse came elsewhere than whole revolutions from home",
        "check the encoder's wires, shield and counts per revolution, and home again";
    EncoderLost = 20, "encoder-lost", Uncertain, Immediate:
        "the encoder gave no valid reading",
        "check the encoder's supply, wires and magnet";
    EncoderSilent = 21, "encoder-silent", Uncertain, Immediate:
        "the servo is driven but the encoder does not count",
        "connect the encoder, free the axis, or allow a larger breakaway";
    FollowingError = 22, "following-error", Uncertain, Immediate:
        "the position is too far from the reference",
        "check the encoder's direction and the gains, or allow a larger following error";
    TravelLeft = 23, "travel-left", Uncertain, Immediate:
        "the servo left the allowed travel",
        "move the axis back, allow more travel, or check the load";
    SpeedExceeded = 24, "speed-exceeded", Uncertain, Immediate:
        "the servo exceeded the allowed speed",
        "check gains, load and encoder, or allow a higher speed";
    Overrun = 30, "overrun", Known, Immediate:
        "several successive samples took longer than the sample time",
        "lower the sample rate, or choose an estimator with less computation";
    ActuatorFailed = 31, "actuator-failed", Uncertain, Immediate:
        "the output stage did not accept the command",
        "check the output stage's wires";
    OutOfReach = 32, "out-of-reach", Uncertain, Immediate:
        "the position jumped beyond the range of the number format",
        "check the encoder's wires and shield";
    LinkLost = 40, "link-lost", Known, Controlled:
        "no message came from the host within the link timeout",
        "check the line and the host";
    StepsTooFast = 50, "steps-too-fast", Uncertain, Controlled:
        "the step pulses came faster than the axis may follow",
        "lower their rate or the distance per step, or allow more pace";
    StepsUnclear = 51, "steps-unclear", Uncertain, Controlled:
        "the direction input changed more than once between two samples",
        "check the wires and their shield, hold the direction for two samples, or sample faster";
    TargetOutside = 52, "target-outside", Uncertain, Controlled:
        "the step input asks for a target beyond the travel",
        "keep the target within the travel, or allow more travel";
    StepsMissed = 53, "steps-missed", Uncertain, Controlled:
        "step pulses came during a commissioning, which follows none",
        "keep the step input at rest during a commissioning; then set the source of the steps to where the axis is";
    DoesNotMove = 101, "does-not-move", Uncertain, Immediate:
        "the servo did not move under a command that should move it, or moved in one direction only",
        "free the axis, check encoder and amplifier, or allow a larger command";
    TooLittleEvidence = 110, "too-little-evidence", Uncertain, Controlled:
        "the motion within the limits does not determine the servo well enough",
        "allow more travel, speed, command or duration, or use a finer encoder";
    EstimateAtBound = 111, "estimate-at-bound", Uncertain, Controlled:
        "an estimate is at its bound and therefore not valid",
        "check the unit of the command, the counts per revolution, the amplifier's current limit and any bounds";
    PartlyExplained = 120, "partly-explained", Uncertain, Controlled:
        "the model explains the motion only in part: the residual exceeds the noise",
        "allow more travel, or record a log and identify it with servo-id";
    ResonanceOrBacklash = 121, "resonance-or-backlash", Uncertain, Controlled:
        "the servo is not one rigid inertia, and its frequency response does not determine a model of two",
        "stiffen the coupling, remove its backlash, or record a log and identify it with servo-id";
    NoGains = 130, "no-gains", Uncertain, Controlled:
        "no gains reach the goal within the margins",
        "ask for a slower response";
    PredictionMissed = 140, "prediction-missed", Uncertain, Controlled:
        "the measured step rises faster than predicted, takes more than three times as long, or overshoots more",
        "check for stiction, backlash, a changed load, or a varying gain of the amplifier";
    NeverAtRest = 143, "never-at-rest", Uncertain, Controlled:
        "the servo did not reach standstill",
        "check for encoder noise and a compliant coupling";
    EncoderStuck = 150, "encoder-stuck", Uncertain, Immediate:
        "the encoder stopped counting during motion",
        "check the encoder's coupling and wires";
    EncoderNoise = 151, "encoder-noise", Uncertain, Controlled:
        "encoder noise is as large as the motion that is to be measured",
        "declare the noise, allow more travel and speed, or shield the encoder's wires and check its magnet";
    EncoderJumped = 152, "encoder-jumped", Uncertain, Immediate:
        "the position jumped further than the servo can move in a sample",
        "check the encoder's shield and wires";
    Reversed = 153, "reversed", Uncertain, Immediate:
        "the servo moved against the command: encoder or actuator is reversed",
        "swap two motor wires or the encoder's channels; if the command acts late, declare its delay; if gravity or cogging needs \
        half of the command, allow a larger one";
    ActuatorDead = 154, "actuator-dead", Uncertain, Immediate:
        "the command does not move the servo: the actuator is dead, or the encoder does not show the motion",
        "check the amplifier, its supply and its enable line, then the encoder";
    ActuatorWeak = 155, "actuator-weak", Uncertain, Immediate:
        "the command acts less than before or less than declared",
        "check the supply and the current limit of the amplifier";
    Oscillating = 156, "oscillating", Uncertain, Immediate:
        "the loop oscillates",
        "ask for a slower response, declare or shorten the delay of the command, or make the current loop faster";
    Stopped = 170, "stopped", Known, Controlled:
        "a stop was commanded",
        "start it again";
    ModeChanged = 171, "mode-changed", Known, Controlled:
        "another mode was commanded",
        "start it again";
    PowerLost = 173, "power-lost", Uncertain, Immediate:
        "the power was lost before the end",
        "start it again";
    TooLittleMotion = 180, "too-little-motion", Uncertain, Controlled:
        "the motion was too small for the encoder's resolution and noise",
        "let it move further and faster, with reversals";
    OneWayMotion = 181, "one-way-motion", Uncertain, Controlled:
        "the servo moved in one direction only, which does not separate gain, friction and load",
        "let it reverse";
    ConstantCommand = 182, "constant-command", Uncertain, Controlled:
        "the command did not change, so it does not determine the gain",
        "let the servo accelerate and brake, with reversals";
    DoesNotFollow = 183, "does-not-follow", Uncertain, Controlled:
        "the position does not follow the command",
        "check the amplifier; check that command and position belong to the same axis and have the same clock";
    EarlyCommand = 185, "early-command", Uncertain, Controlled:
        "the command acts earlier than recorded or declared",
        "record with each position the command that acts from then to the next position, and declare no more delay \
         than there is";
    InertiaChanged = 190, "inertia-changed", Known, Controlled:
        "the inertia or the gain of the amplifier differs from its value at the commissioning",
        "commission the servo again with this inertia";
    ViscousFrictionChanged = 191, "viscous-friction-changed", Known, Controlled:
        "viscous friction differs from its value at the commissioning",
        "check bearings and lubrication, and commission the servo again";
    CoulombFrictionChanged = 192, "coulomb-friction-changed", Known, Controlled:
        "Coulomb friction differs from its value at the commissioning",
        "check bearings, brake and lubrication, and commission the servo again";
    LoadChanged = 193, "load-changed", Known, Controlled:
        "the load needs so much command that too little is left for the predicted step",
        "reduce the load, allow a larger command, or commission the servo again with this load";
}

impl Reason {
    /// The first number that is no fault of the drive.
    const FIRST_OUTCOME: u8 = 100;

    /// Its number, the same in core, drive, results and documentation, in every version.
    #[must_use]
    pub const fn number(self) -> u8 {
        self.row().0
    }

    /// Its name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.row().1
    }

    /// The event behind it.
    #[must_use]
    pub const fn cause(self) -> &'static str {
        self.row().2
    }

    /// How to correct it.
    #[must_use]
    pub const fn remedy(self) -> &'static str {
        self.row().3
    }

    /// True if the position may no longer be that of the axis. References such as a home position are then unknown.
    #[must_use]
    pub const fn loses_position(self) -> bool {
        matches!(self.effect().0, Position::Uncertain)
    }

    /// The graver of two: one that loses the position, or else one that disables at once; of equals the first.
    ///
    /// Not inlined: it reads three tables.
    #[must_use]
    #[inline(never)]
    pub fn graver(first: Option<Self>, second: Option<Self>) -> Option<Self> {
        let gravity = |reason: &Self| {
            let is_immediate = reason.stop_category() == StopCategory::Immediate;
            (reason.needs_reset(), reason.loses_position(), is_immediate)
        };
        // The last of equals.
        second.into_iter().chain(first).max_by_key(gravity)
    }

    /// How an axis with a holding brake is stopped for it.
    #[must_use]
    pub const fn stop_category(self) -> StopCategory {
        self.effect().1
    }

    /// Cause and remedy if it is the reason of a failed first fit, else none. So a program without a drive contains
    /// none of the other texts.
    #[must_use]
    pub const fn cause_and_remedy_of_first_fit(self) -> Option<(&'static str, &'static str)> {
        macro_rules! of_first_fit {
            ($($reason:ident)+) => {
                match self {
                    $(Self::$reason => Some(const { (Self::$reason.cause(), Self::$reason.remedy()) }),)+
                    _ => None,
                }
            };
        }
        of_first_fit! {
            ConstantCommand Reversed TooLittleMotion DoesNotFollow EarlyCommand EstimateAtBound PartlyExplained OneWayMotion
            TooLittleEvidence
        }
    }

    /// The reason of a number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        let mut all = Self::ALL.iter().copied();
        all.find(|reason| reason.number() == number)
    }

    /// True for a fault of the drive or its axis, false for an outcome of a commissioning.
    #[must_use]
    pub const fn is_fault(self) -> bool {
        self.number() < Self::FIRST_OUTCOME
    }

    /// True for a fault that only a reset clears, because it is tested at boot alone.
    #[must_use]
    pub const fn needs_reset(self) -> bool {
        matches!(
            self,
            Self::ClockNotStable | Self::SelfTestFailed | Self::ImageDamaged
        )
    }

    /// True if a commissioning disables the stage for it and does not hold the servo with the earlier gains. No gains
    /// help if encoder or actuator is unreliable. A stop may also demand it.
    #[must_use]
    pub const fn disables_stage(self) -> bool {
        let held_by_gains = matches!(
            self,
            Self::FollowingError | Self::TravelLeft | Self::SpeedExceeded | Self::LinkLost
        );
        let unreliable = matches!(
            self,
            Self::EncoderStuck
                | Self::EncoderJumped
                | Self::Reversed
                | Self::ActuatorDead
                | Self::Stopped
                | Self::PowerLost
        );
        unreliable || (self.is_fault() && !held_by_gains)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (number, _, cause, remedy) = self.row();
        let kind = if self.is_fault() { "fault" } else { "reason" };
        write!(f, "{kind} {number}: {cause}; {remedy}")
    }
}

impl core::error::Error for Reason {}

#[cfg(test)]
mod tests {
    use super::{Reason, StopCategory};

    #[test]
    fn every_reason_has_a_number_and_a_name_of_its_own_in_order() {
        for pair in Reason::ALL.windows(2) {
            assert!(pair[0].number() < pair[1].number(), "{pair:?}");
        }
        for (i, reason) in Reason::ALL.iter().enumerate() {
            assert_eq!(Reason::from_number(reason.number()), Some(*reason));
            for other in &Reason::ALL[i + 1..] {
                assert_ne!(reason.name(), other.name());
                assert_ne!(reason.cause(), other.cause());
            }
        }
        assert_eq!(Reason::from_number(0), None);
    }

    #[test]
    fn the_position_is_uncertain_after_every_end_that_has_not_earned_it() {
        // Each is earned by a test of the drive; those from 190 on end nothing.
        const KNOWN: [u8; 7] = [10, 11, 12, 30, 40, 170, 171];
        for &reason in Reason::ALL {
            let wanted = !KNOWN.contains(&reason.number()) && reason.number() < 190;
            assert_eq!(reason.loses_position(), wanted, "{reason}");
        }
    }

    #[test]
    fn what_neither_loop_nor_encoder_nor_actuator_is_to_blame_for_is_a_controlled_stop() {
        const CONTROLLED: [u8; 12] = [11, 15, 16, 17, 18, 40, 50, 51, 52, 53, 170, 171];
        for &reason in Reason::ALL {
            // A commissioning that fails by its evidence has a loop that holds.
            let ends_a_motion = reason.is_fault() || (150..180).contains(&reason.number());
            if ends_a_motion && reason != Reason::EncoderNoise {
                let wanted = CONTROLLED.contains(&reason.number());
                let is_controlled = reason.stop_category() == StopCategory::Controlled;
                assert_eq!(is_controlled, wanted, "{reason}");
            }
        }
    }

    #[test]
    fn every_reason_against_a_first_fit_has_its_texts_and_a_fault_has_none() {
        const SHARED: [Reason; 4] = [
            Reason::PartlyExplained,
            Reason::TooLittleEvidence,
            Reason::EstimateAtBound,
            Reason::Reversed,
        ];
        for &reason in Reason::ALL {
            let is_of_first_fit = (180..190).contains(&reason.number()) || SHARED.contains(&reason);
            let texts = is_of_first_fit.then(|| (reason.cause(), reason.remedy()));
            assert_eq!(reason.cause_and_remedy_of_first_fit(), texts, "{reason:?}");
        }
    }
}
