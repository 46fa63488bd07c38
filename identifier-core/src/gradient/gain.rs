use crate::constants::encode;
use crate::linalg::PositiveDefinite;
use crate::number::{Arithmetic, Encoded};
use crate::unrolled::{each, from_fn};

/// Γ in the hot path: any symmetric positive definite matrix, in fixed point a diagonal one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gain<N: Arithmetic, const P: usize> {
    entries: [[N::Factor; P]; P],
    is_diagonal: bool,
}

encode! {
    [N: Encoded, const P: usize] Gain<N, P> as "Gain" { entries, is_diagonal }
}

impl<N: Arithmetic, const P: usize> Gain<N, P> {
    /// Converts a matrix in machine units, for a regressor of these full scales and Γφ of those. The entries of a frozen
    /// parameter are zero.
    pub(crate) fn new(
        gamma: &PositiveDefinite<P>,
        frozen: [bool; P],
        from: [i32; P],
        to: [i32; P],
    ) -> Self {
        let entries = gamma.entries();
        let is_zero = |i: usize, j: usize| i == j || entries[i][j] == 0.0;
        Self {
            entries: core::array::from_fn(|i| {
                core::array::from_fn(|j| {
                    let moves = !(frozen[i] || frozen[j]);
                    N::factor(if moves { entries[i][j] } else { 0.0 }, from[j], to[i])
                })
            }),
            is_diagonal: N::IS_FIXED || (0..P).all(|i| (0..P).all(|j| is_zero(i, j))),
        }
    }

    /// True if a full-scale entry of the regressor moves its own entry of Γφ by 2^bits last bits.
    #[inline(always)]
    pub(crate) fn is_felt(&self, place: usize, bits: i32) -> bool {
        N::is_felt(self.entries[place][place], bits)
    }

    /// Γ φ.
    #[inline(always)]
    pub(crate) fn times(&self, regressor: &[N; P]) -> [N; P] {
        if N::IS_FIXED || self.is_diagonal {
            from_fn(N::ZERO, |i| regressor[i].by(self.entries[i][i]))
        } else {
            from_fn(N::ZERO, |i| dot(&self.entries[i], regressor))
        }
    }
}

/// A row times the regressor: a function of its own, for its loop to be written out.
#[inline(always)]
fn dot<N: Arithmetic, const P: usize>(row: &[N::Factor; P], regressor: &[N; P]) -> N {
    let mut sum = regressor[0].by(row[0]);
    each::<P>(|j| {
        if j > 0 {
            sum = sum + regressor[j].by(row[j]);
        }
    });
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frozen_parameter_moves_nothing_and_is_not_moved() {
        let gamma = [[2.0, 0.5, 0.1], [0.5, 3.0, 0.2], [0.1, 0.2, 0.5]];
        let gamma = PositiveDefinite::new(gamma).expect("definite");
        let gain = Gain::<f64, 3>::new(&gamma, [false, true, false], [0; 3], [0; 3]);
        let expected = [0.5 + 0.8, 0.0, 0.025 + 4.0].map(f64::to_bits);
        assert_eq!(gain.times(&[0.25, 4.0, 8.0]).map(f64::to_bits), expected);
    }
}
