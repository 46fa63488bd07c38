use identifier_core::parameters::{PerQuantity, Unknown};

/// Usual sizes of the motion, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UsualSizes {
    /// Deviation of the velocity, rad/s.
    pub(super) velocity: f64,
    /// Deviation of the command; of a fit the largest.
    pub(super) command: f64,
}

impl UsualSizes {
    /// The size beside which an error of an unknown is small or large, in its unit.
    pub(super) fn scale_of(&self, unknown: Unknown, b: f64) -> f64 {
        let acceleration = b.abs() * self.command;
        let rate = acceleration / self.velocity.max(f64::MIN_POSITIVE);
        let scales = PerQuantity {
            rate,
            gain: b.abs(),
            acceleration,
            time: 1.0 / rate.max(f64::MIN_POSITIVE),
            command: self.command,
        };
        scales.get(unknown)
    }
}
