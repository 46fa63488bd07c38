//! The servo from the record of a motion, in slices of background work.
//!
//! The interrupt's [`MotionRecorder`] condenses samples to [blocks](crate::fit::NumberedBlock), which end where the command
//! changes, so that a short record drives a model as exactly as the samples would, delayed by any part of
//! a sample; the background collects them in a [`MotionRecord`]. A [`ServoFitter`] fits a, b, c, d and the delay
//! to it, measures how well a known servo predicts it, and looks for the effect that a failing model lacks.

mod affected;
mod block;
mod comparison;
mod effect;
mod effect_model;
mod effect_search;
mod follower;
mod inputs;
mod motion;
mod pass;
mod placing;
mod prediction;
mod prior;
mod recorder;
mod scales;
mod servo_fit;
mod servo_fitter;

pub(crate) use effect_search::{Diagnosis, EffectSearch};
pub(crate) use motion::MotionRecord;
pub(crate) use prediction::{PredictionErrors, PredictionRun};
pub(crate) use recorder::MotionRecorder;
pub(crate) use servo_fit::ServoFit;
pub(crate) use servo_fitter::{FitSettings, ServoFitter};

/// The fitted unknowns, in the order of [`IdentifiedServo`](super::IdentifiedServo)'s covariance, then position
/// and velocity with which the record begins.
const UNKNOWNS: usize = 7;
const A: usize = super::IdentifiedServo::A;
const B: usize = super::IdentifiedServo::B;
const COULOMB: usize = super::IdentifiedServo::COULOMB;
const DELAY: usize = super::IdentifiedServo::DELAY;
const LOAD: usize = super::IdentifiedServo::LOAD;
const POSITION: usize = 5;
const VELOCITY: usize = 6;

/// The same, then sizes of an effect.
const ALL: usize = UNKNOWNS + effect::SIZES;
