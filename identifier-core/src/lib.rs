#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

#[cfg(test)]
#[macro_use]
extern crate std;

// Once, in SI: the settings that every part is built from, and the errors that name one.
pub mod constants;
pub mod error;
pub mod interval;
pub mod number;
pub mod parameters;
pub mod reason;
mod scales;
pub mod settings;
pub mod units;

// Listen: identify from counts and commands.
pub mod identifier;
pub mod measurement;

// Control.
pub mod control;
pub mod drive;
pub mod excitation;

// Tune.
pub mod tuning;

// Say how sure.
pub mod replay;
pub mod stability;

// The same in fixed point.
#[cfg(feature = "fixed")]
pub mod fixed_point;

// Parts of the above, of which a commissioning fits with two.
pub mod fit;
mod gradient;
mod identify;
mod linalg;
pub mod model;
mod recursive;
mod servo_loop;
mod unrolled;
mod windows;

use control::Unshaped;
use identifier::{GaussNewtonIdentifier, GradientIdentifier, Identify, ServoLoop, ServoLoopState};
use measurement::velocity::{LowPass, LowPassState};
use parameters::Unknowns;

pub use parameters::sets::{AB, AB_COULOMB, AB_COULOMB_DELAY_LOAD, AB_COULOMB_LOAD};
pub use settings::Settings;

/// The paper's identifier of P unknowns behind a low-pass filter: [`AB`] or [`AB_COULOMB`].
pub type Gradient<N = f32, const P: usize = AB_COULOMB> =
    GradientIdentifier<N, LowPass<N>, Unknowns<P>, P>;

/// Recursive Gauss–Newton for P unknowns. Its first fit uses a record of W blocks.
pub type GaussNewton<N = f32, const P: usize = AB_COULOMB_LOAD, const W: usize = 256> =
    GaussNewtonIdentifier<N, Unknowns<P>, P, W>;

/// The state of a [`GaussNewton`].
pub type GaussNewtonState<N = f32, const P: usize = AB_COULOMB_LOAD, const W: usize = 256> =
    StateOf<N, GaussNewton<N, P, W>>;

/// The PID together with a [`Gradient`], and with [`Shaped`](control::Shaped) as S for a filter of the reference, a
/// feed-forward or a notch.
pub type GradientLoop<N = f32, const P: usize = AB_COULOMB, S = Unshaped> =
    ServoLoop<N, LowPass<N>, Gradient<N, P>, S>;

/// The state of a [`GradientLoop`].
pub type GradientLoopState<N = f32, const P: usize = AB_COULOMB, H = ()> =
    ServoLoopState<N, LowPassState<N>, StateOf<N, Gradient<N, P>>, H>;

type StateOf<N, I> = <I as Identify<N>>::State;
