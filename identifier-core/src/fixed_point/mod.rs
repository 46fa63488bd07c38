//! Controller and Γ-gradient identifier in fixed point, for drives without a floating-point unit.
//!
//! The same equations in the same order as [`control`](crate::control), [`model`](crate::model) and
//! [`adaptation`](crate::adaptation) have them, on 32-bit words with 64-bit accumulators. A word is
//! a fraction of its quantity's full scale, a power of two that follows from an SI [`Ranges`] and
//! the bounds of the estimates when the parts are built:
//!
//! | quantity | word | full scale | guard bits | beyond it |
//! |---|---|---|---|---|
//! | position error e, output error ε | Q2.30 | `ranges.error` | 1 | e saturates; a model that is ε away starts again where the servo is |
//! | ε between samples | 64 bits | four times `ranges.error` | 2 | as above |
//! | velocity q̇, q̇_e, increments, ε̇, y | Q2.30, filters and model Q4.60 | `ranges.velocity` | 1, 3 | saturates |
//! | command u, u_e, k_i ω | Q2.30 | `ranges.command`, at least the limit | 1 | limited by the amplifier's limit |
//! | sums of errors z, ω | 64 bits, in last bits of e | what asks for twice `ranges.command` | – | stop there |
//! | acceleration b u + d − c s − a q̇ | Q2.30, sums Q4.60 | bounds.b times `ranges.command` | 1, 3 | saturates |
//! | estimates â, b̂, ĉ, d̂ | Q4.60, acting as Q2.30 | the larger end of their bounds | 3, 1 | the projection keeps them inside |
//! | regressor: −u_e, q̇_e, sign | Q2.30 | as the signal | 1 | – |
//! | Γφ | Q2.30 | Γᵢᵢ times the regressor's | 1 | – |
//! | φᵀΓφ | Q4.60 | four times the largest Γᵢᵢφᵢ² | 3 | – |
//!
//! **Why nothing wraps.** Every word is made by [`Word`] operations that end in a clamp to ±1, so a
//! product of two words is at most one and fits Q4.60 with three guard bits: seven such products add
//! up without a carry. Shifts up saturate, shifts down round to the nearest, and every sum that is
//! not of words (ε, z, ω, the estimates) is a saturating one with a clamp of its own. The property
//! tests drive these with any bits at all.
//!
//! **What is refused when it is built**, with the number that would do: an error range that leaves
//! less than a sixteenth of a count; a velocity range so far below the error's that ε would not fit
//! 64 bits; a command range below the limit; a sample time at which an error adds nothing to the
//! integral; a Γ whose φᵀΓφ at full scale is so large that the guard's bound would be lost in it; a
//! μ that vanishes; a Γ that is not diagonal.
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
mod step;
mod travel;
mod velocity;

pub use arithmetic::{Accumulator, Word};
pub use controller::{FixedControlSample, FixedControlState, FixedController, reference_of_counts};
pub use identifier::{FixedGradientIdentifier, FixedGradientState, FixedIdentification};
pub use ranges::Ranges;
pub use velocity::{FixedAveragedDifference, FixedLowPass, FixedVelocity};
