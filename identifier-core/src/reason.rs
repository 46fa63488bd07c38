//! The one catalogue of reasons: why a drive or a commissioning stops, a first fit fails, or gains have no valid
//! prediction. Each reason has a number, name, cause and remedy. They are the same in core, drive, results and
//! documentation.

use core::fmt;

/// The count of an encoder after a reason.
enum Position {
    /// It is that of the axis, as before.
    Known,
    /// It may be another: counts were lost, or may have been.
    Doubtful,
}

/// Defines [`Reason`] and its rows from one table: variant, number, name and position afterwards, cause, remedy.
macro_rules! catalogue {
    ($($reason:ident = $number:literal, $name:literal, $position:ident: $cause:literal, $remedy:literal;)+) => {
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

            /// Number, name, cause and remedy, and the position afterwards.
            const fn row(self) -> (u8, &'static str, &'static str, &'static str, Position) {
                match self {
                    $(Self::$reason => ($number, $name, $cause, $remedy, Position::$position),)+
                }
            }
        }
    };
}

catalogue! {
    ClockNotStable = 1, "clock-not-stable", Doubtful:
        "the crystal or the PLL did not become ready",
        "check the crystal and the board file's frequency, then reset";
    SelfTestFailed = 2, "self-test-failed", Doubtful:
        "the self-test's known computation gave another result",
        "flash the firmware again; if it returns, replace the chip";
    ResetByWatchdog = 3, "reset-by-watchdog", Doubtful:
        "the watchdog reset the drive: a sample did not end in time",
        "lower the sample rate and start again";
    ImageDamaged = 4, "image-damaged", Doubtful:
        "the program in the drive's flash is not the one that was built",
        "flash the firmware again; if it returns, replace the chip";
    AmplifierFault = 10, "amplifier-fault", Known:
        "the amplifier reports a fault or too large a current",
        "check wiring and current limit of the amplifier";
    LimitSwitch = 11, "limit-switch", Known:
        "a limit switch opened in motion",
        "move the axis off the switch by hand, or allow less travel";
    LimitSwitchesStuck = 12, "limit-switches-stuck", Known:
        "a limit switch is open before motion begins",
        "free the switch or mend its wire (closed is healthy)";
    SupplyLow = 13, "supply-low", Doubtful:
        "the supply of the drive's chip sagged below 2.9 V",
        "check the supply's rating, its wires, and what else it feeds";
    HomeSwitchStuck = 15, "home-switch-stuck", Known:
        "the home switch stays closed although the axis was driven off it",
        "free the switch or mend its wire (open is away from home), exchange the sign of the homing speed, or allow \
         more clearance";
    HomeNotFound = 16, "home-not-found", Known:
        "the home switch did not close within the travel",
        "check the switch and its wire, exchange the sign of the homing speed, or allow more travel";
    IndexNotFound = 17, "index-not-found", Known:
        "the encoder gave no index pulse within a revolution behind the home switch",
        "check the encoder's index and its wire, or home without it";
    EncoderLost = 20, "encoder-lost", Doubtful:
        "the encoder gave no valid reading",
        "check the encoder's supply, wires and magnet";
    EncoderSilent = 21, "encoder-silent", Doubtful:
        "the servo is driven and the encoder counts nothing",
        "connect the encoder, free the axis, or allow a larger breakaway";
    FollowingError = 22, "following-error", Known:
        "the position is too far from the reference",
        "check the encoder's direction and the gains, or allow a larger error";
    TravelLeft = 23, "travel-left", Known:
        "the servo left the travel that it may use",
        "move the axis back, allow more travel, or check what pushes the servo";
    SpeedExceeded = 24, "speed-exceeded", Known:
        "the servo was faster than it may be",
        "check gains, load and encoder, or allow more speed";
    Overrun = 30, "overrun", Known:
        "several successive samples took longer than the sample time",
        "lower the sample rate, or choose a cheaper law";
    ActuatorFailed = 31, "actuator-failed", Known:
        "the output stage took no command",
        "check the output stage's wires";
    OutOfReach = 32, "out-of-reach", Doubtful:
        "the position jumped beyond what the number format counts",
        "check the encoder for disturbances";
    LinkLost = 40, "link-lost", Known:
        "the host was silent for too long",
        "check the line and the host";
    StepsTooFast = 50, "steps-too-fast", Known:
        "the step pulses came faster than the axis may follow",
        "lower their rate or the distance of a step, or allow more pace";
    StepsUnclear = 51, "steps-unclear", Known:
        "the direction input changed more than once between two samples",
        "check the wires for disturbances, hold the direction for two samples, or sample faster";
    TargetOutside = 52, "target-outside", Known:
        "the command from outside asks for a target beyond the travel",
        "keep it within the travel, or allow more";
    DoesNotMove = 101, "does-not-move", Doubtful:
        "the servo did not move, or in one direction alone, under a command that was to move it",
        "free the axis, check encoder and amplifier, or allow a larger command";
    TooLittleEvidence = 110, "too-little-evidence", Known:
        "the motion within the limits does not determine the servo well enough",
        "allow more travel, speed or duration, or use a finer encoder";
    EstimateAtBound = 111, "estimate-at-bound", Known:
        "an estimate stands at a bound, so it is no result",
        "check the unit of the command, the counts per revolution, the limit of the current and any bounds";
    PartlyExplained = 120, "partly-explained", Known:
        "the model explains only a part of the motion, and the rest is more than noise",
        "record a log and identify it: the fit of a whole log names the effect";
    ResonanceOrBacklash = 121, "resonance-or-backlash", Known:
        "the servo does not follow as one mass, and its frequency response does not show two masses well enough",
        "stiffen the coupling, remove its backlash, or record a log and identify it";
    NoGains = 130, "no-gains", Known:
        "no gains keep the margins at what was asked for",
        "ask for a slower response: the figure that would do is stated";
    PredictionMissed = 140, "prediction-missed", Known:
        "the measured step does not match the prediction: it rises faster, over three times as slowly, or overshoots more",
        "check for stiction, backlash, a changed load, or a gain of the amplifier that changes";
    NeverAtRest = 143, "never-at-rest", Known:
        "the servo did not come to rest",
        "check for noise of the position and a compliant coupling";
    EncoderStuck = 150, "encoder-stuck", Doubtful:
        "the encoder stood still in motion",
        "check the encoder's coupling and wires";
    EncoderNoise = 151, "encoder-noise", Doubtful:
        "the encoder's noise hides the motion, or would be mistaken for it",
        "declare the noise, allow more travel and speed, or shield the encoder's wires and check its magnet";
    EncoderJumped = 152, "encoder-jumped", Doubtful:
        "the position jumped further than the servo can go in a sample",
        "check the encoder's shield and wires";
    Reversed = 153, "reversed", Doubtful:
        "the servo moved against the command: encoder or actuator is reversed",
        "exchange two phases of the motor or the encoder's tracks; where the command acts late, declare its delay";
    ActuatorDead = 154, "actuator-dead", Doubtful:
        "the command moves nothing: the actuator is dead, or the encoder does not show the motion",
        "check the amplifier, its supply and its enable line, and then the encoder";
    ActuatorWeak = 155, "actuator-weak", Known:
        "the command acts less than it did or than was declared",
        "check the supply and the current limit of the amplifier";
    Oscillating = 156, "oscillating", Known:
        "the loop oscillates",
        "ask for a slower response, declare or shorten the delay behind the command, or quicken the current loop";
    Stopped = 170, "stopped", Known:
        "it was stopped by command",
        "order it again";
    ModeChanged = 171, "mode-changed", Known:
        "another mode was commanded",
        "order it again";
    PowerLost = 173, "power-lost", Doubtful:
        "the power was lost before it ended",
        "order it again";
    TooLittleMotion = 180, "too-little-motion", Known:
        "the servo moved hardly further than the steps and the noise of its encoder",
        "let it move further, faster and with turns";
    OneWayMotion = 181, "one-way-motion", Known:
        "the servo moved in one direction, in which gain, friction and load are not told apart",
        "let it turn back";
    ConstantCommand = 182, "constant-command", Known:
        "the command did not change, which leaves the gain open",
        "let the servo accelerate and brake, with turns";
    DoesNotFollow = 183, "does-not-follow", Known:
        "the position does not follow the command",
        "check the amplifier, and that command and position are of the same axis and the same clock";
    EarlyCommand = 185, "early-command", Known:
        "the command acts earlier than it is recorded or declared to",
        "record the command that acts until the next reading, not the one before it, and declare no longer delay than there is";
    InertiaChanged = 190, "inertia-changed", Known:
        "the inertia is not the one that the gains promise for, or the command acts more or less than it did",
        "commission it again with this inertia";
    ViscousFrictionChanged = 191, "viscous-friction-changed", Known:
        "friction grows with speed more or less than that of the servo that the gains promise for",
        "check bearings and lubrication, and commission it again";
    CoulombFrictionChanged = 192, "coulomb-friction-changed", Known:
        "Coulomb friction is not the one that the gains promise for",
        "check bearings, brake and lubrication, and commission it again";
    LoadChanged = 193, "load-changed", Known:
        "the load leaves less of the command than the promised step takes",
        "take off load, allow a larger command, or commission it again with this load";
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
        matches!(self.row().4, Position::Doubtful)
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
        let (number, _, cause, remedy, _) = self.row();
        let kind = if self.is_fault() { "fault" } else { "reason" };
        write!(f, "{kind} {number}: {cause}; {remedy}")
    }
}

impl core::error::Error for Reason {}

#[cfg(test)]
mod tests {
    use super::Reason;

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
    fn the_position_is_doubtful_after_whatever_may_have_lost_counts() {
        const DOUBTFUL: [u8; 15] = [
            1, 2, 3, 4, 13, 20, 21, 32, 101, 150, 151, 152, 153, 154, 173,
        ];
        for &reason in Reason::ALL {
            let wanted = DOUBTFUL.contains(&reason.number());
            assert_eq!(reason.loses_position(), wanted, "{reason}");
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
