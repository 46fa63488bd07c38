use crate::number::Number;

/// A covariance P × P kept as L D Lᵀ, L unit lower triangular and D diagonal, updated one column
/// at a time.
///
/// Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, chapter V, with the
/// parameters in reverse order, so that the variance of the *last* parameter alone can be raised
/// by raising the last entry of D.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Factors<N, const P: usize> {
    /// L below its diagonal, row by row; the first P (P − 1)/2 are used.
    lower: [N; 6],
    /// D.
    diagonal: [N; P],
}

/// The place of entry (i, j), j < i < 4, of L.
const fn at(i: usize, j: usize) -> usize {
    i * (i - 1) / 2 + j
}

/// The measurement that is being processed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measurement<N, const P: usize> {
    /// Lᵀφ; from the last entry to the first the gain K times `variance` takes its place, complete
    /// once every column was done.
    pub(super) gain: [N; P],
    /// φᵀPφ until the measurement is weighed; then the noise variance, and with every column more of
    /// their sum.
    pub(super) variance: N,
    /// The reciprocal of `variance` once the measurement is weighed.
    pub(super) precision: N,
}

impl<N: Number, const P: usize> Measurement<N, P> {
    pub(super) const NONE: Self = Self {
        gain: [N::ZERO; P],
        variance: N::ZERO,
        precision: N::ZERO,
    };

    /// Sets the noise variance, above zero, before the first column.
    #[inline]
    pub(super) fn weigh(&mut self, noise: N) {
        self.variance = noise;
        self.precision = noise.reciprocal();
    }
}

impl<N: Number, const P: usize> Factors<N, P> {
    /// The factors of a symmetric positive semidefinite matrix. A direction in which rounding makes it
    /// negative counts as known.
    pub(crate) fn of(matrix: &[[f64; P]; P]) -> Self {
        let mut left = *matrix;
        let mut lower = [N::ZERO; 6];
        let mut diagonal = [N::ZERO; P];
        for j in 0..P {
            let pivot = left[j][j].max(0.0);
            diagonal[j] = N::from_f64(pivot);
            if pivot > 0.0 {
                for i in j + 1..P {
                    let entry = left[i][j] / pivot;
                    lower[at(i, j)] = N::from_f64(entry);
                    for k in j + 1..=i {
                        left[i][k] -= entry * left[k][j];
                    }
                }
            }
        }
        Self { lower, diagonal }
    }

    /// Begins the update for a measurement with the regressor φ.
    #[inline]
    pub(super) fn project(&self, regressor: &[N; P]) -> Measurement<N, P> {
        let mut measurement = Measurement::NONE;
        for j in 0..P {
            let mut sum = regressor[j];
            for i in j + 1..P {
                sum += self.lower[at(i, j)] * regressor[i];
            }
            measurement.gain[j] = sum;
            measurement.variance += sum * sum * self.diagonal[j];
        }
        measurement
    }

    /// Updates column J, if there is one; the columns come from the last to the first.
    #[inline]
    pub(super) fn update<const J: usize>(&mut self, measurement: &mut Measurement<N, P>) {
        if J >= P {
            return;
        }
        let before = measurement.variance;
        let projected = measurement.gain[J];
        let correction = projected * measurement.precision;
        let weighted = self.diagonal[J] * projected;
        let variance = before + projected * weighted;
        let precision = variance.reciprocal();
        measurement.variance = variance;
        measurement.precision = precision;
        self.diagonal[J] = self.diagonal[J] * before * precision;
        for i in J + 1..P {
            let entry = self.lower[at(i, J)];
            self.lower[at(i, J)] = entry - measurement.gain[i] * correction;
            measurement.gain[i] += entry * weighted;
        }
        measurement.gain[J] = weighted;
    }

    /// Multiplies the covariance by a factor, but no entry of D further than `most`.
    #[inline]
    pub(super) fn grow(&mut self, factor: N, most: &[N; P]) {
        for i in 0..P {
            let grown = self.diagonal[i] * factor;
            self.diagonal[i] = if grown < most[i] { grown } else { most[i] };
        }
    }

    /// Raises the variance of the last parameter.
    #[inline]
    pub(super) fn raise_last(&mut self, variance: N) {
        self.raise(P - 1, variance);
    }

    /// Raises entry i of D: the variance of parameter i, and of those after it along L's column.
    pub(super) fn raise(&mut self, i: usize, variance: N) {
        if let Some(entry) = self.diagonal.get_mut(i) {
            *entry += variance;
        }
    }

    /// Column i of P.
    pub(super) fn column(&self, i: usize) -> [N; P] {
        let mut column = [N::ZERO; P];
        for k in 0..P {
            // L's entry (i, k): zero above its diagonal, one on it.
            let weight = if k < i {
                self.lower.get(at(i, k)).copied().unwrap_or(N::ZERO) * self.diagonal[k]
            } else if k == i {
                self.diagonal[k]
            } else {
                N::ZERO
            };
            column[k] += weight;
            for j in k + 1..P {
                column[j] += self.lower[at(j, k)] * weight;
            }
        }
        column
    }

    /// The variance of parameter i.
    pub(super) fn variance(&self, i: usize) -> N {
        let mut sum = self.diagonal[i];
        for j in 0..i {
            sum += self.lower[at(i, j)] * self.lower[at(i, j)] * self.diagonal[j];
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_the_textbook_update(
            regressors in prop::collection::vec(prop::array::uniform3(-2.0_f64..2.0), 1..30),
            noise in 0.1_f64..2.0,
        ) {
            let mut plain = [[1.0, 0.3, 0.1], [0.3, 2.0, -0.2], [0.1, -0.2, 3.0]];
            let mut factors = Factors::<f64, 3>::of(&plain);
            for phi in regressors {
                let p_phi: [f64; 3] =
                    core::array::from_fn(|i| (0..3).map(|j| plain[i][j] * phi[j]).sum());
                let s: f64 = noise + (0..3).map(|i| phi[i] * p_phi[i]).sum::<f64>();
                let mut measurement = factors.project(&phi);
                prop_assert!((measurement.variance + noise - s).abs() < 1e-9);
                measurement.weigh(noise);
                factors.update::<3>(&mut measurement);
                factors.update::<2>(&mut measurement);
                factors.update::<1>(&mut measurement);
                factors.update::<0>(&mut measurement);
                for i in 0..3 {
                    for j in 0..3 {
                        plain[i][j] -= p_phi[i] * p_phi[j] / s;
                    }
                }
                for i in 0..3 {
                    let gain = measurement.gain[i] * measurement.precision;
                    prop_assert!((gain - p_phi[i] / s).abs() < 1e-9);
                    prop_assert!((factors.variance(i) - plain[i][i]).abs() < 1e-9);
                    for j in 0..3 {
                        prop_assert!((factors.column(i)[j] - plain[i][j]).abs() < 1e-9);
                    }
                }
            }
            factors.raise_last(1.5);
            prop_assert!((factors.variance(2) - plain[2][2] - 1.5).abs() < 1e-9);
            prop_assert!((factors.variance(1) - plain[1][1]).abs() < 1e-9);
        }
    }
}
