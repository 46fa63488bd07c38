use crate::constants::{Encode, encode};
use crate::linalg::{PositiveDefinite, dot};
use crate::number::Number;
use crate::unrolled::from_fn;

/// Γ in the hot path: any symmetric positive definite matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gain<N, const P: usize>([[N; P]; P]);

encode! {
    [N: Encode, const P: usize] Gain<N, P> as "Gain" { 0 }
}

impl<N: Number, const P: usize> Gain<N, P> {
    /// Converts a matrix in machine units. The entries of a frozen parameter are zero.
    pub(crate) fn new(gamma: &PositiveDefinite<P>, frozen: [bool; P]) -> Self {
        let entries = gamma.entries();
        Self(core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let moves = !(frozen[i] || frozen[j]);
                N::from_f64(if moves { entries[i][j] } else { 0.0 })
            })
        }))
    }

    /// Γ φ.
    #[inline]
    pub(crate) fn times(&self, regressor: &[N; P]) -> [N; P] {
        from_fn(N::ZERO, |i| dot(&self.0[i], regressor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frozen_parameter_moves_nothing_and_is_not_moved() {
        let gamma = [[2.0, 0.5, 0.1], [0.5, 3.0, 0.2], [0.1, 0.2, 0.5]];
        let gamma = PositiveDefinite::new(gamma).expect("definite");
        let gain = Gain::<f64, 3>::new(&gamma, [false, true, false]);
        let expected = [0.5 + 0.8, 0.0, 0.025 + 4.0].map(f64::to_bits);
        assert_eq!(gain.times(&[0.25, 4.0, 8.0]).map(f64::to_bits), expected);
    }
}
