//! Errors of a position sensor.

use core::f64::consts::PI;

use crate::excitation::NormalSource;
use identifier_core::error::{Allowed, OutOfRange};

use crate::noise::{Stream, source};

/// The errors of a position sensor, SI. Zero is an error that is absent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SensorEffects {
    /// Standard deviation of white noise before counting, rad.
    pub noise: f64,
    /// Amplitude of the error of an eccentric disc, once per turn, rad: ε sin q, up to
    /// [`SensorEffects::LARGEST`].
    pub eccentricity: f64,
    /// Standard deviation of the sampling instant as a share of the sample time, up to
    /// [`SensorEffects::LARGEST_JITTER`].
    pub jitter: f64,
}

impl SensorEffects {
    /// The largest noise and eccentricity, rad.
    pub const LARGEST: f64 = PI;
    /// The largest jitter, samples.
    pub const LARGEST_JITTER: f64 = 0.5;

    /// Checks them.
    ///
    /// # Errors
    /// The first value that is not allowed.
    pub fn check(&self) -> Result<(), OutOfRange> {
        let angle = Allowed::Within(0.0, Self::LARGEST);
        angle.check("noise", self.noise)?;
        angle.check("eccentricity", self.eccentricity)?;
        Allowed::Within(0.0, Self::LARGEST_JITTER).check("jitter", self.jitter)?;
        Ok(())
    }
}

/// A sensor with its errors, from sample to sample. It is an incremental one. It counts from its first reading, so that
/// its first error belongs to its origin.
#[derive(Debug, Clone)]
pub struct SensorErrors {
    noise: Option<(f64, NormalSource)>,
    eccentricity: f64,
    /// Standard deviation, s.
    jitter: Option<(f64, NormalSource)>,
    /// The first error, rad.
    origin: Option<f64>,
}

impl SensorErrors {
    /// Those of a sensor that is read every `sample_time` (s); the same seed gives the same errors.
    ///
    /// # Errors
    /// As [`SensorEffects::check`].
    pub fn new(effects: &SensorEffects, sample_time: f64, seed: u32) -> Result<Self, OutOfRange> {
        effects.check()?;
        let random = |size: f64, stream: Stream| (size > 0.0).then(|| (size, source(seed, stream)));
        Ok(Self {
            noise: random(effects.noise, Stream::SensorNoise),
            eccentricity: effects.eccentricity,
            jitter: random(effects.jitter * sample_time, Stream::Jitter),
            origin: None,
        })
    }

    /// The position that is seen (rad) of a servo at a position (rad) with a velocity (rad/s).
    pub fn seen(&mut self, position: f64, velocity: f64) -> f64 {
        let error = self.next_error(position, velocity);
        position - (*self.origin.get_or_insert(error) - error)
    }

    fn next_error(&mut self, position: f64, velocity: f64) -> f64 {
        let mut error = 0.0;
        if let Some((deviation, source)) = &mut self.jitter {
            error += velocity * *deviation * source.next_normal();
        }
        if self.eccentricity > 0.0 {
            error += self.eccentricity * libm::sin(position + error);
        }
        if let Some((deviation, source)) = &mut self.noise {
            error += *deviation * source.next_normal();
        }
        error
    }
}
