use core::fmt;

use serde::{Deserialize, Serialize};

/// Why a drive let its servo go and stays so until the fault is cleared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[expect(missing_docs, reason = "each is described by its cause")]
pub enum Fault {
    ClockNotStable,
    WrongAnswer,
    ResetByWatchdog,
    AmplifierFault,
    LimitSwitch,
    LimitSwitchesStuck,
    EncoderFailed,
    EncoderSilent,
    FollowingError,
    TravelExceeded,
    Overspeed,
    Overrun,
    ActuatorFailed,
    OutOfReach,
    LinkSilent,
}

impl Fault {
    /// Every fault.
    pub const ALL: [Self; 15] = [
        Self::ClockNotStable,
        Self::WrongAnswer,
        Self::ResetByWatchdog,
        Self::AmplifierFault,
        Self::LimitSwitch,
        Self::LimitSwitchesStuck,
        Self::EncoderFailed,
        Self::EncoderSilent,
        Self::FollowingError,
        Self::TravelExceeded,
        Self::Overspeed,
        Self::Overrun,
        Self::ActuatorFailed,
        Self::OutOfReach,
        Self::LinkSilent,
    ];

    /// Its number, as a display or a manual shows it.
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Self::ClockNotStable => 1,
            Self::WrongAnswer => 2,
            Self::ResetByWatchdog => 3,
            Self::AmplifierFault => 10,
            Self::LimitSwitch => 11,
            Self::LimitSwitchesStuck => 12,
            Self::EncoderFailed => 20,
            Self::EncoderSilent => 21,
            Self::FollowingError => 22,
            Self::TravelExceeded => 23,
            Self::Overspeed => 24,
            Self::Overrun => 30,
            Self::ActuatorFailed => 31,
            Self::OutOfReach => 32,
            Self::LinkSilent => 40,
        }
    }

    /// What happened.
    #[must_use]
    pub fn cause(self) -> &'static str {
        match self {
            Self::ClockNotStable => "the crystal or the PLL did not become ready",
            Self::WrongAnswer => "the self-test's known computation gave another result",
            Self::ResetByWatchdog => "the watchdog reset the drive: a sample did not end in time",
            Self::AmplifierFault => "the amplifier reports a fault or too large a current",
            Self::LimitSwitch => "a limit switch opened in motion",
            Self::LimitSwitchesStuck => "a limit switch is open before motion begins",
            Self::EncoderFailed => "the encoder gave no valid reading",
            Self::EncoderSilent => "the servo is driven and the encoder counts nothing",
            Self::FollowingError => "the position is too far from the reference",
            Self::TravelExceeded => "the servo is further from where it started than it may go",
            Self::Overspeed => "the servo is faster than it may be",
            Self::Overrun => "several samples running took longer than the sample time",
            Self::ActuatorFailed => "the output stage took no command",
            Self::OutOfReach => "the position jumped beyond what the number format counts",
            Self::LinkSilent => "the host was silent for too long: the run came to rest and ended",
        }
    }

    /// What to do about it.
    #[must_use]
    pub fn remedy(self) -> &'static str {
        match self {
            Self::ClockNotStable => "check the crystal and the board file's frequency, then reset",
            Self::WrongAnswer => "flash the firmware again; if it returns, replace the chip",
            Self::ResetByWatchdog => "lower the sample rate, clear the fault and start again",
            Self::AmplifierFault => "check wiring and current limit of the amplifier, then clear",
            Self::LimitSwitch => "move the axis off the switch by hand, then clear",
            Self::LimitSwitchesStuck => "free the switch or mend its wire (closed is healthy)",
            Self::EncoderFailed => "check the encoder's supply, wires and magnet, then clear",
            Self::EncoderSilent => {
                "connect the encoder, free the axis, or allow a larger breakaway, then clear"
            }
            Self::FollowingError => {
                "check the encoder's direction and the gains, or allow a larger error, then clear"
            }
            Self::TravelExceeded => "move the axis back by hand, or allow more travel, then clear",
            Self::Overspeed => "check gains, load and encoder, or allow more speed, then clear",
            Self::Overrun => "lower the sample rate or choose a cheaper law, then clear",
            Self::ActuatorFailed => "check the output stage's wires, then clear",
            Self::OutOfReach => "check the encoder for disturbances, then clear",
            Self::LinkSilent => "check the line and the host, then clear",
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "fault {}: {}; {}",
            self.number(),
            self.cause(),
            self.remedy()
        )
    }
}

impl core::error::Error for Fault {}

#[cfg(test)]
mod tests {
    use super::Fault;

    #[test]
    fn every_fault_has_a_number_of_its_own() {
        for (i, fault) in Fault::ALL.iter().enumerate() {
            for other in Fault::ALL.iter().skip(i + 1) {
                assert_ne!(fault.number(), other.number(), "{fault:?} {other:?}");
            }
        }
    }
}
