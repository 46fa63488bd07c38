//! Everything of a drive that touches a register of an STM32F4 or STM32G4.
//!
//! Every driver is generic over a [`Bus`]: `Mmio` on the chip, a model of the registers in the tests. A bus belongs to
//! a [`Family`] of chips, which has its differences from the other: [`F4`] with [`F401`], [`G4`]. [`wire`] sets all of them up from a
//! [`Board`], in the order that is safe.
//!
//! | driver | peripheral | purpose |
//! |---|---|---|
//! | [`clock`] | RCC, FLASH, PWR | 84, 168 or 170 MHz from the board's oscillator |
//! | [`pins`] | GPIO | modes, levels |
//! | [`pwm`] | TIM1 | the output, and the break input that disables it |
//! | [`sample_timer`] | TIM5, TIM1 | samples in step with the PWM |
//! | [`quadrature`] | TIM3 | the encoder and its index |
//! | [`step_input`] | TIM4 | step pulses with a direction |
//! | [`inputs`] | GPIO, TIM1 | fault line, limit and home switches |
//! | [`serial`] | USART2, DMA1 | the line to the host |
//! | [`line_timer`] | SysTick | has the line listened to |
//! | `supply` | PWR, EXTI | disables the output when the supply sags |
//! | [`watchdog`] | IWDG | resets the chip unless it is fed |
//! | [`flash`] | FLASH | keeps records |
//! | [`interrupts`] | NVIC | priorities |
//!
//! `background` has the drive's background with the drivers of a chip.
//!
//! References are to RM0090, the manual of the STM32F405. The STM32F446 (RM0390) is the same in everything used here, and so is the STM32F401 (RM0368) at half of the clock.
//! Those of the STM32G474 are to RM0440, by the names of its chapters.
#![no_std]
#![deny(missing_docs)]

#[cfg(target_os = "none")]
pub mod background;
pub mod board;
pub mod bus;
pub mod clock;
#[cfg(all(feature = "emulator", target_os = "none"))]
pub mod emulated;
#[cfg(all(feature = "emulator", target_os = "none"))]
pub mod emulated_dma;
pub mod f4;
pub mod family;
pub mod flash;
mod frequencies;
pub mod g4;
pub mod inputs;
pub mod interrupts;
pub mod line_timer;
#[cfg(target_os = "none")]
mod mmio;
pub mod pins;
pub mod pwm;
pub mod quadrature;
mod registers;
pub mod sample_timer;
pub mod serial;
pub mod step_input;
mod supply;
pub mod watchdog;
mod wiring;

pub use board::Board;
pub use f4::{F4, F401};
pub use family::{Bus, Family};
pub use g4::G4;
#[cfg(target_os = "none")]
pub use mmio::Mmio;
pub use wiring::{Wired, disable_for_sag, disable_outputs, outlives_nmi, wire};
