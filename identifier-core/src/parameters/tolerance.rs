//! The tolerances of estimates.

use super::{Quantity, Unknown};

/// The tolerance of an unknown: a part of itself, or of the quantity that it acts beside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Tolerance of b. A servo without it does not move, so only b itself is the reference.
    pub gain: f64,
    /// Tolerance of friction, load and other forces. One part is of itself, the other of the acceleration by the
    /// command.
    pub force: [f64; 2],
    /// Tolerance of a, of asymmetry and of every unknown that is no force. One part is of itself, the other of the
    /// quantity that it acts beside.
    pub other: [f64; 2],
}

impl Tolerance {
    /// The standard error up to which an unknown is within tolerance.
    pub const STD_ERROR: Self = Self {
        gain: 0.015,
        force: [Self::OF_ITSELF, 0.005],
        other: [Self::OF_ITSELF, 0.01],
    };

    /// The part of itself to which every unknown but b is known.
    const OF_ITSELF: f64 = 0.05;

    /// An estimate nearer to zero than this part of the quantity that it acts beside is at no bound. Friction is never
    /// negative.
    pub const ZERO_SHARE: f64 = 0.002;

    /// The limit for an estimate beside a quantity `beside`, both SI.
    #[must_use]
    pub fn limit(self, unknown: Unknown, estimate: f64, beside: f64) -> f64 {
        let size = estimate.abs();
        let [of_itself, of_beside] = match unknown.quantity() {
            Quantity::Gain => return self.gain * size,
            Quantity::Acceleration => self.force,
            _ => self.other,
        };
        (of_itself * size).max(of_beside * beside)
    }
}
