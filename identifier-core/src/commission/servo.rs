use super::Crude;
use crate::model::ServoParameters;
use crate::number::Number;
use crate::units::Units;

/// What a commissioning has found of the servo, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct IdentifiedServo {
    /// a, b, Coulomb friction and load.
    pub parameters: ServoParameters,
    /// The delay from a command to its acceleration besides the hold's, s.
    pub delay: f64,
    /// Covariance of [a, b, c, τ, d] in this order, SI; zero for what is known.
    pub covariance: [[f64; 5]; 5],
    /// Standard deviation of what the model leaves unexplained of the position, rad; at least the
    /// encoder's.
    pub unexplained: f64,
}

impl IdentifiedServo {
    /// Places in the covariance.
    pub const A: usize = 0;
    /// Of b.
    pub const B: usize = 1;
    /// Of c.
    pub const COULOMB: usize = 2;
    /// Of τ.
    pub const DELAY: usize = 3;
    /// Of d.
    pub const LOAD: usize = 4;

    /// What a motion has found on its way, without errors.
    pub(super) fn of_crude<N: Number>(crude: &Crude<N>, units: &Units) -> Option<Self> {
        let acceleration = |value: N| value.to_f64() / units.acceleration();
        crude.is_known().then(|| Self {
            parameters: ServoParameters {
                a: crude.viscous.to_f64() / units.rate(),
                b: acceleration(crude.gain),
                coulomb: acceleration(crude.coulomb()),
                load: acceleration(crude.load()),
            },
            delay: 2.0 * units.sample_time(),
            covariance: [[0.0; 5]; 5],
            unexplained: units.position_unit(),
        })
    }

    /// [a, b, c, τ, d], SI.
    pub(crate) fn values(&self) -> [f64; 5] {
        let ServoParameters {
            a,
            b,
            coulomb,
            load,
        } = self.parameters;
        [a, b, coulomb, self.delay, load]
    }

    /// The standard error of an unknown by its place.
    #[must_use]
    pub fn standard_error(&self, place: usize) -> f64 {
        let variance = self.covariance.get(place).and_then(|row| row.get(place));
        libm::sqrt(variance.copied().unwrap_or(0.0).max(0.0))
    }
}
