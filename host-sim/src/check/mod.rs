//! What a scenario means, told before it is run: the loop's bandwidth and margins, what the motion will show of each
//! unknown and how soon, and what speaks against it.
//!
//! The loop's figures are those of the sampled loop with all its delay. The rest comes from a rehearsal: the
//! simulated servo moves as it would in the run, and only the motion is looked at.

mod closed_loop;
mod document;
mod information;
mod rehearsal;
mod warnings;
mod words;

pub use closed_loop::ClosedLoop;
pub use document::{Certified, Check, Encoder, Known, Servo};
pub use words::Words;
