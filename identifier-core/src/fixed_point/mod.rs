//! Controller and Γ-gradient identifier in fixed point, for drives without a floating-point unit.
//!
//! The same equations in the same order as [`control`](crate::control), [`model`](crate::model) and
//! [`adaptation`](crate::adaptation) have them, on 32-bit words with 64-bit sums. A word is a
//! fraction of its quantity's full scale, a power of two that follows from an SI [`Ranges`], the gains
//! and the bounds of the estimates when the parts are built:
//!
//! | quantity | format | full scale, at least | beyond it |
//! |---|---|---|---|
//! | position error e, output error ε as read | Q2.30 | `ranges.error`, four times that of the velocity | saturates |
//! | ε between samples | Q2.62 | as above | the model starts again where the servo is |
//! | velocity q̇, q̇_e, increments, acceleration per sample | Q2.30, filters and q̇_e Q4.60 | `ranges.velocity`, twice bounds.b u, four times bounds of c and d | the servo's saturate; the model starts again |
//! | ε̇, y = μ ε + ε̇ | Q2.30 | twice the velocity's, twice μ times the error's | – |
//! | command u, u_e, k_i ω | Q2.30 | `ranges.command`, twice the limit | limited by the amplifier's limit, or to half |
//! | command before the limit | Q2.30 | twice what either of kp e and kd q̇ can be | – |
//! | sums of errors z, ω | Q2.62 | what asks for half of the command's | stop there |
//! | estimate â T | Q2.62, acting with 32 fraction bits | one quarter | the projection keeps it inside |
//! | estimates b̂, ĉ, d̂ | Q2.62, acting as Q2.30 | b: velocity over command; c, d: velocity | the projection keeps them inside |
//! | regressor: −u_e, q̇_e, sign | Q2.30 | as the signal | – |
//! | Γφ | Q2.30 | twice Γᵢᵢ times the regressor's | – |
//! | φᵀΓφ | Q2.30 | four times the largest Γᵢᵢφᵢ² | – |
//!
//! **Why nothing wraps.** A word has one guard bit, so two of them add up, and three halves. What
//! enters is saturated (position error, increments), what the integral gathers stops, and what leaves
//! the model's ranges starts it again, so between samples every word is below one. Within a sample
//! the full scales leave room: the three parts of a PID are at most one half each; b̂ u_e is at most
//! one half, d̂ and ĉ a quarter, the damping one half, so an acceleration is at most one and a half
//! and a velocity in its 64 bits at most two and a half of four. A factor of the configuration is
//! below one half of what its scales make one, so its product never needs a shift up; a step of an
//! estimate may, and saturates. The property tests drive all of this with any inputs at all, with
//! every sum checked.
//!
//! **Why it is fast.** Each factor is one `SMMULR`, each slow sum one `SMLAL`, and reading a sum is
//! reading its high half. What is shifted by distances that only the configuration knows is 32 bits
//! wide, but for the steps of the estimates.
//!
//! **What is refused when it is built**, with the number that would do: an error range that leaves
//! less than a sixteenth of a count; bounds of a beyond a quarter of the sample rate; a velocity range so far below the error's that ε would not fit
//! 64 bits; a command range below the limit; a sample time at which an error adds nothing to the
//! integral; a Γ that moves an estimate by more than all that its sum can hold, or whose φᵀΓφ at full
//! scale is so large that the guard's bound would be lost in it; a μ that vanishes; a Γ that is not
//! diagonal.
//!
//! Gauss–Newton and the window stay in floating point: a covariance loses the square of the signals'
//! range, from 10⁻¹² to 1 within a second, so a word would need an exponent of its own per entry and
//! sample, which is what a floating-point number is.

mod arithmetic;
mod controller;
mod gradient;
mod identifier;
mod model;
mod pid;
mod ranges;
mod rest;
mod servo_loop;
mod step;
mod velocity;

pub use arithmetic::{Accumulator, Word};
pub use controller::{FixedControlSample, FixedControlState, FixedController, split_setpoint};
pub use identifier::{FixedGradientIdentifier, FixedGradientState};
pub use servo_loop::{FixedLoopStep, FixedServoLoop, FixedServoLoopState};
pub use velocity::{FixedAveragedDifference, FixedLowPass, FixedVelocity};
