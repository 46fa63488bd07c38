//! The functions of `include/servo_id.h`: the core behind C's calling convention.
//!
//! An object lies in the caller's memory ([`object`]); nothing here allocates, is global or panics. A call is
//! checked before anything is touched, and answers with a status ([`status`]). The list of the functions with their
//! arguments is [`prototypes`], with which a test compares the header.
//!
//! The program `c-library` builds the static library and refuses one with a panic in it.

#![no_std]
#![allow(
    clippy::missing_safety_doc,
    reason = "what a caller has to keep is the same for all functions, and is in the header"
)]

#[macro_use]
mod face;

pub mod commission;
mod constants;
pub mod gamma;
#[macro_use]
pub mod identifier;
pub mod judge;
pub mod names;
pub mod object;
#[cfg(feature = "library")]
mod panic;
pub mod servo_loop;
pub mod settings;
pub mod status;
pub mod tuner;

pub use face::{Argument, Prototype};
use object::HasWords;

/// All functions of the header.
pub fn prototypes() -> impl Iterator<Item = &'static Prototype> {
    [gamma::FACE]
        .into_iter()
        .chain(identifier::FACES)
        .chain(servo_loop::FACES)
        .chain([judge::FACE, tuner::FACE, commission::FACE, names::FACE])
        .flatten()
}

/// The objects of the header: names without the prefix, and eight-byte words.
#[must_use]
pub fn objects() -> [(&'static str, usize); 15] {
    fn words<T: HasWords>(name: &'static str) -> (&'static str, usize) {
        (name, T::WORDS)
    }
    [
        words::<identifier::gradient::Gradient>("gradient"),
        words::<identifier::gradient_coulomb::GradientCoulomb>("gradient_coulomb"),
        words::<identifier::gauss_newton::GaussNewton>("gauss_newton"),
        words::<identifier::fixed::Fixed>("fixed"),
        words::<identifier::fixed_coulomb::FixedCoulomb>("fixed_coulomb"),
        words::<servo_loop::gradient::GradientLoop>("gradient_loop"),
        words::<servo_loop::gradient_coulomb::GradientCoulombLoop>("gradient_coulomb_loop"),
        words::<servo_loop::gauss_newton::GaussNewtonLoop>("gauss_newton_loop"),
        words::<servo_loop::fixed_point::FixedLoop>("fixed_loop"),
        words::<servo_loop::fixed_point_coulomb::FixedCoulombLoop>("fixed_coulomb_loop"),
        words::<tuner::Tuner>("tuner"),
        words::<commission::Commission>("commission"),
        words::<commission::Solver>("solver"),
        words::<commission::Record>("record"),
        words::<commission::Decision>("decision"),
    ]
}
