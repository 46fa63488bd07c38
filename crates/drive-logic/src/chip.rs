//! Traits and types of a chip that the interrupt runs on.

use crc::{CRC_32_ISO_HDLC, Crc};
use drive_link::Fault;
use identifier_core::drive::{Actuator, PositionSensor};

/// The parts of a chip that the sample interrupt uses.
pub trait Chip {
    /// The encoder.
    type Sensor: PositionSensor;
    /// The output stage.
    type Output: Actuator<f32>;

    /// The state of the lines.
    fn lines(&self) -> Lines;

    /// Encoder and output stage.
    fn servo(&mut self) -> (&mut Self::Sensor, &mut Self::Output);

    /// True if the home switch is closed, that is, while the axis is at that end. An open wire is away from home.
    fn home_switch_is_closed(&self) -> bool;

    /// The count at the encoder's last index pulse, if there was one since the last call.
    fn index(&mut self) -> Option<i32>;

    /// Step pulses since the last call: those that came while the direction input was high, less the others. None if
    /// that cannot be known.
    fn steps(&mut self) -> Option<i16>;

    /// Opens or closes the holding brake, where there is one. It closes with a disabled output in any case.
    fn set_brake(&mut self, open: bool) {
        let _ = open;
    }

    /// True if the time of the next sample has come.
    fn next_is_due(&self) -> bool;

    /// Keeps the watchdog from resetting the chip.
    fn feed_watchdog(&mut self);

    /// The chip's cycle counter; always zero where none runs.
    #[inline]
    fn cycles(&self) -> u32 {
        0
    }
}

/// State of the pins besides the encoder. Every line is healthy when it is closed, so a broken wire is a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lines {
    /// The amplifier reports no fault.
    pub amplifier: bool,
    /// The chip's supply has not sagged.
    pub supply: bool,
    /// The limit switch at the lower end is closed.
    pub low_switch: bool,
    /// The limit switch at the upper end is closed.
    pub high_switch: bool,
}

impl Lines {
    /// No fault.
    pub const HEALTHY: Self = Self {
        amplifier: true,
        supply: true,
        low_switch: true,
        high_switch: true,
    };

    /// # Errors
    /// The fault that keeps the servo from being moved.
    pub(crate) fn before_motion(self) -> Result<(), Fault> {
        if !self.supply {
            Err(Fault::SupplyLow)
        } else if !self.amplifier {
            Err(Fault::AmplifierFault)
        } else if self.low_switch && self.high_switch {
            Ok(())
        } else {
            Err(Fault::LimitSwitchesStuck)
        }
    }
}

/// Properties of a drive's output stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputStage {
    /// The command that asks for all it has, command units: no limit may be beyond it.
    pub full_scale: f64,
    /// The samples are a whole number of these apart, s: the period of its PWM.
    pub period: f64,
    /// From the reading of the encoder to the change of the output, s.
    pub command_delay: f64,
    /// The board that it is on, by the name of its feature in the firmware.
    pub board: &'static str,
    /// The servo is simulated, and no output is driven.
    pub is_simulated: bool,
}

impl OutputStage {
    /// The fingerprint of board, build and layout of a record of a version, which every record begins with.
    pub(crate) fn build(&self, version: u16) -> u32 {
        const CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
        let mut digest = CHECK.digest();
        digest.update(&version.to_le_bytes());
        digest.update(&[self.is_simulated.into()]);
        digest.update(self.board.as_bytes());
        digest.finalize()
    }
}
