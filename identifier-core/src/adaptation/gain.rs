use core::fmt::Debug;

use crate::constants::{Encode, encode};
use crate::linalg::{MatrixError, PositiveDefinite, dot};
use crate::number::Number;
use crate::unrolled::from_fn;

/// Γ in the hot path, as a type, so that a diagonal one costs P multiplications and not P².
pub trait Gain<N: Number, const P: usize>: Copy + Debug + PartialEq {
    /// Of a matrix in machine units; the entries of a frozen parameter are zero.
    ///
    /// # Errors
    /// If the matrix is not of this form.
    fn new(gamma: &PositiveDefinite<P>, frozen: [bool; P]) -> Result<Self, MatrixError>;

    /// Γ φ.
    fn times(&self, regressor: &[N; P]) -> [N; P];
}

/// Any symmetric positive definite Γ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FullGain<N, const P: usize>([[N; P]; P]);

encode! {
    [N: Encode, const P: usize] FullGain<N, P> as "FullGain" { 0 }
}

/// A diagonal Γ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiagonalGain<N, const P: usize>([N; P]);

encode! {
    [N: Encode, const P: usize] DiagonalGain<N, P> as "DiagonalGain" { 0 }
}

impl<N: Number, const P: usize> Gain<N, P> for FullGain<N, P> {
    fn new(gamma: &PositiveDefinite<P>, frozen: [bool; P]) -> Result<Self, MatrixError> {
        let entries = gamma.entries();
        Ok(Self(core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let moves = !(frozen[i] || frozen[j]);
                N::from_f64(if moves { entries[i][j] } else { 0.0 })
            })
        })))
    }

    #[inline]
    fn times(&self, regressor: &[N; P]) -> [N; P] {
        from_fn(N::ZERO, |i| dot(&self.0[i], regressor))
    }
}

impl<N: Number, const P: usize> Gain<N, P> for DiagonalGain<N, P> {
    fn new(gamma: &PositiveDefinite<P>, frozen: [bool; P]) -> Result<Self, MatrixError> {
        let entries = gamma.entries();
        for (row, values) in entries.iter().enumerate() {
            for (column, &value) in values.iter().enumerate() {
                if row != column && value != 0.0 {
                    return Err(MatrixError::NotDiagonal { row, column, value });
                }
            }
        }
        Ok(Self(core::array::from_fn(|i| {
            N::from_f64(if frozen[i] { 0.0 } else { entries[i][i] })
        })))
    }

    #[inline]
    fn times(&self, regressor: &[N; P]) -> [N; P] {
        from_fn(N::ZERO, |i| self.0[i] * regressor[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_agree_on_a_diagonal_matrix_and_only_one_takes_another() {
        let diagonal = PositiveDefinite::diagonal([2.0, 3.0, 0.5]).expect("positive");
        let frozen = [false, true, false];
        let phi = [0.25, 4.0, 8.0];
        let full = FullGain::<f64, 3>::new(&diagonal, frozen).expect("any form");
        let lean = DiagonalGain::<f64, 3>::new(&diagonal, frozen).expect("diagonal");
        let expected = [0.5, 0.0, 4.0].map(f64::to_bits);
        assert_eq!(full.times(&phi).map(f64::to_bits), expected);
        assert_eq!(lean.times(&phi).map(f64::to_bits), expected);

        let coupled = PositiveDefinite::new([[2.0, 0.5], [0.5, 1.0]]).expect("definite");
        let refused = DiagonalGain::<f64, 2>::new(&coupled, [false; 2]);
        let expected = MatrixError::NotDiagonal {
            row: 0,
            column: 1,
            value: 0.5,
        };
        assert_eq!(refused, Err(expected));
    }
}
