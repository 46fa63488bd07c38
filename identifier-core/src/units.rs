//! Conversion between SI configuration and the machine units of the loop.

use crate::constants::encode;
use crate::error::{Allowed, OutOfRange};

/// SI outside, machine units inside. Time is counted in samples, position in machine units of the
/// caller's choice. For an encoder these are its counts, which are then exact integers.
///
/// With the sample time T and the position unit ρ (rad per machine unit) the loop computes in
///
/// | quantity | SI | in the loop |
/// |---|---|---|
/// | position q, error e, output error ε | rad | q/ρ |
/// | velocity v | rad/s | v T/ρ |
/// | integral of an error | rad s | ∑, /(ρ T) |
/// | command u | command units | u |
/// | a | 1/s | a T |
/// | b | rad/s² per command unit | b T²/ρ |
/// | acceleration (load d, friction c) | rad/s² | d T²/ρ |
///
/// so that no sample needs to know T or ρ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    sample_time: f64,
    position_unit: f64,
}

encode! {
    [] Units as "Units" { sample_time, position_unit }
}

impl Units {
    /// The range of sample times, s: from 10 MHz to a sample in ten seconds.
    pub const SAMPLE_TIMES: (f64, f64) = (1e-7, 10.0);

    /// The range of position units, rad per machine unit.
    pub const POSITION_UNITS: (f64, f64) = (1e-12, 1e3);

    /// Units for a sample time (s) and a position unit (rad per machine unit). For an encoder it is
    /// 2π / counts per revolution. For a linear axis read m for rad everywhere.
    ///
    /// # Errors
    /// `sample_time` must be in [`Units::SAMPLE_TIMES`], `position_unit` in
    /// [`Units::POSITION_UNITS`].
    pub fn new(sample_time: f64, position_unit: f64) -> Result<Self, OutOfRange> {
        Ok(Self {
            sample_time: within(Self::SAMPLE_TIMES).check("sample_time", sample_time)?,
            position_unit: within(Self::POSITION_UNITS).check("position_unit", position_unit)?,
        })
    }

    /// The sample time T, s.
    #[must_use]
    pub fn sample_time(&self) -> f64 {
        self.sample_time
    }

    /// The position unit ρ, rad per machine unit.
    #[must_use]
    pub fn position_unit(&self) -> f64 {
        self.position_unit
    }

    /// Position in machine units per rad.
    #[must_use]
    pub fn position(&self) -> f64 {
        1.0 / self.position_unit
    }

    /// Velocity in machine units per rad/s.
    #[must_use]
    pub fn velocity(&self) -> f64 {
        self.sample_time / self.position_unit
    }

    /// Acceleration in machine units per rad/s²; also of b per rad/s² and command unit.
    #[must_use]
    pub fn acceleration(&self) -> f64 {
        self.sample_time * self.velocity()
    }

    /// A rate (a, μ, a cut-off) in machine units per 1/s.
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.sample_time
    }
}

fn within((low, high): (f64, f64)) -> Allowed {
    Allowed::Within(low, high)
}
