//! Olimex STM32-H405.
//!
//! | pin | what | towards |
//! |---|---|---|
//! | PC6, PC7 | encoder A and B (TIM3), pulled up | encoder |
//! | PA8 | PWM, 20 kHz (TIM1 channel 1) | amplifier |
//! | PB14 | direction, high is positive | amplifier |
//! | PB15 | enable, high is on; pull it down outside | amplifier, brake |
//! | PB12 | fault (TIM1 break), pulled up: low is healthy | amplifier |
//! | PC0, PC1 | limit switches, lower and upper end, pulled up: closed to ground is healthy | switches |
//! | PA2, PA3 | serial line, out and in (USART2), 921 600 baud, 3.3 V | host |
//! | PA5, PA7, PA4 | with the feature `dac`: clock, data and select of an AD5761 (SPI1) | DAC |

use drive_link::Fault;
use drive_logic::Lines;
use identifier_core::drive::hal::Gate;
#[cfg(not(feature = "dac"))]
use identifier_core::drive::hal::PwmDirection;
use stm32f4xx_hal::gpio::{Alternate, Input, Output as Out, PB12, PB15, PC0, PC1};
use stm32f4xx_hal::pac::{Peripherals, TIM3};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::qei::Qei;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use super::Wired;
use crate::internal_flash::InternalFlash;
use crate::pwm;
#[cfg(not(feature = "dac"))]
use crate::pwm::Pwm;
use crate::quadrature::Quadrature;
use crate::serial::Bytes;
use crate::timer::SampleTimer;
use crate::{clock, serial};

/// The crystal, Hz.
pub const CRYSTAL: u32 = 8_000_000;

/// The command that asks for the whole duty, or for 10 V, command units: no limit of a drive may be
/// beyond it.
const FULL_SCALE: f64 = 10.0;

/// What the output stage can do.
pub const STAGE: drive_logic::Stage = drive_logic::Stage {
    full_scale: FULL_SCALE,
    period: 5e-5,
    command_delay: 5e-5,
};

/// The encoder.
pub type Encoder = Quadrature<Qei<TIM3>>;

/// The output stage.
pub type Output = Gate<Stage, PB15<Out>>;

#[cfg(not(feature = "dac"))]
type Stage = PwmDirection<Pwm, stm32f4xx_hal::gpio::PB14<Out>>;

#[cfg(feature = "dac")]
type Stage = identifier_core::drive::hal::Ad5761<
    embedded_hal_bus::spi::ExclusiveDevice<
        stm32f4xx_hal::spi::Spi<stm32f4xx_hal::pac::SPI1>,
        stm32f4xx_hal::gpio::PA4<Out>,
        embedded_hal_bus::spi::NoDelay,
    >,
>;

/// The lines that must be healthy.
pub struct Inputs {
    fault: PB12<Alternate<1>>,
    low_switch: PC0<Input>,
    high_switch: PC1<Input>,
}

impl Inputs {
    /// What they say now.
    #[inline]
    #[must_use]
    pub fn read(&self) -> Lines {
        Lines {
            amplifier: self.fault.is_low() && !pwm::broke(),
            low_switch: self.low_switch.is_low(),
            high_switch: self.high_switch.is_low(),
        }
    }
}

/// Lets the servo go whatever else happens, for when the program cannot go on.
pub fn let_go() {
    // SAFETY: the outputs are switched off, which is right at any time.
    unsafe {
        stm32f4xx_hal::pac::TIM1::steal()
            .bdtr()
            .write(|write| write.bits(0));
        stm32f4xx_hal::pac::GPIOB::steal()
            .bsrr()
            .write(|write| write.br15().set_bit());
    }
}

/// Wires the board; none if it was wired before.
#[must_use]
pub fn wire() -> Option<Wired> {
    let chip = Peripherals::take()?;
    let heard = cortex_m::singleton!(: Bytes = Bytes::new())?;
    let to_say = cortex_m::singleton!(: Bytes = Bytes::new())?;
    let (clocks, clock) = clock::start(&chip.RCC, &chip.FLASH);
    let by_watchdog = chip.RCC.csr().read().wdgrstf().bit_is_set();
    chip.RCC.csr().modify(|_, write| write.rmvf().set_bit());
    let mut rcc = chip.RCC.constrain();
    let a = chip.GPIOA.split(&mut rcc);
    let b = chip.GPIOB.split(&mut rcc);
    let c = chip.GPIOC.split(&mut rcc);

    let enable = b.pb15.into_push_pull_output();
    let fault = b
        .pb12
        .into_alternate::<1>()
        .internal_resistor(stm32f4xx_hal::gpio::Pull::Up);
    let full_scale = FULL_SCALE as f32;
    #[cfg(not(feature = "dac"))]
    let stage = {
        let _pwm_pin = a.pa8.into_alternate::<1>();
        let pwm = Pwm::new(chip.TIM1, &clocks, &mut rcc);
        PwmDirection::new(pwm, b.pb14.into_push_pull_output(), full_scale).ok()?
    };
    #[cfg(feature = "dac")]
    let (stage, started) = dac::stage(chip.SPI1, (a.pa4, a.pa5, a.pa7), full_scale, &mut rcc)?;
    #[cfg(not(feature = "dac"))]
    let started = Ok(());

    let _serial_pins = (a.pa2.into_alternate::<7>(), a.pa3.into_alternate::<7>());
    let (line, port) = serial::line(chip.USART2, &clocks, &mut rcc, heard, to_say);
    let lines = (c.pc6.into_pull_up_input(), c.pc7.into_pull_up_input());
    Some(Wired {
        encoder: Quadrature::new(Qei::new(chip.TIM3, lines, &mut rcc)),
        output: Gate::new(stage, enable),
        inputs: Inputs {
            fault,
            low_switch: c.pc0.into_pull_up_input(),
            high_switch: c.pc1.into_pull_up_input(),
        },
        timer: SampleTimer::new(chip.TIM5, &clocks, &mut rcc),
        line,
        port,
        flash: InternalFlash::new(chip.FLASH),
        watchdog: IndependentWatchdog::new(chip.IWDG),
        found: clock.and(started).and(if by_watchdog {
            Err(Fault::ResetByWatchdog)
        } else {
            Ok(())
        }),
    })
}

/// The analogue output.
#[cfg(feature = "dac")]
mod dac {
    use drive_link::Fault;
    use embedded_hal_bus::spi::ExclusiveDevice;
    use identifier_core::drive::hal::Ad5761;
    use stm32f4xx_hal::gpio::{PA4, PA5, PA7};
    use stm32f4xx_hal::pac::SPI1;
    use stm32f4xx_hal::prelude::*;
    use stm32f4xx_hal::rcc::Rcc;
    use stm32f4xx_hal::spi::{Mode, Phase, Polarity, Spi};

    /// An AD5761, and whether it took to be set to zero volts.
    pub(super) fn stage(
        registers: SPI1,
        (select, clock, data): (PA4, PA5, PA7),
        full_scale: f32,
        rcc: &mut Rcc,
    ) -> Option<(super::Stage, Result<(), Fault>)> {
        // The HAL believes the bus at 16 MHz where it has 84: what is asked for is 5.25 times as fast.
        let pins = (Some(clock), SPI1::NoMiso, Some(data));
        let mode = Mode {
            polarity: Polarity::IdleLow,
            phase: Phase::CaptureOnSecondTransition,
        };
        let bus = Spi::new(registers, pins, mode, 1.MHz(), rcc);
        let device = ExclusiveDevice::new_no_delay(bus, select.into_push_pull_output()).ok()?;
        let mut dac = Ad5761::new(device, full_scale).ok()?;
        let started = dac.start().map_err(|_| Fault::ActuatorFailed);
        Some((dac, started))
    }
}
