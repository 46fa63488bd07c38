//! The frequency-response motion: a multisine added to constant speed, in both directions, under the loop that holds
//! the servo.
//!
//! Friction hides a resonance from a motor at standstill, and shows it in motion. For each line of the multisine the
//! interrupt sums increments Δq and commands u over a window,
//!
//! Y = ∑ h_k Δq_k e^(−jω k T), U = ∑ h_k u_k e^(−jω k T), h_k = 1 − cos(2π k/n),
//!
//! with a phase that is the same in every motion relative to the line's injection, by amplitude and sign of which the sums
//! are weighted. The response from command to position is then, in closed loop without bias by what else moves the servo,
//!
//! G(ω) = ∑ ±Y / ∑ ±U / (1 − e^(−jωT)), over the motions, minus where the injection was inverted.

mod following;
mod line;
mod lines;
mod plan;
mod response_motion;
#[cfg(test)]
mod tests;
mod window;

pub(crate) use lines::{LineRotations, LineSearch, Lines};
pub(crate) use plan::{ResponsePlan, ResponsePlanner};
pub(super) use response_motion::{ResponseMotion, ResponseProgress};
pub(super) use window::ResponseWindows;

/// The mean motion in the window, means weighted with h: friction and load, as the constant speed
/// takes their balance. Counts and samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrictionBalance<N> {
    pub(crate) velocity: N,
    pub(crate) acceleration: N,
    pub(crate) command: N,
}

/// The sums of a line over the window of a motion, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineSums<N> {
    /// Its place among the [`Lines`].
    pub(crate) line: u8,
    /// True if the injection had the opposite sign.
    pub(crate) inverted: bool,
    /// Y, real and imaginary part: of the increments, counts.
    pub(crate) position: [N; 2],
    /// U: of the command, command units.
    pub(crate) command: [N; 2],
}
