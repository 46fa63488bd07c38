//! The first motion of a servo of which nothing is known, within limits that hold for any servo.

mod crude;
mod observer;
mod plan;
mod ramp;
mod regression;
mod settings;
mod state;
mod swing;
mod wiggling;

pub use crude::Crude;
pub use settings::{LargestMotion, WiggleSettings};
pub use state::WiggleState;
pub use wiggling::{Progress, Wiggle, WiggleStep};
