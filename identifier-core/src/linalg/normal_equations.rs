use core::array::from_fn;

use crate::number::Number;

/// The normal equations of a least-squares fit in Q unknowns, gathered sample by sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalEquations<N, const Q: usize> {
    matrix: [[N; Q]; Q],
    right: [N; Q],
    cost: N,
}

/// Without a sample.
impl<N: Default, const Q: usize> Default for NormalEquations<N, Q> {
    fn default() -> Self {
        Self {
            matrix: from_fn(|_| from_fn(|_| N::default())),
            right: from_fn(|_| N::default()),
            cost: N::default(),
        }
    }
}

impl<N: Number, const Q: usize> NormalEquations<N, Q> {
    /// The sum of squared errors.
    #[must_use]
    pub fn cost(&self) -> N {
        self.cost
    }

    /// Takes in a sample: its error and the error's decrease per unit of each unknown.
    #[inline]
    pub fn add(&mut self, row: &[N; Q], error: N) {
        for i in 0..Q {
            for (entry, &before) in self.matrix[i].iter_mut().zip(row).take(i + 1) {
                *entry += row[i] * before;
            }
            self.right[i] += row[i] * error;
        }
        self.cost += error * error;
    }

    /// Takes in that one unknown is expected to be this much larger: a sample that depends on no other. The weight is the
    /// standard deviation of a sample's error over that of the expectation.
    pub fn expect(&mut self, unknown: usize, weight: N, larger: N) {
        let error = larger * weight;
        let diagonal = self
            .matrix
            .get_mut(unknown)
            .and_then(|row| row.get_mut(unknown));
        if let (Some(diagonal), Some(right)) = (diagonal, self.right.get_mut(unknown)) {
            *diagonal += weight * weight;
            *right += weight * error;
            self.cost += error * error;
        }
    }

    /// The sum of the squares of an unknown's column; zero beyond the last.
    pub(crate) fn square(&self, unknown: usize) -> N {
        let row = self.matrix.get(unknown).and_then(|row| row.get(unknown));
        row.copied().unwrap_or(N::ZERO)
    }

    /// Leaves all samples this part of their weight.
    pub(crate) fn fade(&mut self, part: N) {
        for entry in self.matrix.iter_mut().flatten().chain(&mut self.right) {
            *entry = part * *entry;
        }
        self.cost = part * self.cost;
    }

    /// The same for the errors that values of the unknowns leave.
    #[must_use]
    pub(crate) fn about(&self, values: &[N; Q]) -> Self {
        let mut about = *self;
        // Looked up without a panic, also where the compiler optimises for size.
        for (i, (row, &value)) in self.matrix.iter().zip(values).enumerate() {
            for (j, (&entry, &other)) in row.iter().zip(values).enumerate().take(i + 1) {
                if let Some(right) = about.right.get_mut(i) {
                    *right = *right - entry * other;
                }
                if let (true, Some(right)) = (j < i, about.right.get_mut(j)) {
                    *right = *right - entry * value;
                }
            }
        }
        let rights = self.right.iter().zip(&about.right);
        for ((&before, &after), &value) in rights.zip(values) {
            about.cost = about.cost - value * (before + after);
        }
        about.cost = about.cost.larger(N::ZERO);
        about
    }

    /// The sum of squared errors that a solution leaves.
    pub(crate) fn left_by(&self, solution: &[N; Q]) -> N {
        let terms = solution.iter().zip(&self.right);
        terms.fold(self.cost, |left, (&x, &right)| left - x * right)
    }

    /// The step of Levenberg and Marquardt, (A + λ diag A) δ = g. Source: Marquardt, "An algorithm for least-squares
    /// estimation of nonlinear parameters", SIAM Journal 11(2), 1963. An unknown that is not `free`, or on which
    /// nothing depends, stays.
    #[must_use]
    pub fn solve(&self, damping: N, free: &[bool; Q]) -> [N; Q] {
        self.factor(damping, free).solve(&self.right)
    }

    /// The same in parts: another row of the factor, or the step once it has all.
    pub(crate) fn solve_on(&self, factor: &mut Factor<N, Q>) -> Option<[N; Q]> {
        let row = factor.rows;
        if row < Q {
            factor.add_row(self, row);
            factor.rows += 1;
            return None;
        }
        Some(factor.solve(&self.right))
    }

    /// By how much the sum of squared errors falls when the unknowns that are `free` are fitted.
    #[must_use]
    pub fn explained_by(&self, free: &[bool; Q]) -> N {
        let fitted = self.solve(N::ZERO, free);
        let mut sum = N::ZERO;
        for i in 0..Q {
            if free[i] {
                sum += fitted[i] * self.right[i];
            }
        }
        sum
    }

    /// A⁻¹, the covariance of the unknowns for errors of variance one. The rows and columns of an
    /// unknown that nothing depends on are zero.
    #[must_use]
    pub fn covariance(&self) -> [[N; Q]; Q] {
        let factor = self.factor(N::ZERO, &[true; Q]);
        from_fn(|i| factor.solve(&from_fn(|j| if i == j { N::ONE } else { N::ZERO })))
    }

    /// rᵀ A⁻¹ r for some r, the variances of r times the unknowns for errors of variance one.
    #[must_use]
    pub fn variances<const K: usize>(&self, rows: &[[N; Q]; K]) -> [N; K] {
        let factor = self.factor(N::ZERO, &[true; Q]);
        rows.map(|row| {
            let solved = factor.solve(&row);
            let mut sum = N::ZERO;
            for i in 0..Q {
                sum += row[i] * solved[i];
            }
            sum
        })
    }

    fn factor(&self, damping: N, free: &[bool; Q]) -> Factor<N, Q> {
        let mut factor = self.begin_factor(damping, free);
        for i in 0..Q {
            factor.add_row(self, i);
        }
        factor
    }

    /// A factor without rows.
    pub(crate) fn begin_factor(&self, damping: N, free: &[bool; Q]) -> Factor<N, Q> {
        Factor {
            damping,
            rows: 0,
            scale: from_fn(|i| {
                let diagonal = self.matrix[i][i];
                if free[i] && diagonal > N::ZERO {
                    diagonal.reciprocal_root()
                } else {
                    N::ZERO
                }
            }),
            lower: [[N::ZERO; Q]; Q],
            inverse: [N::ZERO; Q],
        }
    }
}

/// Cholesky's factor of the matrix scaled to a unit diagonal and damped, the reciprocals of its diagonal apart. It grows
/// row by row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Factor<N, const Q: usize> {
    damping: N,
    rows: usize,
    scale: [N; Q],
    lower: [[N; Q]; Q],
    inverse: [N; Q],
}

impl<N: Number, const Q: usize> Factor<N, Q> {
    /// Row i, after all before it. Always inlined, so that the bounds of i are known.
    #[inline(always)]
    fn add_row(&mut self, equations: &NormalEquations<N, Q>, i: usize) {
        /// The least pivot of the matrix scaled to a unit diagonal.
        const MIN_PIVOT: f64 = 1e-6;
        let mut own = [N::ZERO; Q];
        let mut pivot = N::ONE + self.damping;
        let columns = equations.matrix[i]
            .iter()
            .zip(&self.scale)
            .zip(self.lower.iter().zip(&self.inverse));
        for (j, ((&entry, &other), (before, &per_pivot))) in columns.enumerate().take(i) {
            let mut sum = entry * self.scale[i] * other;
            for (&left, &above) in own.iter().zip(before).take(j) {
                sum = sum - left * above;
            }
            let entry = sum * per_pivot;
            pivot = pivot - entry * entry;
            // Looked up without a panic, also where the compiler optimises for size.
            if let Some(place) = own.get_mut(j) {
                *place = entry;
            }
        }
        let least = N::from_f64(MIN_PIVOT);
        let pivot = if pivot > least { pivot } else { least };
        self.inverse[i] = pivot.reciprocal_root();
        own[i] = pivot * self.inverse[i];
        self.lower[i] = own;
    }

    fn solve(&self, right: &[N; Q]) -> [N; Q] {
        let (scale, lower, inverse) = (&self.scale, &self.lower, &self.inverse);
        let mut x: [N; Q] = from_fn(|i| right[i] * scale[i]);
        for i in 0..Q {
            for k in 0..i {
                x[i] = x[i] - lower[i][k] * x[k];
            }
            x[i] = x[i] * inverse[i];
        }
        for i in (0..Q).rev() {
            for k in i + 1..Q {
                x[i] = x[i] - lower[k][i] * x[k];
            }
            x[i] = x[i] * inverse[i];
        }
        from_fn(|i| x[i] * scale[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn solves_a_linear_fit_exactly(
            truth in prop::array::uniform3(-5.0_f64..5.0),
            rows in prop::collection::vec(prop::array::uniform3(-1.0_f64..1.0), 20..40),
        ) {
            let mut equations = NormalEquations::<f64, 3>::default();
            for row in &rows {
                let error: f64 = (0..3).map(|i| row[i] * truth[i]).sum();
                equations.add(row, error);
            }
            let solution = equations.solve(0.0, &[true; 3]);
            let covariance = equations.covariance();
            for i in 0..3 {
                prop_assert!((solution[i] - truth[i]).abs() < 1e-6);
                prop_assert!(covariance[i][i] > 0.0);
            }
        }
    }

    #[test]
    fn an_expectation_is_a_sample_of_one_unknown() {
        let mut samples = NormalEquations::<f64, 3>::default();
        samples.add(&[1.0, -2.0, 0.5], 3.0);
        let mut expected = samples;
        samples.add(&[0.0, 4.0, 0.0], 4.0 * -0.7);
        expected.expect(1, 4.0, -0.7);
        assert_eq!(samples, expected);
    }

    #[test]
    fn an_unknown_that_nothing_depends_on_stays() {
        let mut equations = NormalEquations::<f32, 2>::default();
        for k in 0..10 {
            equations.add(&[k as f32, 0.0], 3.0 * k as f32);
        }
        let step = equations.solve(0.0, &[true; 2]);
        assert!((step[0] - 3.0).abs() < 1e-4);
        assert!(step[1].abs() < 1e-9);
    }
}
