//! The gain with which the model follows the record: a Kalman filter whose noise is found, not set.

/// The time over which the model is trusted: the horizon of its process noise, samples.
///
/// The filter estimates position, velocity and a load from measurements of variance one. White noise of the
/// acceleration has the spectral density N₀⁻⁴, and the increments of a random-walk load N₁⁻⁶. A model error thus grows
/// to the measurement's within about N samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Horizon {
    /// N₀ of white acceleration.
    pub white: f64,
    /// N₁ of a load that walks; none for a constant load.
    pub walk: Option<f64>,
}

/// Diffuse variances at the beginning of a motion, of a measurement's variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Diffuse {
    pub(super) velocity: f64,
    pub(super) load: f64,
}

/// Riccati's recursion until it is stationary (Kalman, "A new approach to linear filtering and prediction problems",
/// Journal of Basic Engineering 82(1), 1960).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Riccati {
    covariance: [[f64; 3]; 3],
    transition: [[f64; 3]; 3],
    noise: [[f64; 3]; 3],
    /// Gain of position, velocity and load per innovation.
    pub(super) gain: [f64; 3],
    /// Variance of the innovation over that of a measurement.
    pub(super) variance: f64,
    measurements: u32,
    before: f64,
    is_steady: bool,
}

impl Riccati {
    /// Variance of the first position.
    const POSITION: f64 = 4.0;

    /// At the beginning of a motion, with viscous friction `a`, 1/sample.
    pub(super) fn new(a: f64, horizon: Horizon, diffuse: &Diffuse) -> Self {
        let a = a.max(0.0);
        let white = libm::pow(horizon.white, -4.0);
        let walk = horizon.walk.map_or(0.0, |walk| libm::pow(walk, -6.0));
        let kept = (1.0 - a).max(0.0);
        let load = if walk > 0.0 { diffuse.load } else { 0.0 };
        Self {
            covariance: [
                [Self::POSITION, 0.0, 0.0],
                [0.0, diffuse.velocity, 0.0],
                [0.0, 0.0, load],
            ],
            transition: [[1.0, 1.0 - 0.5 * a, 0.5], [0.0, kept, 1.0], [0.0, 0.0, 1.0]],
            noise: [
                [
                    white / 3.0 + walk / 20.0,
                    white / 2.0 + walk / 8.0,
                    walk / 6.0,
                ],
                [white / 2.0 + walk / 8.0, white + walk / 3.0, walk / 2.0],
                [walk / 6.0, walk / 2.0, walk],
            ],
            gain: [0.0; 3],
            variance: 1.0,
            measurements: 0,
            before: 0.0,
            is_steady: false,
        }
    }

    /// The gain of the next sample that has a measurement.
    pub(super) fn measure(&mut self) {
        /// Relative change of the gain over sixteen measurements below which it is stationary.
        const STEADY: f64 = 1e-7;
        /// Measurements before it may.
        const MIN_MEASUREMENTS: u32 = 50;
        if self.is_steady {
            return;
        }
        let p = self.covariance;
        self.variance = p[0][0] + 1.0;
        for i in 0..3 {
            self.gain[i] = p[i][0] / self.variance;
            for j in 0..3 {
                self.covariance[i][j] = p[i][j] - self.gain[i] * p[0][j];
            }
        }
        if self.measurements.is_multiple_of(16) {
            let change = (self.gain[0] - self.before).abs();
            self.is_steady = self.measurements > MIN_MEASUREMENTS && change < STEADY * self.gain[0];
            self.before = self.gain[0];
        }
        self.measurements += 1;
    }

    /// The model moves on by a sample.
    ///
    /// It is written in loops. Closures over arrays are not inlined here and took half of the time of a plain fit.
    pub(super) fn predict(&mut self) {
        if self.is_steady {
            return;
        }
        let (f, p) = (&self.transition, &self.covariance);
        let mut moved = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                moved[i][j] = f[i][0] * p[0][j] + f[i][1] * p[1][j] + f[i][2] * p[2][j];
            }
        }
        let mut next = self.noise;
        for i in 0..3 {
            for j in 0..3 {
                next[i][j] += moved[i][0] * f[j][0] + moved[i][1] * f[j][1] + moved[i][2] * f[j][2];
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                self.covariance[i][j] = 0.5 * (next[i][j] + next[j][i]);
            }
        }
    }
}
