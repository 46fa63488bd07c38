//! The servo from the record of a motion, in slices of background work.
//!
//! The interrupt condenses samples to [blocks](identifier_core::identifier::NumberedBlock); the background collects
//! them in a [`MotionRecord`]. A [`ServoFitter`] fits a, b, c, d and the delay to it. It measures how well a given
//! servo predicts it. It also searches the effect that a failing model lacks.

mod affected;
mod comparison;
mod effect;
mod effect_model;
mod effect_search;
mod motion;
mod motion_model;
mod piece;
mod prediction;
mod scales;
mod servo_fit;
mod servo_fitter;
mod whitening;

pub(crate) use effect_search::{Diagnosis, EffectSearch};
pub(crate) use motion::MotionRecord;
pub(crate) use prediction::{PredictionErrors, PredictionRun};
pub(crate) use servo_fit::ServoFit;
pub(crate) use servo_fitter::{FitSettings, ServoFitter};

use identifier_core::parameters::IdentifiedServo;

/// The parameters of a servo, in the order of [`IdentifiedServo`]'s covariance.
const PARAMETERS: usize = 5;

/// The same, then position and velocity with which the record begins.
const UNKNOWNS: usize = 7;
const A: usize = IdentifiedServo::A;
const B: usize = IdentifiedServo::B;
const COULOMB: usize = IdentifiedServo::COULOMB;
const DELAY: usize = IdentifiedServo::DELAY;
const LOAD: usize = IdentifiedServo::LOAD;
const POSITION: usize = 5;
const VELOCITY: usize = 6;

/// The same, then sizes of an effect.
const ALL: usize = UNKNOWNS + effect::SIZES;
