//! The servo from the record of a motion, in slices of background work.
//!
//! The interrupt condenses samples to [blocks](identifier_core::identifier::NumberedBlock); the background collects
//! them in a [`MotionRecord`]. A [`ServoFitter`] fits a, b, c, d and the delay to it, and measures how well they explain it.

mod fitted_servo;
mod force_search;
mod motion;
mod motion_model;
mod piece;
mod servo_fit;
mod servo_fitter;

pub(crate) use fitted_servo::FittedServo;
pub(crate) use motion::MotionRecord;
pub(crate) use servo_fit::ServoFit;
pub(crate) use servo_fitter::ServoFitter;
