//! The sums of a pass that a fit needs.

use super::spectrum::{MAX_UNKNOWNS, Matrix, Spectrum, Vector};
use super::{Column, Effect, ModelPass, Values};

/// Normal equations of whitened rows, and their scores in segments of the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sums {
    /// Unknowns.
    pub unknowns: usize,
    /// Rows.
    pub rows: f64,
    /// ∑ φφᵀ/S.
    pub hessian: Matrix,
    /// ∑ φe/S.
    pub gradient: Vector,
    /// Sum over segments of the outer products of their ∑ φe/S.
    pub scores: Matrix,
    /// ∑ e²/S.
    pub squares: f64,
    /// The same of each innovation and the one before it.
    pub lagged: f64,
    /// ∑ ln S.
    pub log_variances: f64,
    /// Segments.
    pub segments: f64,
    /// Rows per row of a motion that does not repeat itself.
    pub repeated: f64,
}

/// The segments of a record of this length. They are long enough that errors barely correlate across them, and numerous
/// enough for a variance.
#[must_use]
pub fn segments(samples: usize) -> usize {
    (samples / 100).clamp(16, 60)
}

impl Sums {
    const NONE: Self = Self {
        unknowns: 0,
        rows: 0.0,
        hessian: [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS],
        gradient: [0.0; MAX_UNKNOWNS],
        scores: [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS],
        squares: 0.0,
        lagged: 0.0,
        log_variances: 0.0,
        segments: 0.0,
        repeated: 1.0,
    };

    /// The sums of a pass with some values; none if the model diverged. At most [`MAX_UNKNOWNS`] effects count.
    #[must_use]
    pub fn new(pass: &ModelPass<'_>, values: &Values, free: &[Effect]) -> Option<Self> {
        let count = free.len().min(MAX_UNKNOWNS);
        let mut columns = [Column::from(Effect::A); MAX_UNKNOWNS];
        for (column, &effect) in columns.iter_mut().zip(free) {
            *column = effect.into();
        }
        let length = pass.record.len();
        let segments = segments(length);
        let mut sums = Self {
            unknowns: count,
            segments: segments as f64,
            ..Self::NONE
        };
        let mut score = [0.0; MAX_UNKNOWNS];
        let mut segment = 0;
        let mut product = 1.0;
        let mut last = 0.0;
        let ran = pass.run(values, &columns[..count], &mut |row| {
            let here = row.sample * segments / length;
            if here != segment {
                segment = here;
                sums.close(&mut score);
            }
            let weight = 1.0 / row.variance;
            let error = row.innovation;
            sums.squares += error * error * weight;
            sums.lagged += error * last * weight;
            last = error;
            sums.rows += 1.0;
            // One logarithm for many samples.
            product *= row.variance;
            if product > 1e200 {
                sums.log_variances += libm::log(product);
                product = 1.0;
            }
            for (i, &own) in row.regressor.iter().enumerate() {
                let weighted = own * weight;
                score[i] += weighted * error;
                let entries = &mut sums.hessian[i];
                for (entry, &other) in entries.iter_mut().zip(&row.regressor[..=i]) {
                    *entry += weighted * other;
                }
            }
        });
        sums.close(&mut score);
        sums.log_variances += libm::log(product);
        for i in 0..count {
            for j in i + 1..count {
                sums.hessian[i][j] = sums.hessian[j][i];
            }
        }
        (ran && sums.squares.is_finite()).then_some(sums)
    }

    fn close(&mut self, score: &mut Vector) {
        for i in 0..self.unknowns {
            self.gradient[i] += score[i];
            for j in 0..self.unknowns {
                self.scores[i][j] += score[i] * score[j];
            }
        }
        *score = [0.0; MAX_UNKNOWNS];
    }

    /// The variance of a measurement, counts²: the scale of the innovations.
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.squares / self.rows
    }

    /// The correlation of the innovations from one measurement to the next.
    #[must_use]
    pub fn correlation(&self) -> f64 {
        self.lagged / self.squares
    }

    /// −2 ln L, but for a constant, with the variance of the measurements at its best.
    #[must_use]
    pub fn minus_two_log_likelihood(&self) -> f64 {
        self.rows * libm::log(self.noise().max(f64::MIN_POSITIVE)) + self.log_variances
    }

    /// The unknowns that are not `held` and of which something is known, and their number.
    fn known(&self, held: &[bool; MAX_UNKNOWNS]) -> ([usize; MAX_UNKNOWNS], usize) {
        let mut places = [0; MAX_UNKNOWNS];
        let mut count = 0;
        for i in 0..self.unknowns {
            if !held[i] && self.hessian[i][i] > 0.0 {
                places[count] = i;
                count += 1;
            }
        }
        (places, count)
    }

    /// Correlations of the estimates' errors at a minimum, by white noise: those of the segments scatter too much. An
    /// unknown that `held` marks goes with no other.
    #[must_use]
    pub fn correlations(&self, held: &[bool; MAX_UNKNOWNS]) -> Matrix {
        let (places, count) = self.known(held);
        let inverse = Spectrum::new(&picked(&self.hessian, &places[..count]), count).inverse();
        let mut correlations = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
        for (i, row) in correlations.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        for (a, &i) in places[..count].iter().enumerate() {
            for (b, &j) in places[..count].iter().enumerate().filter(|(b, _)| a != *b) {
                correlations[i][j] = inverse[a][b] / libm::sqrt(inverse[a][a] * inverse[b][b]);
            }
        }
        correlations
    }

    /// Covariances of the estimates at a minimum, by white noise and by the disagreement of the segments. The latter is
    /// the sandwich of Huber, 1967, and White, Econometrica 50(1), 1982. Unknowns that `held` marks are not among them.
    /// Segments of a motion that repeats itself agree in its errors, too.
    #[must_use]
    pub fn covariances(&self, held: &[bool; MAX_UNKNOWNS]) -> Covariances {
        let (places, count) = self.known(held);
        let spectrum = Spectrum::new(&picked(&self.hessian, &places[..count]), count);
        let inverse = spectrum.inverse();
        let scores = picked(&self.scores, &places[..count]);
        let freedom = self.segments / (self.segments - 1.0 - count as f64).max(1.0);
        let noise = self.noise();
        let mut variances = [f64::INFINITY; MAX_UNKNOWNS];
        let mut naive = [f64::INFINITY; MAX_UNKNOWNS];
        for (a, &place) in places[..count].iter().enumerate() {
            let mut robust = 0.0;
            for i in 0..count {
                for j in 0..count {
                    robust += inverse[a][i] * scores[i][j] * inverse[a][j];
                }
            }
            naive[place] = inverse[a][a] * noise * self.repeated;
            variances[place] = (robust * freedom).max(naive[place]);
        }
        Covariances {
            variances,
            naive,
            condition: spectrum.condition(),
        }
    }
}

/// The rows and columns of a matrix at some places.
fn picked(matrix: &Matrix, places: &[usize]) -> Matrix {
    let mut some = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
    for (row, &i) in some.iter_mut().zip(places) {
        for (entry, &j) in row.iter_mut().zip(places) {
            *entry = matrix[i][j];
        }
    }
    some
}

/// Variances of the estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covariances {
    /// The larger of the two; infinite for what nothing is known of.
    pub variances: Vector,
    /// By white noise.
    pub naive: Vector,
    /// Condition number of the scaled normal equations.
    pub condition: f64,
}

impl Covariances {
    /// Rows per independent row of autocorrelated errors: the median ratio of the variances.
    #[must_use]
    pub fn rows_per_independent_row(&self) -> f64 {
        let mut ratios = [f64::INFINITY; MAX_UNKNOWNS];
        let mut count = 0;
        for (variance, naive) in self.variances.iter().zip(&self.naive) {
            if variance.is_finite() && *naive > 0.0 {
                ratios[count] = variance / naive;
                count += 1;
            }
        }
        let known = &mut ratios[..count];
        known.sort_unstable_by(f64::total_cmp);
        known.get(count / 2).copied().unwrap_or(1.0).max(1.0)
    }
}
