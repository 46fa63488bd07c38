//! The result of a comparison of number formats.

/// Differences of number formats from double precision.
#[derive(Debug, Clone, PartialEq)]
pub struct DriftResult {
    /// Samples run.
    pub samples: u64,
    /// True if every value was finite.
    pub all_finite: bool,
    /// Differences in single precision.
    pub f32: Vec<Difference>,
    /// Differences in fixed point.
    pub fixed: Vec<Difference>,
}

/// Difference of a signal of a format from that of double precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The signal's name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Root mean square of the signal itself over the last quarter, in double precision.
    pub size: f64,
    /// Mean of the difference over the last quarter.
    pub mean: f64,
    /// Its root mean square over the last quarter.
    pub rms: f64,
    /// Its largest magnitude over the whole run.
    pub max: f64,
}

impl Difference {
    /// 20 log₁₀ of the signal's root mean square over that of the difference; none without either.
    #[must_use]
    pub fn signal_to_noise(&self) -> Option<f64> {
        let has_both = self.rms > 0.0 && self.size > 0.0;
        has_both.then(|| 20.0 * (self.size / self.rms).log10())
    }
}
