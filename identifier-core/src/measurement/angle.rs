//! The angle of an axis, of which gravity and ripple are functions.

use crate::constants::{Encode, encode};
use crate::number::Number;

/// The angle's revolution and the order of the ripple. The default is no angle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AngleSettings<N> {
    /// Position units of a revolution; zero for an axis without angle, or a model that needs none.
    pub revolution: N,
    /// Its reciprocal.
    pub per_revolution: N,
    /// Rad per position unit.
    pub resolution: N,
    /// The order N of the ripple.
    pub order: N,
}

encode! {
    [N: Encode] AngleSettings<N> as "AngleSettings" { revolution, per_revolution, resolution, order }
}

impl<N: Number> AngleSettings<N> {
    /// A revolution in position units and the order of the ripple; without a revolution there
    /// is no angle.
    #[must_use]
    pub fn new(revolution: f64, order: f64) -> Self {
        if revolution.is_nan() || revolution <= 0.0 {
            return Self::default();
        }
        Self {
            revolution: N::from_f64(revolution),
            per_revolution: N::from_f64(1.0 / revolution),
            resolution: N::from_f64(core::f64::consts::TAU / revolution),
            order: N::from_f64(order),
        }
    }

    /// A position (position units) within a revolution, from zero.
    #[inline]
    pub(crate) fn within(&self, position: N) -> N {
        let turns = (position * self.per_revolution).whole();
        let rest = position - N::from_count(turns) * self.revolution;
        if rest < N::ZERO {
            rest + self.revolution
        } else {
            rest
        }
    }

    /// sin q, cos q, sin Nq and cos Nq of a position, position units.
    #[inline]
    pub(crate) fn waves(&self, position: N) -> [N; 4] {
        let angle = position * self.resolution;
        let (sine, cosine) = angle.sine_cosine();
        let (ripple_sine, ripple_cosine) = (self.order * angle).sine_cosine();
        [sine, cosine, ripple_sine, ripple_cosine]
    }
}
