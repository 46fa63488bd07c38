use identifier_core::fit::{Fit, Fitter};
use identifier_core::identifier::IdentifiableSet;
use identifier_core::number::Number;
use identifier_core::parameters::{Unknown, UnknownSet};

/// The unknowns of a motion's model.
pub(super) const UNKNOWNS: usize = 8;

/// The model of a motion: the servo, and the forces beside it that a motion may need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MotionModel;

impl UnknownSet<UNKNOWNS> for MotionModel {
    const UNKNOWNS: [Unknown; UNKNOWNS] = [
        Unknown::A,
        Unknown::B,
        Unknown::Coulomb,
        Unknown::Delay,
        Unknown::LowSpeed,
        Unknown::GravitySine,
        Unknown::GravityCosine,
        Unknown::Load,
    ];
}

impl IdentifiableSet<UNKNOWNS> for MotionModel {
    type Lower<N: Number> = [N; UNKNOWNS * (UNKNOWNS - 1) / 2];
    type Inputs<N: Number> = ();
}

/// The places of its unknowns.
pub(super) const A: usize = 0;
pub(super) const B: usize = 1;
pub(super) const COULOMB: usize = 2;
pub(super) const DELAY: usize = 3;
pub(super) const LOW_SPEED: usize = 4;
pub(super) const GRAVITY_SINE: usize = 5;
pub(super) const GRAVITY_COSINE: usize = 6;
pub(super) const LOAD: usize = 7;

/// The places of an [`IdentifiedServo`](identifier_core::parameters::IdentifiedServo)'s, in the order of its covariance.
pub(super) const OF_SERVO: [usize; 5] = [A, B, COULOMB, DELAY, LOAD];

/// A fitter of it.
pub(super) type MotionFitter<N> = Fitter<N, MotionModel, UNKNOWNS>;

/// A fit of it under way.
pub(super) type MotionFit<N> = Fit<N, UNKNOWNS>;
