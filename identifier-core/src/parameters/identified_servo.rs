use super::ServoParameters;

/// An identified servo with its uncertainty, SI, laid out as C does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct IdentifiedServo {
    /// a, b, Coulomb friction and load.
    pub parameters: ServoParameters,
    /// The delay from a command to its acceleration besides the hold's, s.
    pub delay: f64,
    /// Covariance of [a, b, c, τ, d] in this order, SI; zero for known parameters.
    pub covariance: [[f64; 5]; 5],
    /// Standard deviation of the position that the model leaves unexplained, rad; at least the
    /// encoder's.
    pub unexplained: f64,
}

impl IdentifiedServo {
    /// Places in the covariance.
    pub const A: usize = 0;
    /// Place of b.
    pub const B: usize = 1;
    /// Place of c.
    pub const COULOMB: usize = 2;
    /// Place of τ.
    pub const DELAY: usize = 3;
    /// Place of d.
    pub const LOAD: usize = 4;

    /// The standard errors within which an unknown is.
    pub const STANDARD_ERRORS: f64 = 3.0;

    /// One that is known exactly, with its delay, s.
    #[must_use]
    pub const fn known(parameters: ServoParameters, delay: f64) -> Self {
        Self {
            parameters,
            delay,
            covariance: [[0.0; 5]; 5],
            unexplained: 0.0,
        }
    }

    /// The same with independent standard errors of [a, b, c, τ, d], SI.
    #[must_use]
    pub fn with_errors(mut self, errors: [f64; 5]) -> Self {
        self.covariance = [[0.0; 5]; 5];
        for (place, (row, error)) in self.covariance.iter_mut().zip(errors).enumerate() {
            if let Some(entry) = row.get_mut(place) {
                *entry = error * error;
            }
        }
        self
    }

    /// [a, b, c, τ, d], SI.
    #[must_use]
    pub fn values(&self) -> [f64; 5] {
        let own = &self.parameters;
        [own.a, own.b, own.coulomb, self.delay, own.load]
    }

    /// The standard error of an unknown by its place.
    #[must_use]
    pub fn standard_error(&self, place: usize) -> f64 {
        let variance = self.covariance.get(place).and_then(|row| row.get(place));
        libm::sqrt(variance.copied().unwrap_or(0.0).max(0.0))
    }

    /// The largest Coulomb friction that it may have, rad/s².
    #[must_use]
    pub fn most_coulomb(&self) -> f64 {
        let error = self.standard_error(Self::COULOMB);
        self.parameters.coulomb.max(0.0) + Self::STANDARD_ERRORS * error
    }
}
