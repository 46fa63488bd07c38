use super::TuningError;
use crate::model::ZeroOrderHoldStep;
use crate::parameters::IdentifiedServo;

/// A servo that the identified one may be, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PossibleServo {
    /// Viscous friction over inertia, 1/s.
    pub a: f64,
    /// Gain over inertia, rad/s² per command unit.
    pub b: f64,
    /// From a reading to the acceleration of its command, besides the hold's, s.
    pub delay: f64,
}

/// The identified servo, first, and the corners of the ellipsoid of its a, b and τ.
///
/// The corners lie at [`STANDARD_ERRORS`](IdentifiedServo::STANDARD_ERRORS) to both sides along the columns of the
/// covariance's Cholesky factor. Each direction keeps the unknowns that earlier columns fix. So correlated a and b move
/// together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PossibleServos {
    all: [PossibleServo; Self::COUNT],
}

impl PossibleServos {
    /// The servo itself and two corners for each of three directions.
    pub(super) const COUNT: usize = 7;

    /// The servos for a delay besides the identified one.
    pub(super) fn new(
        servo: &IdentifiedServo,
        further_delay: f64,
        sample_time: f64,
    ) -> Result<Self, TuningError> {
        let identified = PossibleServo {
            a: servo.parameters.a,
            b: servo.parameters.b,
            delay: servo.delay,
        };
        let factor = cholesky(&servo.covariance).ok_or(TuningError::NotKnown)?;
        let corner = |i: usize| -> Option<PossibleServo> {
            let (column, sign) = match i.checked_sub(1) {
                None => (0, 0.0),
                Some(side) => (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 }),
            };
            let far = |row: &[f64; 3]| {
                let length = row.get(column).copied().unwrap_or(0.0);
                sign * IdentifiedServo::STANDARD_ERRORS * length
            };
            let [a, b, delay] = &factor;
            let corner = PossibleServo {
                a: (identified.a + far(a)).max(0.0),
                b: identified.b + far(b),
                delay: (identified.delay + far(delay)).max(0.0) + further_delay,
            };
            corner.is_tunable(sample_time).then_some(corner)
        };
        let mut all = [identified; Self::COUNT];
        for (i, servo) in all.iter_mut().enumerate() {
            *servo = corner(i).ok_or(TuningError::NotKnown)?;
        }
        Ok(Self { all })
    }

    /// The identified servo.
    pub(super) fn identified(&self) -> PossibleServo {
        let [identified, ..] = self.all;
        identified
    }

    /// By its place, the identified one at zero.
    pub(super) fn get(&self, place: usize) -> Option<&PossibleServo> {
        self.all.get(place)
    }

    /// All, the identified one first.
    pub(super) fn iter(&self) -> core::slice::Iter<'_, PossibleServo> {
        self.all.iter()
    }

    /// The least viscous friction that one of them has, 1/s.
    pub(super) fn least_friction(&self) -> f64 {
        let all = self.iter();
        all.fold(f64::INFINITY, |least, servo| least.min(servo.a))
    }
}

impl PossibleServo {
    /// The longest delay that is computed with, samples.
    const MAX_DELAY: f64 = 1000.0;

    fn is_tunable(&self, sample_time: f64) -> bool {
        let rates = 0.0..=ZeroOrderHoldStep::<f64>::LARGEST_RATE;
        let delays = 0.0..=Self::MAX_DELAY;
        rates.contains(&(self.a * sample_time))
            && delays.contains(&(self.delay / sample_time))
            && self.b > 0.0
            && self.b.is_finite()
    }
}

/// The lower Cholesky factor of the covariance of [a, b, τ]; unknowns without error have zeros. None if
/// it is no covariance.
fn cholesky(covariance: &[[f64; 5]; 5]) -> Option<[[f64; 3]; 3]> {
    /// Rounding error of a variance that is zero, relative to its sum.
    const CORNER_TOLERANCE: f64 = 1e-9;
    const A: usize = IdentifiedServo::A;
    const B: usize = IdentifiedServo::B;
    const DELAY: usize = IdentifiedServo::DELAY;
    let rows = [covariance[A], covariance[B], covariance[DELAY]];
    let covariance = rows.map(|row| [row[A], row[B], row[DELAY]]);
    let mut factor = [[0.0_f64; 3]; 3];
    for column in 0..3 {
        let pivots = factor[column];
        let earlier = |row: &[f64; 3]| {
            let entries = row.iter().zip(&pivots).take(column);
            entries.fold(0.0, |sum, (own, pivot)| sum + own * pivot)
        };
        let variance = covariance[column][column];
        let left = variance - earlier(&pivots);
        let is_covariance = variance.is_finite() && left >= -CORNER_TOLERANCE * variance;
        if !is_covariance {
            return None;
        }
        if left <= CORNER_TOLERANCE * variance {
            continue;
        }
        let length = libm::sqrt(left);
        for row in column..3 {
            let value = (covariance[row][column] - earlier(&factor[row])) / length;
            if !value.is_finite() {
                return None;
            }
            factor[row][column] = value;
        }
    }
    Some(factor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::ServoParameters;

    fn servo(covariance: [[f64; 5]; 5]) -> IdentifiedServo {
        IdentifiedServo {
            parameters: ServoParameters::new(3.0, 200.0, 1.0, 0.0),
            delay: 1e-3,
            covariance,
            unexplained: 0.0,
        }
    }

    /// A covariance F Fᵀ of [a, b, c, τ, d].
    fn covariance() -> [[f64; 5]; 5] {
        let factor = [
            [0.5, 0.0, 0.0],
            [4.0, 2.0, 0.0],
            [0.0; 3],
            [1e-5, 2e-5, 3e-5],
            [0.0; 3],
        ];
        core::array::from_fn(|i| {
            core::array::from_fn(|j| (0..3).map(|k| factor[i][k] * factor[j][k]).sum())
        })
    }

    #[test]
    fn every_corner_lies_on_the_ellipsoid() {
        let servos = PossibleServos::new(&servo(covariance()), 0.0, 1e-3).expect("known");
        let first = servos.identified();
        // Solved by forward substitution with the factor from above.
        for place in 1..PossibleServos::COUNT {
            let corner = servos.get(place).expect("there");
            let along_a = (corner.a - first.a) / 0.5;
            let along_b = (corner.b - first.b - 4.0 * along_a) / 2.0;
            let along_delay = (corner.delay - first.delay - 1e-5 * along_a - 2e-5 * along_b) / 3e-5;
            let distance = along_a.hypot(along_b).hypot(along_delay);
            assert!((distance - 3.0).abs() < 1e-6, "{place}: {distance}");
        }
        assert!((servos.least_friction() - 1.5).abs() < 1e-9);
    }

    #[test]
    fn known_parameters_have_no_corners_and_unknown_ones_are_refused() {
        let known = PossibleServos::new(&servo([[0.0; 5]; 5]), 5e-4, 1e-3).expect("known");
        for place in 0..PossibleServos::COUNT {
            assert_eq!(known.get(place), Some(&known.identified()));
        }
        assert!((known.identified().delay - 1.5e-3).abs() < 1e-15);
        let mut unknown = [[0.0; 5]; 5];
        unknown[1][1] = 70.0 * 70.0;
        for bad in [70.0 * 70.0, -1.0, f64::NAN, f64::INFINITY] {
            unknown[1][1] = bad;
            let refused = PossibleServos::new(&servo(unknown), 0.0, 1e-3);
            assert_eq!(refused, Err(TuningError::NotKnown), "{bad}");
        }
    }
}
