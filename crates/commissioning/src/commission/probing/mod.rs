//! The first motion of a servo of which nothing is known, within limits that hold for any servo, and later
//! motions of one that is known.
//!
//! **Ramp.** From the command that holds it, or none, the command grows: exponentially at first, then by at
//! most 2 % of the limit a millisecond, until the encoder has moved by a few counts. A command that grows
//! evenly moves a servo as the cube of time since it broke away, q = b u̇ t³/6; where it was at the first
//! count and where it is now give b, and d − c with it. A servo that its load moves as it is released is
//! caught first: the command grows against the motion, the faster the sooner travel or speed would be used
//! up; where it turns, w t + b ∫u = 0 and w t²/2 + b ∬u = q give b and w = d ∓ c.
//!
//! **Swings.** From then on friction and load are compensated by their estimates, and the servo is
//! accelerated and braked by ±A, A and amplitude being the largest that command, speed and travel
//! permit. It is braked as soon as it could not be stopped where it should with 85 % of A, reckoned from
//! where it is when a command of now acts at the latest: a sample, the delay that is known and two samples
//! more. While it is braked, what is needed to stop within the travel is reckoned anew in every sample. A
//! turn is what the counts show, not what is thought. Meanwhile a linear least-squares estimate refines
//! b, d − c, d + c and a, with friction and load that the command overcomes, and in either direction hardly more than the command
//! of the break-away there, where counts show that in time. A push that is late has command added, which becomes less by the
//! friction that the estimate has learnt.
//!
//! **End.** It ends by evidence: two turns at either end, and accelerations predicted within a standard error
//! of 0.8 % in both directions. On the last turn the servo is held where it stands, by a loop that
//! gives way each time that it swings back: the motor of a compliant axis alone is a multiple as strong.
//!
//! A fifth of the travel and a quarter of the speed are kept in reserve.

mod experiment;
mod observer;
mod plan;
mod ramp;
mod settings;
mod state;
mod swing;

pub(crate) use experiment::{Probing, ProbingProgress};
pub use settings::LargestMotion;
pub(crate) use settings::ProbingSettings;
pub(crate) use state::ProbingState;
