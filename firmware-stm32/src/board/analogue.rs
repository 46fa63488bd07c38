//! A ±10 V DAC on SPI1 in place of PWM and direction: clock PA5, data PA7, select PA4.

use drive_chip::pwm::Pwm;
use drive_link::Fault;
use embedded_hal::pwm::SetDutyCycle;
use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use identifier_core::drive::Actuator;
use servo_hal::Ad5761;
use stm32f4xx_hal::gpio::{Output, PA4, PA5, PA7};
use stm32f4xx_hal::pac::{Peripherals, SPI1};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::spi::{Mode, Phase, Polarity, Spi};

use super::Mmio;

type Dac = Ad5761<ExclusiveDevice<Spi<SPI1>, PA4<Output>, NoDelay>>;

/// The bus of the DAC.
pub(super) struct Pins {
    registers: SPI1,
    select: PA4,
    clock: PA5,
    data: PA7,
    rcc: Rcc,
}

impl Pins {
    /// None if they were taken before.
    pub(super) fn take() -> Option<Self> {
        let chip = Peripherals::take()?;
        let mut rcc = chip.RCC.constrain();
        let port = chip.GPIOA.split(&mut rcc);
        Some(Self {
            registers: chip.SPI1,
            select: port.pa4,
            clock: port.pa5,
            data: port.pa7,
            rcc,
        })
    }
}

/// The DAC, and the PWM of which only the memory of a break is used.
pub struct Analogue {
    dac: Dac,
    pwm: Pwm<Mmio>,
}

/// An AD5761, and the result of setting it to zero volts.
pub(super) fn stage(
    pins: Pins,
    pwm: Pwm<Mmio>,
    full_scale: f32,
) -> Option<(Analogue, Result<(), Fault>)> {
    let Pins {
        registers,
        select,
        clock,
        data,
        mut rcc,
    } = pins;
    // The HAL takes the bus for 16 MHz where it has 84: the clock is 5.25 times as fast as requested.
    let pins = (Some(clock), SPI1::NoMiso, Some(data));
    let mode = Mode {
        polarity: Polarity::IdleLow,
        phase: Phase::CaptureOnSecondTransition,
    };
    let bus = Spi::new(registers, pins, mode, 1.MHz(), &mut rcc);
    let device = ExclusiveDevice::new_no_delay(bus, select.into_push_pull_output()).ok()?;
    let mut dac = Ad5761::new(device, full_scale).ok()?;
    let started = dac.start().map_err(|_| Fault::ActuatorFailed);
    Some((Analogue { dac, pwm }, started))
}

impl Actuator<f32> for Analogue {
    type Error = <Dac as Actuator<f32>>::Error;

    #[inline]
    fn hold(&mut self, command: f32) -> Result<(), Self::Error> {
        self.dac.hold(command)
    }

    #[inline]
    fn release(&mut self) -> Result<(), Self::Error> {
        // The break flag is cleared, as with the PWM.
        let _ = self.pwm.set_duty_cycle_fully_off();
        self.dac.release()
    }
}
