use super::super::IdentifiedServo;
use super::{DELAY, POSITION, UNKNOWNS, VELOCITY};
use crate::fit::ROUNDING;
use crate::linalg::NormalEquations;
use crate::number::Number;

/// The weights of position and velocity with which a record begins, for errors of the encoder's rounding:
/// the servo is where its count begins, with a velocity of a standard deviation (counts per sample).
pub(super) fn at_first(velocity: f64) -> [(usize, f64); 2] {
    [(POSITION, 1.0), (VELOCITY, libm::sqrt(ROUNDING) / velocity)]
}

/// Knowledge before a fit: rows of equations for errors of the encoder's rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ServoPrior<N> {
    rows: [[N; UNKNOWNS]; UNKNOWNS],
    expected: [N; UNKNOWNS],
}

impl<N: Number> ServoPrior<N> {
    /// A delay (expected, standard deviation; samples), and a servo that is where its count begins, with a
    /// velocity of that standard deviation (counts per sample).
    pub(super) fn vague(delay: [f64; 2], velocity: f64) -> Self {
        let mut prior = Self {
            rows: [[N::ZERO; UNKNOWNS]; UNKNOWNS],
            expected: [N::ZERO; UNKNOWNS],
        };
        let rounding = libm::sqrt(ROUNDING);
        prior.expected[DELAY] = N::from_f64(delay[0]);
        prior.rows[DELAY][DELAY] = N::from_f64(rounding / delay[1]);
        for (place, weight) in at_first(velocity) {
            let row = prior.rows.get_mut(place);
            if let Some(own) = row.and_then(|row| row.get_mut(place)) {
                *own = N::from_f64(weight);
            }
        }
        prior
    }

    /// And a servo that is known, in the units of a piece: with twice its standard
    /// errors, as a servo may change.
    pub(super) fn knowing(mut self, servo: &IdentifiedServo, scale: &[f64; 5]) -> Self {
        const CAUTION: f64 = 2.0;
        let weight = libm::sqrt(ROUNDING) / CAUTION;
        let values = servo.values();
        let lower = inverse_factor(&servo.covariance);
        for i in 0..5 {
            self.expected[i] = N::from_f64(values[i] * scale[i]);
            for j in 0..5 {
                self.rows[i][j] = N::from_f64(weight * lower[i][j] / scale[j]);
            }
        }
        self
    }

    /// Its contribution to the equations of a pass at these unknowns.
    pub(super) fn add_to(
        &self,
        equations: &mut NormalEquations<N, UNKNOWNS>,
        unknowns: &[N; UNKNOWNS],
    ) {
        for row in &self.rows {
            let mut error = N::ZERO;
            for i in 0..UNKNOWNS {
                error += row[i] * (self.expected[i] - unknowns[i]);
            }
            equations.add(row, error);
        }
    }
}

/// G⁻¹ of a covariance G Gᵀ, lower triangular. A value without variance gets no weight.
fn inverse_factor(covariance: &[[f64; 5]; 5]) -> [[f64; 5]; 5] {
    /// The part of a variance below which it is explained by the others.
    const MIN_UNEXPLAINED_SHARE: f64 = 1e-9;
    let mut factor = [[0.0; 5]; 5];
    let mut inverse = [[0.0; 5]; 5];
    for i in 0..5 {
        if covariance[i][i] <= 0.0 {
            continue;
        }
        for j in 0..=i {
            let mut sum = covariance[i][j];
            for (own, before) in factor[i].iter().zip(&factor[j]).take(j) {
                sum -= own * before;
            }
            if i == j {
                factor[i][i] = libm::sqrt(sum.max(MIN_UNEXPLAINED_SHARE * covariance[i][i]));
            } else if factor[j][j] > 0.0 {
                factor[i][j] = sum / factor[j][j];
            }
        }
        inverse[i][i] = 1.0 / factor[i][i];
        for j in 0..i {
            // Without an index, whose check not every chip's code would be rid of.
            let column = |row: &[f64; 5]| row.get(j).copied().unwrap_or(0.0);
            let rows = factor[i].iter().zip(&inverse).take(i).skip(j);
            let sum: f64 = rows.map(|(entry, row)| entry * column(row)).sum();
            inverse[i][j] = -sum / factor[i][i];
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::inverse_factor;

    #[test]
    fn the_factor_makes_a_covariance_white() {
        let root = [
            [2.0, 0.0, 0.0, 0.0, 0.0],
            [1.0, 3.0, 0.0, 0.0, 0.0],
            [0.5, -1.0, 0.2, 0.0, 0.0],
            [0.0, 0.3, 0.1, 1.0, 0.0],
            [4.0, -2.0, 0.0, 0.5, 0.1],
        ];
        let covariance: [[f64; 5]; 5] = core::array::from_fn(|i| {
            core::array::from_fn(|j| (0..5).map(|k| root[i][k] * root[j][k]).sum())
        });
        let inverse = inverse_factor(&covariance);
        for i in 0..5 {
            for j in 0..5 {
                let product: f64 = (0..5).map(|k| inverse[i][k] * root[k][j]).sum();
                let one = if i == j { 1.0 } else { 0.0 };
                assert!((product - one).abs() < 1e-9, "{i} {j}: {product}");
            }
        }
    }
}
