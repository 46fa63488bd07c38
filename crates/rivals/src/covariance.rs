use identifier_core::number::Number;

/// A covariance P × P kept as U D Uᵀ, U unit upper triangular and D diagonal.
///
/// Bierman, Factorization Methods for Discrete Sequential Estimation, 1977, chapter V. In this form
/// rounding leaves it symmetric and positive definite, which the plain update does not in `f32`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Covariance<N, const P: usize> {
    upper: [[N; P]; P],
    diagonal: [N; P],
}

/// The effect of a measurement on the estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Innovation<N, const P: usize> {
    /// The gain K: the estimates move by K times the prediction error.
    pub(crate) gain: [N; P],
    /// The variance of the prediction error, φᵀPφ + r.
    pub(crate) variance: N,
}

impl<N: Number, const P: usize> Covariance<N, P> {
    /// Independent parameters with the given variances, each above zero.
    pub(crate) fn diagonal(variances: [f64; P]) -> Self {
        Self {
            upper: core::array::from_fn(|i| {
                core::array::from_fn(|j| if i == j { N::ONE } else { N::ZERO })
            }),
            diagonal: variances.map(N::from_f64),
        }
    }

    /// Takes a measurement with regressor φ. `noise` answers with the noise variance r > 0 to the
    /// variance φᵀPφ that the covariance predicts.
    #[inline]
    pub(crate) fn measure(
        &mut self,
        regressor: &[N; P],
        noise: impl FnOnce(N) -> N,
    ) -> Innovation<N, P> {
        let projected: [N; P] = core::array::from_fn(|j| {
            (0..j).fold(regressor[j], |sum, i| sum + self.upper[i][j] * regressor[i])
        });
        let weighted: [N; P] = core::array::from_fn(|j| self.diagonal[j] * projected[j]);
        let predicted = (0..P).fold(N::ZERO, |sum, j| sum + projected[j] * weighted[j]);
        let noise = noise(predicted);

        let mut gain: [N; P] = [N::ZERO; P];
        let mut variance = noise;
        let mut precision = noise.reciprocal();
        for j in 0..P {
            let before = variance;
            let correction = projected[j] * precision;
            variance = before + projected[j] * weighted[j];
            precision = variance.reciprocal();
            self.diagonal[j] = self.diagonal[j] * before * precision;
            for i in 0..j {
                let entry = self.upper[i][j];
                self.upper[i][j] = entry - gain[i] * correction;
                gain[i] += entry * weighted[j];
            }
            gain[j] = weighted[j];
        }
        Innovation {
            gain: gain.map(|g| g * precision),
            variance,
        }
    }

    /// Multiplies the covariance by a factor above zero, forgetting by 1/λ, but no further than a
    /// diagonal entry of `most`.
    #[inline]
    pub(crate) fn forget(&mut self, factor: N, most: &[N; P]) {
        for (variance, &most) in self.diagonal.iter_mut().zip(most) {
            let grown = *variance * factor;
            *variance = if grown < most { grown } else { most };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    impl<N: Number, const P: usize> Covariance<N, P> {
        /// The variance of a combination gᵀθ of the parameters, gᵀPg.
        fn variance_of(&self, combination: &[N; P]) -> N {
            (0..P).fold(N::ZERO, |sum, j| {
                let projected = (0..j).fold(combination[j], |sum, i| {
                    sum + self.upper[i][j] * combination[i]
                });
                sum + projected * projected * self.diagonal[j]
            })
        }
    }

    /// The textbook update, P ← P − P φ φᵀ P / (r + φᵀ P φ).
    fn textbook(p: [[f64; 3]; 3], phi: [f64; 3], r: f64) -> ([[f64; 3]; 3], [f64; 3]) {
        let p_phi: [f64; 3] = core::array::from_fn(|i| (0..3).map(|j| p[i][j] * phi[j]).sum());
        let s: f64 = r + (0..3).map(|i| phi[i] * p_phi[i]).sum::<f64>();
        let next =
            core::array::from_fn(|i| core::array::from_fn(|j| p[i][j] - p_phi[i] * p_phi[j] / s));
        (next, p_phi.map(|x| x / s))
    }

    proptest! {
        #[test]
        fn agrees_with_the_textbook_update(
            regressors in prop::collection::vec(prop::array::uniform3(-2.0_f64..2.0), 1..30),
            noise in 0.1_f64..2.0,
        ) {
            let mut factored = Covariance::<f64, 3>::diagonal([1.0, 2.0, 3.0]);
            let mut plain = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
            let unit = |i: usize| core::array::from_fn(|j| if i == j { 1.0 } else { 0.0 });
            for phi in regressors {
                let innovation = factored.measure(&phi, |_| noise);
                let (next, gain) = textbook(plain, phi, noise);
                plain = next;
                for i in 0..3 {
                    prop_assert!((innovation.gain[i] - gain[i]).abs() < 1e-9);
                    prop_assert!((factored.variance_of(&unit(i)) - plain[i][i]).abs() < 1e-9);
                }
            }
        }

        #[test]
        fn stays_positive_in_single_precision(
            regressors in prop::collection::vec(prop::array::uniform3(-1e3_f32..1e3), 1..300),
        ) {
            let mut covariance = Covariance::<f32, 3>::diagonal([1e6, 1e6, 1e6]);
            let unit = |i: usize| core::array::from_fn(|j| if i == j { 1.0 } else { 0.0 });
            for phi in regressors {
                covariance.measure(&phi, |_| 1.0);
                covariance.forget(1.001, &[f32::INFINITY; 3]);
                for i in 0..3 {
                    prop_assert!(covariance.variance_of(&unit(i)) > 0.0);
                }
            }
        }
    }
}
