use crate::constants::{Encode, encode};
use crate::number::Number;
use crate::unrolled::each;

/// A covariance P × P kept as L D Lᵀ, updated one column at a time. L is unit lower triangular, D diagonal.
///
/// Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, chapter V, with the parameters in reverse
/// order. So raising the last entry of D raises only the variance of the *last* parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Factors<N, L, const P: usize> {
    /// L below its diagonal, row by row: P (P − 1)/2 entries.
    lower: L,
    /// D.
    diagonal: [N; P],
}

encode! {
    [N: Encode, L: Encode, const P: usize] Factors<N, L, P> as "Factors" { lower, diagonal }
}

/// Room for the lower triangle of a matrix.
pub trait Lower<N>: Copy + core::fmt::Debug + PartialEq + AsRef<[N]> + AsMut<[N]> {
    /// Filled with zeros.
    const ZERO: Self;
}

impl<N: Number, const K: usize> Lower<N> for [N; K] {
    const ZERO: Self = [N::ZERO; K];
}

/// The place of entry (i, j), j < i < P, of L.
const fn at(i: usize, j: usize) -> usize {
    i * (i - 1) / 2 + j
}

/// The measurement that is being processed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measurement<N, const P: usize> {
    /// Lᵀφ. The gain K times `variance` replaces it from the last entry to the first; it is complete after every
    /// column.
    pub(crate) gain: [N; P],
    /// φᵀPφ until the measurement is weighed; then the noise variance, and with every column more of
    /// their sum.
    pub(crate) variance: N,
    /// The reciprocal of `variance` once the measurement is weighed.
    pub(crate) precision: N,
}

impl<N: Number, const P: usize> Measurement<N, P> {
    pub(crate) const NONE: Self = Self {
        gain: [N::ZERO; P],
        variance: N::ZERO,
        precision: N::ZERO,
    };

    /// Sets the noise variance, above zero, before the first column.
    #[inline]
    pub(crate) fn weigh(&mut self, noise: N) {
        self.variance = noise;
        self.precision = noise.reciprocal();
    }
}

impl<N: Number, L: Lower<N>, const P: usize> Factors<N, L, P> {
    const FITS: () = assert!(size_of::<L>() == P * (P - 1) / 2 * size_of::<N>());

    /// Those of a zero matrix: no uncertainty.
    pub(crate) const ZERO: Self = {
        let () = Self::FITS;
        Self {
            lower: L::ZERO,
            diagonal: [N::ZERO; P],
        }
    };

    /// Entry (i, j) of L, j < i.
    #[inline]
    fn entry(&self, i: usize, j: usize) -> N {
        let entry = self.lower.as_ref().get(at(i, j));
        entry.copied().unwrap_or(N::ZERO)
    }

    #[inline]
    fn set(&mut self, i: usize, j: usize, value: N) {
        if let Some(entry) = self.lower.as_mut().get_mut(at(i, j)) {
            *entry = value;
        }
    }

    /// The factors of a symmetric positive semidefinite matrix. A direction in which rounding makes it negative
    /// counts as one without uncertainty.
    pub(crate) fn from_matrix(matrix: &[[f64; P]; P]) -> Self {
        const { Self::FITS };
        let mut left = *matrix;
        let mut lower = L::ZERO;
        let mut diagonal = [N::ZERO; P];
        for j in 0..P {
            let pivot = left[j][j].max(0.0);
            diagonal[j] = N::from_f64(pivot);
            if pivot > 0.0 {
                for i in j + 1..P {
                    let entry = left[i][j] / pivot;
                    if let Some(place) = lower.as_mut().get_mut(at(i, j)) {
                        *place = N::from_f64(entry);
                    }
                    // Its column, not the row that it changes.
                    let column = left.map(|row| row.get(j).copied().unwrap_or(0.0));
                    for (own, &other) in left[i].iter_mut().zip(&column).take(i + 1).skip(j + 1) {
                        *own -= entry * other;
                    }
                }
            }
        }
        Self { lower, diagonal }
    }

    /// The factors of a covariance over more or fewer unknowns. `places` are the places of these unknowns in `other`,
    /// rising. An unknown without a place is exactly known. An unknown of `other` that has no place here must be so
    /// too.
    pub(crate) fn placed<K: Lower<N>, const Q: usize>(
        other: &Factors<N, K, Q>,
        places: &[Option<usize>; P],
    ) -> Self {
        const { Self::FITS };
        let mut placed = Self {
            lower: L::ZERO,
            diagonal: [N::ZERO; P],
        };
        each::<P>(|i| {
            let Some(row) = places[i] else { return };
            if let Some(variance) = other.diagonal.get(row) {
                placed.diagonal[i] = *variance;
            }
            each::<P>(|j| {
                if let Some(column) = places[j]
                    && j < i
                {
                    placed.set(i, j, other.entry(row, column));
                }
            });
        });
        placed
    }

    /// Begins the update for a measurement with the regressor φ.
    #[inline]
    pub(crate) fn project(&self, regressor: &[N; P]) -> Measurement<N, P> {
        let mut measurement = Measurement::NONE;
        each::<P>(|j| {
            let mut sum = regressor[j];
            each::<P>(|i| {
                if i > j {
                    sum += self.entry(i, j) * regressor[i];
                }
            });
            measurement.gain[j] = sum;
            measurement.variance += sum * sum * self.diagonal[j];
        });
        measurement
    }

    /// Updates the columns from `high` − 1 down to `low`; they come from the last to the first.
    #[inline]
    pub(crate) fn update(&mut self, measurement: &mut Measurement<N, P>, low: usize, high: usize) {
        // All columns are counted, so that the compiler sees constant indices.
        each::<P>(|i| {
            let j = P - 1 - i;
            if j >= low && j < high {
                self.update_column(measurement, j);
            }
        });
    }

    #[inline(always)]
    fn update_column(&mut self, measurement: &mut Measurement<N, P>, j: usize) {
        let before = measurement.variance;
        let projected = measurement.gain[j];
        let correction = projected * measurement.precision;
        let weighted = self.diagonal[j] * projected;
        let variance = before + projected * weighted;
        let precision = variance.reciprocal();
        measurement.variance = variance;
        measurement.precision = precision;
        self.diagonal[j] = self.diagonal[j] * before * precision;
        each::<P>(|i| {
            if i > j {
                let entry = self.entry(i, j);
                self.set(i, j, entry - measurement.gain[i] * correction);
                measurement.gain[i] += entry * weighted;
            }
        });
        measurement.gain[j] = weighted;
    }

    /// Multiplies the covariance by a factor, but no entry of D further than `most`.
    #[inline]
    pub(crate) fn grow(&mut self, factor: N, most: &[N; P]) {
        each::<P>(|i| {
            let grown = self.diagonal[i] * factor;
            self.diagonal[i] = if grown < most[i] { grown } else { most[i] };
        });
    }

    /// Raises the variance of the last parameter.
    #[inline]
    pub(crate) fn raise_last(&mut self, variance: N) {
        self.raise(P - 1, variance);
    }

    /// Raises entry i of D: the variance of parameter i, and of those after it along L's column.
    pub(crate) fn raise(&mut self, i: usize, variance: N) {
        if let Some(entry) = self.diagonal.get_mut(i) {
            *entry += variance;
        }
    }

    /// Makes a parameter that was known until now uncertain, independently of the others.
    pub(crate) fn release(&mut self, i: usize, variance: N) {
        for j in 0..i {
            self.set(i, j, N::ZERO);
        }
        for k in i + 1..P {
            self.set(k, i, N::ZERO);
        }
        if let Some(entry) = self.diagonal.get_mut(i) {
            *entry = variance;
        }
    }

    /// Column i of P.
    pub(crate) fn column(&self, i: usize) -> [N; P] {
        let mut column = [N::ZERO; P];
        each::<P>(|k| {
            // L's entry (i, k): zero above its diagonal, one on it.
            let weight = if k < i {
                self.entry(i, k) * self.diagonal[k]
            } else if k == i {
                self.diagonal[k]
            } else {
                N::ZERO
            };
            column[k] += weight;
            each::<P>(|j| {
                if j > k {
                    column[j] += self.entry(j, k) * weight;
                }
            });
        });
        column
    }

    /// The variance of parameter i.
    pub(crate) fn variance(&self, i: usize) -> N {
        let mut sum = self.diagonal[i];
        for j in 0..i {
            let entry = self.entry(i, j);
            sum += entry * entry * self.diagonal[j];
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
            let mut factors = Factors::<f64, [f64; 3], 3>::from_matrix(&plain);
            for phi in regressors {
                let p_phi: [f64; 3] =
                    core::array::from_fn(|i| (0..3).map(|j| plain[i][j] * phi[j]).sum());
                let s: f64 = noise + (0..3).map(|i| phi[i] * p_phi[i]).sum::<f64>();
                let mut measurement = factors.project(&phi);
                prop_assert!((measurement.variance + noise - s).abs() < 1e-9);
                measurement.weigh(noise);
                factors.update(&mut measurement, 1, 3);
                factors.update(&mut measurement, 0, 1);
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
