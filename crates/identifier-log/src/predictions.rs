//! Predictions of several logs, as a result has them.

use crate::found_servo::FoundServo;
use crate::log::Log;
use crate::predict::predict;
use crate::result::Prediction;
use crate::scenario::{Fault, Options};

/// Predictions of several logs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Predictions {
    /// One for each log; none without a servo.
    pub predictions: Vec<Prediction>,
    /// The largest error in open loop of a log that the servo was not found in, relative to its motion; NaN is no small
    /// one.
    pub largest_error: Option<f64>,
}

/// Predicts logs by the servo that was found in others, or in some of them.
///
/// # Errors
/// The key that does not suit a log.
pub fn predict_logs(
    options: &Options,
    found: Option<&FoundServo>,
    learnt: &[Log],
    logs: &[Log],
) -> Result<Predictions, Fault> {
    let mut all = Predictions::default();
    let Some(found) = found else { return Ok(all) };
    for log in logs {
        let is_seen = learnt.iter().any(|own| own.is_same_file(log));
        let predicted = predict(options, found, log)?;
        if let Some(open_loop) = predicted.open_loop.as_ref().filter(|_| !is_seen) {
            let worse = |known: &f64| known.is_nan() || *known >= open_loop.relative;
            all.largest_error = all.largest_error.filter(worse).or(Some(open_loop.relative));
        }
        all.predictions
            .push(Prediction::new(log, is_seen, &predicted));
    }
    Ok(all)
}
