//! Boards: the functions of their pins, one file per board, chosen by a feature of its name.
//!
//! A board file is data: `BOARD` has the oscillator, the pins and the areas of the records, the last two in common where the
//! chip has 64 pins. To add one, copy one of its family, change its pins, and name it here and in Cargo.toml. The modules `f4`, `f401` and `g4` have the interrupts of a
//! family, by the vendor's description.

/// The handler of the supply's detector, by the name that its interrupt has in the family.
#[macro_export]
macro_rules! disable_at_a_sag {
    () => {
        #[cfg(feature = "f4")]
        $crate::disable_at_a_sag!(PVD);
        #[cfg(feature = "f401")]
        $crate::disable_at_a_sag!(EXTI16_PVD);
        #[cfg(feature = "g4")]
        $crate::disable_at_a_sag!(PVD_PVM);
    };
    ($interrupt:ident) => {
        /// The supply sags.
        #[interrupt]
        fn $interrupt() {
            $crate::board::disable_for_sag();
        }
    };
}

#[cfg(feature = "black-pill-f401cc")]
mod black_pill_f401cc;
#[cfg(feature = "f4")]
mod f4;
#[cfg(feature = "f401")]
mod f401;
#[cfg(feature = "g4")]
mod g4;
#[cfg(feature = "nucleo-f446re")]
mod nucleo_f446re;
#[cfg(feature = "nucleo-g474re")]
mod nucleo_g474re;
#[cfg(feature = "olimex-stm32-h405")]
mod olimex_stm32_h405;

#[cfg(feature = "black-pill-f401cc")]
use black_pill_f401cc as own;
#[cfg(feature = "f4")]
use f4 as family;
#[cfg(feature = "f401")]
use f401 as family;
#[cfg(feature = "g4")]
use g4 as family;
#[cfg(feature = "nucleo-f446re")]
use nucleo_f446re as own;
#[cfg(feature = "nucleo-g474re")]
use nucleo_g474re as own;
#[cfg(feature = "olimex-stm32-h405")]
use olimex_stm32_h405 as own;

pub use family::{Interrupt, background, interrupt};
pub use own::{BOARD, NAME};

const _: () = assert!(
    cfg!(feature = "black-pill-f401cc") as u8
        + cfg!(feature = "nucleo-f446re") as u8
        + cfg!(feature = "nucleo-g474re") as u8
        + cfg!(feature = "olimex-stm32-h405") as u8
        == 1,
    "one board, and none beside the default one: --no-default-features --features nucleo-g474re,commissioning,terms"
);
#[cfg(all(feature = "emulator", not(feature = "olimex-stm32-h405")))]
compile_error!(
    "the emulator has an STM32F405: --no-default-features --features olimex-stm32-h405,emulator"
);

use drive_chip::{pins, serial};
use family::Family;
use servo_hal::Gate;

/// The bus of the board's chip.
pub type Mmio = drive_chip::Mmio<Family>;

/// It itself.
pub const BUS: Mmio = Mmio::BUS;

/// The command that asks for the whole duty, command units.
const FULL_SCALE: f64 = 10.0;

/// Properties of the output stage. Its PWM takes effect with the next period.
pub const STAGE: drive_logic::OutputStage = drive_logic::OutputStage {
    full_scale: FULL_SCALE,
    period: drive_chip::pwm::PERIOD,
    command_delay: drive_chip::sample_timer::LEAD,
    board: NAME,
    is_simulated: cfg!(feature = "no-motor"),
};

/// The encoder.
pub type Encoder = drive_chip::quadrature::Quadrature<Mmio>;

/// The output stage with its enable line and its brake.
pub type Output = Gate<Stage, pins::Output<Mmio>>;

type Stage = servo_hal::PwmDirection<drive_chip::pwm::Pwm<Mmio>, drive_chip::pwm::Direction<Mmio>>;

/// The other parts of a board that a drive uses, and the fault found meanwhile. It is an unstable clock, a failed
/// output, or a reset by the watchdog.
pub type Wired = drive_chip::Wired<'static, Mmio>;

/// Disables the output whatever the state of the drivers, for a program that cannot continue.
pub fn disable_outputs() {
    drive_chip::disable_outputs(BUS, &BOARD);
}

/// The memory that DMA receives into: no stream of an STM32F4 reaches the core-coupled memory.
static RECEIVED: serial::Ring = serial::Ring::new();

/// Disables the output while the supply sags.
pub fn disable_for_sag() {
    drive_chip::disable_for_sag(BUS, &BOARD);
}

/// Serves the interrupt that nothing masks: true if the program may continue.
#[must_use]
pub fn outlives_nmi() -> bool {
    drive_chip::outlives_nmi(BUS)
}

/// Wires the board; none if it was wired before.
#[must_use]
pub fn wire() -> Option<(Wired, Output)> {
    let to_send = cortex_m::singleton!(: serial::Bytes = serial::Bytes::new())?;
    let chip = drive_chip::wire(BUS, &BOARD, &RECEIVED, to_send);
    let stage = Stage::new(chip.pwm, chip.direction, FULL_SCALE as f32).ok()?;
    let output = Gate::new(stage, chip.enable).with_brake(chip.brake);
    Some((chip, output))
}
