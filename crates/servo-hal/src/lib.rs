//! The output stage of a servo drive over embedded-hal 1.0: for whatever implements its traits.
//!
//! | adapter | drives | over |
//! |---|---|---|
//! | [`PwmDirection`] | a bridge with a PWM and a direction input | `SetDutyCycle`, `OutputPin` |
//! | [`Gate`] | a stage with an enable pin, and the pin of a holding brake | `OutputPin` |
//!
//! A command is held with as many duty steps as the PWM has; what one step is in command units is
//! its resolution. For another bridge implement [`Actuator`](identifier_core::drive::Actuator).
//! Quadrature counters have no trait of embedded-hal: implement
//! [`PositionSensor`](identifier_core::drive::PositionSensor) over the chip's own and a
//! [`Counter`](identifier_core::measurement::Counter).

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod bridge;
mod gate;

pub use bridge::{BridgeError, PwmDirection};
pub use gate::{Gate, GateError};
