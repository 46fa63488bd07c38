//! The watch over a servo: fault detection from the encoder's counts and the command alone.
//!
//! [`ServoWatch::process`] is called once a sample, in the interrupt, with the measurement and the command that
//! acted. It names a [`Reason`](identifier_core::reason::Reason) within a stated number of samples after a fault has begun to show,
//! `ServoWatch::detection_times`, which its tests hold it to. It has no gains and gives no command; the reaction is its caller's.
//!
//! | fault | evidence | needs the servo to be known |
//! |---|---|---|
//! | samples late | a count that late samples raise and others lower | no |
//! | encoder lost | samples running without a reading | no |
//! | encoder jumping | more counts in a sample than speed or acceleration allow | no; finer when known |
//! | travel, speed | position; a mean of the increments | no |
//! | encoder stuck | no count although the servo cannot have stopped so soon | no; sooner when known |
//! | actuator dead, at rest | no motion under a command that must move the servo | no; sooner when known |
//! | actuator dead or weak, in motion | the motion changes less than the command says | yes |
//! | encoder or actuator reversed | the motion changes against the command | no; sooner when known |
//! | loop oscillating | half-cycles about the setpoint that do not decay, the command with them | no |
//!
//! At standstill, a failed encoder and a failed actuator look the same: no motion under a command that must move the
//! servo. That is called a dead actuator. A reversed encoder and a reversed actuator are the same to a loop, and have
//! one reason.
//!
//! A load may step by 0.3 of the command limit without being taken for a fault. In operation
//! ([`Use::Operation`]) loads may act at any time, and inertia may change. There a command that does not act as the model
//! says is a fault only if the servo does not follow its setpoint. For an unknown servo it is none.

mod blocks;
mod bounds;
mod following;
mod known_servo;
mod model;
mod oscillation;
mod readings;
mod response;
mod servo_watch;
mod settings;
mod standstill;
#[cfg(test)]
mod tests;

pub use bounds::LateSamples;
pub use known_servo::KnownServo;
pub(crate) use model::LOW_SPEED;
pub use servo_watch::{ServoWatch, ServoWatchState};
#[cfg(test)]
use settings::DetectionTimes;
pub use settings::{Observation, Use, WatchSettings};
