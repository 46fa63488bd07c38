//! Candidates beside a model. Each is the part of its columns that the model's own unknowns do not explain, and the
//! innovations that this part explains.

use crate::fit::{MAX_UNKNOWNS, Matrix, Spectrum, Vector};

use super::normal_blocks::NormalBlocks;

/// A model's own unknowns in a scan.
pub(super) struct ModelColumns {
    pub(super) places: Vec<usize>,
    /// Matrices and right sides of the segments.
    segments: Vec<(Matrix, Vector)>,
    spectrum: Spectrum,
    /// The step that the model would still take.
    step: Vector,
}

impl ModelColumns {
    pub(super) fn new(normal_blocks: &NormalBlocks, places: Vec<usize>) -> Self {
        let count = normal_blocks.count();
        let (matrix, right) = normal_blocks.sum(&places, 0..count);
        let spectrum = Spectrum::new(&matrix, places.len());
        let one = |segment| normal_blocks.sum(&places, std::iter::once(segment));
        Self {
            segments: (0..count).map(one).collect(),
            step: spectrum.solve(&right, 0.0),
            spectrum,
            places,
        }
    }

    /// The remainder of a candidate's columns beside the model.
    pub(super) fn partial_regression(
        &self,
        normal_blocks: &NormalBlocks,
        candidate: &[usize],
    ) -> PartialRegression {
        let own = self.places.len();
        let count = normal_blocks.count();
        let mut taken = [[0.0; MAX_UNKNOWNS]; 2];
        let mut whole = [0.0; 2];
        for ((taken, whole), &column) in taken.iter_mut().zip(&mut whole).zip(candidate) {
            let sum = |row| {
                (0..count)
                    .map(|k| normal_blocks.entry(k, row, column))
                    .sum::<f64>()
            };
            let mut right = [0.0; MAX_UNKNOWNS];
            for (right, &row) in right.iter_mut().zip(&self.places) {
                *right = sum(row);
            }
            *taken = self.spectrum.solve(&right, 0.0);
            *whole = sum(column);
        }
        let parts = self
            .segments
            .iter()
            .enumerate()
            .map(|(segment, (matrix, right))| {
                let mut part = Part::default();
                for (k, &column) in candidate.iter().enumerate() {
                    // The column less what the model takes of it, along each of the model's own.
                    let mut along = [0.0; MAX_UNKNOWNS];
                    for (j, along) in along.iter_mut().enumerate().take(own) {
                        let of_own: f64 = (0..own).map(|i| taken[k][i] * matrix[i][j]).sum();
                        *along = normal_blocks.entry(segment, self.places[j], column) - of_own;
                    }
                    part.right[k] =
                        normal_blocks.entry(segment, column, normal_blocks.innovation())
                            - (0..own)
                                .map(|i| taken[k][i] * right[i] + along[i] * self.step[i])
                                .sum::<f64>();
                    for (l, &other) in candidate.iter().enumerate() {
                        let product = (0..own)
                            .map(|i| {
                                taken[k][i] * normal_blocks.entry(segment, self.places[i], other)
                                    + taken[l][i] * along[i]
                            })
                            .sum::<f64>();
                        part.matrix[k][l] = normal_blocks.entry(segment, column, other) - product;
                    }
                }
                part
            });
        PartialRegression {
            sizes: candidate.len(),
            parts: parts.collect(),
            taken,
            whole,
        }
    }
}

/// A candidate's columns after partial regression on the model's own unknowns (Frisch and Waugh, "Partial time
/// regressions as compared with individual trends", Econometrica 1(4), 1933).
pub(super) struct PartialRegression {
    sizes: usize,
    parts: Vec<Part>,
    /// The step of the model's unknowns that a unit of each column is worth.
    pub(super) taken: [Vector; 2],
    /// Squares of the columns with what is taken.
    whole: [f64; 2],
}

/// The products of such columns with one another and with the innovation in a segment.
#[derive(Clone, Copy, Default)]
pub(super) struct Part {
    matrix: [[f64; 2]; 2],
    pub(super) right: [f64; 2],
}

impl Part {
    fn add(&mut self, other: &Self) {
        for k in 0..2 {
            self.right[k] += other.right[k];
            for l in 0..2 {
                self.matrix[k][l] += other.matrix[k][l];
            }
        }
    }

    /// The products with the innovation that a step leaves.
    fn left(&self, step: &[f64; 2]) -> [f64; 2] {
        let left =
            |k: usize| self.right[k] - self.matrix[k][0] * step[0] - self.matrix[k][1] * step[1];
        [left(0), left(1)]
    }

    /// The squares of the innovation that a step explains.
    pub(super) fn explained(&self, step: &[f64; 2]) -> f64 {
        let left = self.left(step);
        (0..2).map(|k| step[k] * (self.right[k] + left[k])).sum()
    }
}

impl PartialRegression {
    /// The sum of every `every`-th part.
    pub(super) fn sum(&self, first: usize, every: usize) -> Part {
        let mut sum = Part::default();
        for part in self.parts.iter().skip(first).step_by(every) {
            sum.add(part);
        }
        sum
    }

    /// The inverse of a sum's matrix, with a ridge over its diagonal.
    pub(super) fn inverse(&self, sum: &Part, ridge: f64) -> [[f64; 2]; 2] {
        /// The share of its squares that rounding leaves of a column that the model has already.
        const RANK_TOLERANCE: f64 = 1e-12;
        let m = &sum.matrix;
        let [a, d] = [0, 1].map(|k| {
            m[k][k].max(0.0) * (1.0 + ridge) + RANK_TOLERANCE * self.whole[k] + f64::MIN_POSITIVE
        });
        if self.sizes == 1 {
            return [[1.0 / a, 0.0], [0.0, 0.0]];
        }
        let cross = 0.5 * (m[0][1] + m[1][0]);
        let determinant = (a * d - cross * cross).max(RANK_TOLERANCE * a * d);
        [
            [d / determinant, -cross / determinant],
            [-cross / determinant, a / determinant],
        ]
    }

    /// The gain of each segment by the sizes that those of the other parity have.
    pub(super) fn held_out(&self) -> Vec<f64> {
        const RIDGE: f64 = 1e-6;
        let steps = [0, 1].map(|fold| {
            let sum = self.sum(fold, 2);
            product(&self.inverse(&sum, RIDGE), &sum.right)
        });
        let gains = self.parts.iter().enumerate();
        gains
            .map(|(segment, part)| part.explained(&steps[1 - segment % 2]))
            .collect()
    }

    /// χ² of sizes by the disagreement of the segments' scores.
    pub(super) fn significance(&self, inverse: &[[f64; 2]; 2], step: &[f64; 2]) -> f64 {
        let count = self.parts.len() as f64;
        let mut scatter = [[0.0; 2]; 2];
        for part in &self.parts {
            let moved = product(inverse, &part.left(step));
            for k in 0..2 {
                for l in 0..2 {
                    scatter[k][l] += moved[k] * moved[l] * count / (count - 1.0);
                }
            }
        }
        if self.sizes == 1 {
            return step[0] * step[0] / scatter[0][0].max(f64::MIN_POSITIVE);
        }
        let determinant = scatter[0][0] * scatter[1][1] - scatter[0][1] * scatter[1][0];
        let quadratic = step[0] * step[0] * scatter[1][1] - 2.0 * step[0] * step[1] * scatter[0][1]
            + step[1] * step[1] * scatter[0][0];
        quadratic / determinant.max(f64::MIN_POSITIVE)
    }
}

pub(super) fn product(matrix: &[[f64; 2]; 2], vector: &[f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| matrix[k][0] * vector[0] + matrix[k][1] * vector[1])
}
