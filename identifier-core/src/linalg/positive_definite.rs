use core::fmt;

/// A symmetric positive definite matrix, P × P, row by row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PositiveDefinite<const P: usize>([[f64; P]; P]);

/// Why a matrix is not symmetric positive definite.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum MatrixError {
    /// An entry is NaN or infinite.
    NotFinite {
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// An entry differs from its mirror image.
    NotSymmetric {
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The entry.
        value: f64,
        /// The entry across the diagonal.
        mirrored: f64,
    },
    /// An entry off the diagonal is not zero where a diagonal matrix is required.
    NotDiagonal {
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// A pivot of the Cholesky factorisation is not positive.
    NotPositiveDefinite {
        /// Row of the pivot, from 0.
        row: usize,
        /// The pivot: the rest of the diagonal entry once the rows before are eliminated.
        pivot: f64,
    },
}

impl fmt::Display for MatrixError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotFinite { row, column, value } => write!(
                f,
                "entry [{row}][{column}] = {value} is not allowed: it must be any finite number"
            ),
            Self::NotSymmetric {
                row,
                column,
                value,
                mirrored,
            } => write!(
                f,
                "the matrix is not symmetric: entry [{row}][{column}] = {value}, but \
                 [{column}][{row}] = {mirrored}"
            ),
            Self::NotDiagonal { row, column, value } => write!(
                f,
                "entry [{row}][{column}] = {value} is not allowed: the matrix must be diagonal"
            ),
            Self::NotPositiveDefinite { row, pivot } => write!(
                f,
                "the matrix is not positive definite: pivot {row} is {pivot}, it must be above 0 \
                 (raise diagonal entry {row} or lower its off-diagonal entries)"
            ),
        }
    }
}

impl core::error::Error for MatrixError {}

impl<const P: usize> PositiveDefinite<P> {
    /// A full matrix.
    ///
    /// # Errors
    /// [`MatrixError`] names the entry or pivot at fault. Entries must be exactly symmetric.
    pub(crate) fn new(entries: [[f64; P]; P]) -> Result<Self, MatrixError> {
        for row in 0..P {
            for column in 0..P {
                let value = entries[row][column];
                if !value.is_finite() {
                    return Err(MatrixError::NotFinite { row, column, value });
                }
                let mirrored = entries[column][row];
                if column < row && value.to_bits() != mirrored.to_bits() {
                    return Err(MatrixError::NotSymmetric {
                        row,
                        column,
                        value,
                        mirrored,
                    });
                }
            }
        }
        let mut remainder = entries;
        for k in 0..P {
            let pivot = remainder[k][k];
            if pivot.is_nan() || pivot <= 0.0 {
                return Err(MatrixError::NotPositiveDefinite { row: k, pivot });
            }
            for row in k + 1..P {
                let factor = remainder[row][k] / pivot;
                for column in k + 1..P {
                    remainder[row][column] -= factor * remainder[k][column];
                }
            }
        }
        Ok(Self(entries))
    }

    /// A diagonal matrix.
    ///
    /// # Errors
    /// Every entry must be positive and finite.
    pub(crate) fn diagonal(diagonal: [f64; P]) -> Result<Self, MatrixError> {
        let mut entries = [[0.0; P]; P];
        for (i, (row, value)) in entries.iter_mut().zip(diagonal).enumerate() {
            if let Some(entry) = row.get_mut(i) {
                *entry = value;
            }
        }
        Self::new(entries)
    }

    /// # Errors
    /// The first entry off the diagonal that is not zero.
    pub(crate) fn check_diagonal(&self) -> Result<(), MatrixError> {
        for (row, values) in self.0.iter().enumerate() {
            for (column, &value) in values.iter().enumerate() {
                if row != column && value != 0.0 {
                    return Err(MatrixError::NotDiagonal { row, column, value });
                }
            }
        }
        Ok(())
    }

    /// S M S with S = diag(`scale`): the matrix in other units.
    ///
    /// # Errors
    /// If the scaling takes an entry out of the range of finite numbers.
    pub(crate) fn scaled(&self, scale: [f64; P]) -> Result<Self, MatrixError> {
        Self::new(core::array::from_fn(|row| {
            core::array::from_fn(|column| self.0[row][column] * (scale[row] * scale[column]))
        }))
    }

    /// The entries, row by row.
    #[must_use]
    pub(crate) fn entries(&self) -> &[[f64; P]; P] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn refusals_name_the_entry() {
        let place = |built| match built {
            Err(MatrixError::NotSymmetric { row, column, .. }) => ("asymmetric", row, column),
            Err(MatrixError::NotPositiveDefinite { row, .. }) => ("indefinite", row, row),
            Err(MatrixError::NotFinite { row, column, .. }) => ("not finite", row, column),
            other => panic!("{other:?}"),
        };
        let (full, diagonal) = (PositiveDefinite::new, PositiveDefinite::diagonal);
        assert_eq!(place(full([[1.0, 0.5], [0.4, 1.0]])), ("asymmetric", 1, 0));
        assert_eq!(place(full([[1.0, 2.0], [2.0, 1.0]])), ("indefinite", 1, 1));
        assert_eq!(place(diagonal([1.0, f64::NAN])), ("not finite", 1, 1));
        assert_eq!(place(diagonal([0.0, 1.0])), ("indefinite", 0, 0));
    }

    proptest! {
        #[test]
        fn gram_matrices_are_accepted_and_their_negatives_refused(rows in prop::array::uniform3(prop::array::uniform3(-1.0_f64..1.0))) {
            let mut gram = [[0.0; 3]; 3];
            for i in 0..3 {
                for j in 0..=i {
                    let dot: f64 = (0..3).map(|k| rows[i][k] * rows[j][k]).sum();
                    let entry = dot + if i == j { 1e-3 } else { 0.0 };
                    gram[i][j] = entry;
                    gram[j][i] = entry;
                }
            }
            prop_assert!(PositiveDefinite::new(gram).is_ok());
            prop_assert!(PositiveDefinite::new(gram.map(|row| row.map(|x| -x))).is_err());
        }
    }
}
