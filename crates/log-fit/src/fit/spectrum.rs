//! Symmetric matrices by their eigenvalues.

/// The most unknowns of a fit.
pub const MAX_UNKNOWNS: usize = 16;

/// A square matrix of at most [`MAX_UNKNOWNS`] rows; only the first rows and columns count.
pub type Matrix = [[f64; MAX_UNKNOWNS]; MAX_UNKNOWNS];

/// A vector of unknowns.
pub type Vector = [f64; MAX_UNKNOWNS];

/// The eigenvalues and eigenvectors of a positive semidefinite matrix that is scaled to a unit diagonal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spectrum {
    rows: usize,
    values: Vector,
    /// Eigenvectors in columns.
    vectors: Matrix,
    scale: Vector,
}

impl Spectrum {
    /// Eigenvalues below this part of the largest are rounding.
    const EIGENVALUE_TOLERANCE: f64 = 1e-13;

    /// The spectrum of the first rows of a matrix, by Jacobi's rotations (Golub and Van Loan, Matrix Computations, 4th
    /// edition 2013, section 8.5).
    #[must_use]
    pub fn new(matrix: &Matrix, rows: usize) -> Self {
        /// Sweeps after which every matrix of this size is diagonal to rounding.
        const SWEEPS: usize = 12;
        let mut scale = [0.0; MAX_UNKNOWNS];
        for i in 0..rows {
            let diagonal = matrix[i][i];
            if diagonal > 0.0 && diagonal.is_finite() {
                scale[i] = 1.0 / libm::sqrt(diagonal);
            }
        }
        let mut rest = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
        let mut vectors = rest;
        for i in 0..rows {
            vectors[i][i] = 1.0;
            for j in 0..rows {
                rest[i][j] = matrix[i][j] * scale[i] * scale[j];
            }
            rest[i][i] = if scale[i] > 0.0 { 1.0 } else { 0.0 };
        }
        for _ in 0..SWEEPS {
            let mut off = 0.0;
            for p in 0..rows {
                for q in p + 1..rows {
                    off += rest[p][q] * rest[p][q];
                    rotate(&mut rest, &mut vectors, rows, p, q);
                }
            }
            if off < 1e-26 {
                break;
            }
        }
        let mut values = [0.0; MAX_UNKNOWNS];
        for (i, value) in values.iter_mut().enumerate().take(rows) {
            *value = rest[i][i].max(0.0);
        }
        Self {
            rows,
            values,
            vectors,
            scale,
        }
    }

    fn largest(&self) -> f64 {
        self.values.iter().fold(0.0, |most, &value| most.max(value))
    }

    /// The largest eigenvalue over the smallest.
    #[must_use]
    pub fn condition(&self) -> f64 {
        let values = &self.values[..self.rows];
        let least = values
            .iter()
            .fold(f64::INFINITY, |least, &value| least.min(value));
        self.largest() / least.max(f64::MIN_POSITIVE)
    }

    /// The solution of (A + λ diag A) x = y. Eigenvalues at the rounding level are set to the largest that rounding can
    /// produce. A pseudo-inverse would call a direction certain that the data do not determine.
    #[must_use]
    pub fn solve(&self, right: &Vector, damping: f64) -> Vector {
        let least = Self::EIGENVALUE_TOLERANCE * self.largest();
        let mut solution = [0.0; MAX_UNKNOWNS];
        for k in 0..self.rows {
            let along: f64 = (0..self.rows)
                .map(|i| self.vectors[i][k] * self.scale[i] * right[i])
                .sum();
            let multiple = along / (self.values[k].max(least) + damping).max(f64::MIN_POSITIVE);
            for (i, entry) in solution.iter_mut().enumerate().take(self.rows) {
                *entry += multiple * self.vectors[i][k] * self.scale[i];
            }
        }
        solution
    }

    /// The inverse.
    #[must_use]
    pub fn inverse(&self) -> Matrix {
        let mut inverse = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
        for (i, row) in inverse.iter_mut().enumerate().take(self.rows) {
            let mut unit = [0.0; MAX_UNKNOWNS];
            unit[i] = 1.0;
            *row = self.solve(&unit, 0.0);
        }
        inverse
    }
}

/// Makes the entry at p and q zero.
fn rotate(matrix: &mut Matrix, vectors: &mut Matrix, rows: usize, p: usize, q: usize) {
    let off = matrix[p][q];
    if off == 0.0 {
        return;
    }
    let ratio = (matrix[q][q] - matrix[p][p]) / (2.0 * off);
    let tangent = ratio.signum() / (ratio.abs() + libm::sqrt(1.0 + ratio * ratio));
    let cosine = 1.0 / libm::sqrt(1.0 + tangent * tangent);
    let sine = tangent * cosine;
    for row in matrix.iter_mut().take(rows) {
        (row[p], row[q]) = (
            cosine * row[p] - sine * row[q],
            sine * row[p] + cosine * row[q],
        );
    }
    for k in 0..rows {
        (matrix[p][k], matrix[q][k]) = (
            cosine * matrix[p][k] - sine * matrix[q][k],
            sine * matrix[p][k] + cosine * matrix[q][k],
        );
    }
    for row in vectors.iter_mut().take(rows) {
        (row[p], row[q]) = (
            cosine * row[p] - sine * row[q],
            sine * row[p] + cosine * row[q],
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_solves_and_inverts_what_is_regular_and_bounds_what_is_not() {
        let mut matrix = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
        let rows = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 9e4]];
        for (row, values) in matrix.iter_mut().zip(rows) {
            row[..3].copy_from_slice(&values);
        }
        let spectrum = Spectrum::new(&matrix, 3);
        let inverse = spectrum.inverse();
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| rows[i][k] * inverse[k][j]).sum();
                let expected = f64::from(u8::from(i == j));
                assert!((product - expected).abs() < 1e-9, "{i} {j} {product}");
            }
        }
        // Two unknowns that only their sum is known of.
        let mut ridge = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
        for i in 0..2 {
            for j in 0..2 {
                ridge[i][j] = 1.0;
            }
        }
        let spectrum = Spectrum::new(&ridge, 2);
        assert!(spectrum.condition() > 1e12);
        let inverse = spectrum.inverse();
        assert!(inverse[0][0] > 1e11);
        let sum = inverse[0][0] + inverse[0][1] + inverse[1][0] + inverse[1][1];
        assert!(sum.abs() < 10.0, "{sum}");
    }
}
