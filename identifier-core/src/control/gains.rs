use crate::error::{Allowed, OutOfRange};

/// The gains of the PID (3) in SI: u = kp e − kd q̇ + ki ∫e.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    kp: f64,
    kd: f64,
    ki: f64,
}

impl Gains {
    /// Proportional gain (command units/rad, above 0), derivative gain on the measured velocity
    /// (command units per rad/s, at least 0), integral gain (command units per rad s, at least 0).
    ///
    /// # Errors
    /// The gain that is out of its range, by name: `kp`, `kd` or `ki`.
    pub fn new(kp: f64, kd: f64, ki: f64) -> Result<Self, OutOfRange> {
        Ok(Self {
            kp: Allowed::Above(0.0).check("kp", kp)?,
            kd: Allowed::AtLeast(0.0).check("kd", kd)?,
            ki: Allowed::AtLeast(0.0).check("ki", ki)?,
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
