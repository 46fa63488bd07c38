//! The first motion of an unknown servo, within limits for any servo.
//!
//! **Ramp.** From the holding command, or zero, the command grows until the encoder has moved by a few counts. It
//! grows exponentially at first, then by at most 2 % of the limit a millisecond. A linearly growing command moves a
//! servo as the cube of time since it broke away, q = b u̇ t³/6. The positions at the first count and now give b, and
//! d − c with it. If the load moves the disabled servo, the ramp first stops it. The command grows against the
//! motion, the faster the sooner travel or speed would be used up. At the turning point w t + b ∫u = 0 and w t²/2 + b
//! ∬u = q give b and w = d ∓ c.
//!
//! **Half-cycles.** From then on friction and load are compensated by their estimates. The servo is accelerated and
//! braked by ±A. A and amplitude are the largest that command, speed and travel permit. Braking begins as soon as 85
//! % of A could no longer stop the servo at its limit. The prediction starts where a command of now acts with the
//! longest delay. That is a sample, the known delay and two samples more. During braking, the command to stop within
//! the travel is computed again in every sample. The counts decide whether the servo has reversed, not the model.
//! Meanwhile a linear least-squares estimate refines b, d − c, d + c and a. The command must overcome its friction
//! and load. In either direction they are barely above the command of its break-away, if counts show that in time. If
//! the servo breaks away late, more command is added. The estimated friction reduces that addition.
//!
//! **End.** It ends by evidence. This is two turns at either end, and accelerations predicted within a standard error
//! of 0.8 % in both directions. On the last turn a loop holds the servo at its position. It reduces its bandwidth at
//! each oscillation. The motor of a compliant axis has, without its load, a multiple of the gain.
//!
//! A fifth of the travel and a quarter of the speed are kept in reserve.

mod command_ramp;
mod experiment;
mod half_cycle;
mod observer;
mod plan;
mod ramp;
mod settings;
mod state;

pub use command_ramp::CommandRamp;
pub(crate) use experiment::Probing;
pub use settings::LargestMotion;
pub(crate) use state::ProbingState;
