//! The output error that a model leaves.

use serde::Serialize;

/// The output error of the model over the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Residual {
    /// Root mean square, rad.
    pub rms: f64,
    /// Root mean square of rounding to the encoder's resolution alone, rad.
    pub resolution_rms: f64,
    /// Correlation from sample to sample.
    pub correlation: f64,
}

impl Residual {
    /// Output error beyond this many times the encoder's is not the encoder's.
    const MAX_ENCODER_RATIO: f64 = 1.5;
    /// Correlation beyond this is not that of rounding.
    const MAX_CORRELATION: f64 = 0.3;

    /// True if the encoder's resolution accounts for the output error.
    #[must_use]
    pub fn is_the_encoders(&self) -> bool {
        !self.is_large() && !self.is_autocorrelated()
    }

    /// True if it is more than the encoder's resolution leaves.
    #[must_use]
    pub fn is_large(&self) -> bool {
        self.rms > Self::MAX_ENCODER_RATIO * self.resolution_rms
    }

    /// True if it is correlated from sample to sample.
    #[must_use]
    pub fn is_autocorrelated(&self) -> bool {
        self.correlation > Self::MAX_CORRELATION
    }
}
