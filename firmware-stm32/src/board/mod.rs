//! Which pin is what: one file a board, chosen by a feature of its name.
//!
//! A board file is data: `BOARD` has the oscillator, the pins and the sectors of the records. To add
//! an F4 board, copy one of them, change its pins, and name it here and in Cargo.toml.

#[cfg(feature = "dac")]
mod analogue;
#[cfg(feature = "nucleo-f446re")]
mod nucleo_f446re;
#[cfg(feature = "olimex-stm32-h405")]
mod olimex_stm32_h405;

#[cfg(feature = "nucleo-f446re")]
pub use nucleo_f446re::BOARD;
#[cfg(all(feature = "olimex-stm32-h405", not(feature = "nucleo-f446re")))]
pub use olimex_stm32_h405::BOARD;

#[cfg(all(feature = "olimex-stm32-h405", feature = "nucleo-f446re"))]
compile_error!("one board at a time: --no-default-features --features nucleo-f446re");
#[cfg(not(any(feature = "olimex-stm32-h405", feature = "nucleo-f446re")))]
compile_error!("a board is needed: --features olimex-stm32-h405, for instance");

use drive_chip::{Mmio, pins, serial};
use drive_link::Fault;
use drive_logic::Lines;
use servo_hal::Gate;

/// The command that asks for the whole duty, or for 10 V, command units.
const FULL_SCALE: f64 = 10.0;

/// What the output stage can do. Its PWM waits for the next period.
#[cfg(not(feature = "dac"))]
pub const STAGE: drive_logic::Stage = drive_logic::Stage {
    full_scale: FULL_SCALE,
    period: drive_chip::pwm::PERIOD,
    command_delay: drive_chip::sample_timer::LEAD,
};

/// What the output stage can do. The SPI needs 5 µs for 24 bits, behind what the sample computes.
#[cfg(feature = "dac")]
pub const STAGE: drive_logic::Stage = drive_logic::Stage {
    full_scale: FULL_SCALE,
    period: drive_chip::pwm::PERIOD,
    command_delay: 5e-6,
};

/// The encoder.
pub type Encoder = drive_chip::quadrature::Quadrature<Mmio>;

/// The output stage with its enable line.
pub type Output = Gate<Stage, pins::Output<Mmio>>;

#[cfg(not(feature = "dac"))]
type Stage = servo_hal::PwmDirection<drive_chip::pwm::Pwm<Mmio>, pins::Output<Mmio>>;
#[cfg(feature = "dac")]
type Stage = analogue::Analogue;

/// The timer whose update is a sample.
pub type SampleTimer = drive_chip::sample_timer::SampleTimer<Mmio>;

/// The background's end of the serial line.
pub type Line = serial::Line<'static, Mmio>;

/// The interrupt's end of the serial line.
pub type Port = serial::Port<'static, Mmio>;

/// Where records are kept.
pub type RecordFlash = drive_chip::flash::RecordFlash<Mmio>;

/// Resets the chip unless it is fed.
pub type Watchdog = drive_chip::watchdog::Watchdog<Mmio>;

/// The amplifier's fault line and the limit switches.
pub struct Inputs(drive_chip::inputs::Inputs<Mmio>);

impl Inputs {
    /// What they say now.
    #[inline]
    #[must_use]
    pub fn read(&self) -> Lines {
        let healthy = self.0.read();
        Lines {
            amplifier: healthy.amplifier,
            low_switch: healthy.low_switch,
            high_switch: healthy.high_switch,
        }
    }
}

/// Everything of a board that a drive uses.
pub struct Wired {
    /// Where the position is counted.
    pub encoder: Encoder,
    /// What the command moves.
    pub output: Output,
    /// The amplifier's fault line and the limit switches.
    pub inputs: Inputs,
    /// Beats at every sample.
    pub timer: SampleTimer,
    /// The background's end of the serial line.
    pub line: Line,
    /// The interrupt's end of the serial line.
    pub port: Port,
    /// Where records are kept.
    pub flash: RecordFlash,
    /// Resets the chip unless it is fed.
    pub watchdog: Watchdog,
    /// What was found wrong on the way: the clock, the output, or that the watchdog was what reset
    /// the chip.
    pub found: Result<(), Fault>,
}

/// Lets the servo go whatever else happens, for when the program cannot go on.
pub fn disable_outputs() {
    drive_chip::disable_outputs(Mmio, &BOARD);
}

/// Wires the board; none if it was wired before.
#[must_use]
pub fn wire() -> Option<Wired> {
    let heard = cortex_m::singleton!(: serial::Bytes = serial::Bytes::new())?;
    let to_say = cortex_m::singleton!(: serial::Bytes = serial::Bytes::new())?;
    // The HAL resets a port that it takes: before it is used.
    #[cfg(feature = "dac")]
    let pins = analogue::Pins::take()?;
    let chip = drive_chip::wire(Mmio, &BOARD, heard, to_say);
    let full_scale = FULL_SCALE as f32;
    #[cfg(not(feature = "dac"))]
    let (stage, started) = (
        Stage::new(chip.pwm, chip.direction, full_scale).ok()?,
        Ok(()),
    );
    #[cfg(feature = "dac")]
    let (stage, started) = analogue::stage(pins, chip.pwm, full_scale)?;
    Some(Wired {
        encoder: chip.encoder,
        output: Gate::new(stage, chip.enable),
        inputs: Inputs(chip.inputs),
        timer: chip.timer,
        line: chip.line,
        port: chip.port,
        flash: chip.flash,
        watchdog: chip.watchdog,
        found: started.and(chip.found),
    })
}
