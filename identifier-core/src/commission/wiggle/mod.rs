//! The first motion of a servo of which nothing is known, within limits that hold for any servo.

mod observer;
mod plan;
mod ramp;
mod settings;
mod state;
mod swing;
mod wiggling;

pub use settings::{LargestMotion, WiggleSettings};
pub use state::WiggleState;
pub use wiggling::{Progress, Wiggle, WiggleStep};
