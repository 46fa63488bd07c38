//! Noise of the position sensor.

use serde::{Deserialize, Serialize};

/// Standard deviation of the noise of the measured position, rounding included. None if there was too little motion, or
/// standstill, to measure it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct SensorNoise {
    /// In motion, encoder counts; rounding alone is 0.29 counts.
    pub moving_counts: Option<f64>,
    /// At standstill, encoder counts; zero where the count does not change.
    pub standstill_counts: Option<f64>,
    /// In motion, rad.
    pub moving: Option<f64>,
    /// At standstill, rad.
    pub standstill: Option<f64>,
}
