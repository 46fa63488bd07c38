use crate::error::{Allowed, OutOfRange};

/// The gains of the PID (3) in SI: u = kp e − kd q̇ + ki ∫e.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    kp: f64,
    kd: f64,
    ki: f64,
}

impl Gains {
    /// The largest gain, SI. It is far beyond any drive, and keeps every product of the loop within
    /// the range of single precision.
    pub const LARGEST: f64 = 1e9;

    /// The proportional gain is in command units/rad, above 0. The derivative gain on the measured
    /// velocity is in command units per rad/s, at least 0. The integral gain is in command units
    /// per rad s, at least 0. None is above [`Gains::LARGEST`].
    ///
    /// # Errors
    /// The gain that is out of its range, by name: `kp`, `kd` or `ki`.
    pub fn new(kp: f64, kd: f64, ki: f64) -> Result<Self, OutOfRange> {
        Ok(Self {
            kp: Allowed::PositiveUpTo(Self::LARGEST).check("kp", kp)?,
            kd: Allowed::Within(0.0, Self::LARGEST).check("kd", kd)?,
            ki: Allowed::Within(0.0, Self::LARGEST).check("ki", ki)?,
        })
    }

    /// Proportional gain, command units/rad.
    #[must_use]
    pub fn kp(&self) -> f64 {
        self.kp
    }

    /// Derivative gain, command units per rad/s.
    #[must_use]
    pub fn kd(&self) -> f64 {
        self.kd
    }

    /// Integral gain, command units per rad s.
    #[must_use]
    pub fn ki(&self) -> f64 {
        self.ki
    }
}
