//! One pass that asks of every candidate how much of the innovations it would explain, without fitting it.

use identifier_core::identification::{
    Column, Effect, Fitted, Fitter, MAX_UNKNOWNS, Matrix, Spectrum, Vector, segments,
};

use super::candidate::{Candidate, Range};
use super::tournament::Model;
use crate::verdict::Cause;

/// A candidate's answer.
#[derive(Debug, Clone)]
pub(super) struct Answer {
    pub(super) candidate: Candidate,
    /// Gain in −2 ln L, in independent rows, in segments that it was not fitted to.
    pub(super) held_out: f64,
    /// Mean of that gain over its standard error.
    pub(super) consistency: f64,
    /// The same in all segments.
    pub(super) gain: f64,
    /// χ² of its sizes by the segments' disagreement.
    pub(super) significance: f64,
    /// Its sizes.
    pub(super) sizes: Vec<f64>,
    /// By how much it would move the free effects.
    pub(super) shifts: Vec<f64>,
}

impl Answer {
    /// False if its size would be negative and cannot be.
    pub(super) fn is_possible(&self) -> bool {
        !self.candidate.is_positive() || self.sizes[0] > 0.0
    }
}

/// Gram matrices of a segment's rows: of all columns and, last, of the innovation.
struct Grams {
    columns: usize,
    segments: Vec<Vec<f64>>,
}

impl Grams {
    fn entry(&self, segment: usize, row: usize, column: usize) -> f64 {
        let (low, high) = (row.min(column), row.max(column));
        self.segments[segment][high * (self.columns + 1) + low]
    }

    /// Sum over some segments of the rows and columns of some places.
    fn sum(
        &self,
        places: &[usize],
        segments: impl Iterator<Item = usize>,
    ) -> (Matrix, Vector, f64) {
        let mut matrix = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
        let mut right = [0.0; MAX_UNKNOWNS];
        let mut squares = 0.0;
        for segment in segments {
            for (i, &row) in places.iter().enumerate() {
                right[i] += self.entry(segment, row, self.columns);
                for (j, &column) in places.iter().enumerate() {
                    matrix[i][j] += self.entry(segment, row, column);
                }
            }
            squares += self.entry(segment, self.columns, self.columns);
        }
        (matrix, right, squares)
    }

    /// The squares that are left in each segment by a solution that was fitted to the others of its parity.
    fn held_out(&self, places: &[usize]) -> Vec<f64> {
        /// Ridge over the diagonal of all segments.
        const RIDGE: f64 = 1e-6;
        let count = self.segments.len();
        let mut left = vec![0.0; count];
        let (all, ..) = self.sum(places, 0..count);
        for fold in 0..2 {
            let (mut matrix, right, _) = self.sum(places, (fold..count).step_by(2));
            for (i, row) in matrix.iter_mut().enumerate().take(places.len()) {
                row[i] += RIDGE * all[i][i] + f64::MIN_POSITIVE;
            }
            let solution = Spectrum::new(&matrix, places.len()).solve(&right, 0.0);
            for segment in (1 - fold..count).step_by(2) {
                let (matrix, right, squares) = self.sum(places, std::iter::once(segment));
                left[segment] = squares - explained(&matrix, &right, &solution, places.len());
            }
        }
        left
    }
}

/// The squares that a solution explains.
fn explained(matrix: &Matrix, right: &Vector, solution: &Vector, count: usize) -> f64 {
    (0..count)
        .map(|i| {
            let along: f64 = (0..count).map(|j| matrix[i][j] * solution[j]).sum();
            solution[i] * (2.0 * right[i] - along)
        })
        .sum()
}

/// Asks some candidates beside a model, whose columns are with its own no more than a pass has.
pub(super) fn scan(
    fitter: &Fitter<'_>,
    model: &Model,
    range: &Range,
    candidates: &[Candidate],
) -> Vec<Answer> {
    let Model { free, fitted, .. } = model;
    let mut columns: Vec<Column> = free.iter().copied().map(Column::from).collect();
    let places: Vec<Vec<usize>> = candidates
        .iter()
        .map(|candidate| {
            let first = columns.len();
            columns.extend(&candidate.columns);
            (first..columns.len()).collect()
        })
        .collect();
    let Some((grams, scales)) = grams(fitter, fitted, &columns) else {
        return Vec::new();
    };
    let count = grams.segments.len();
    let noise = fitted.sums.noise() * model.rows_per_row;
    // A load that walks takes a constant one over.
    let own: Vec<usize> = (0..free.len())
        .filter(|&i| fitted.horizon.walk.is_none() || free[i] != Effect::Load)
        .collect();
    let without = grams.held_out(&own);
    let (matrix, right, _) = grams.sum(&own, 0..count);
    let base = Spectrum::new(&matrix, own.len()).solve(&right, 0.0);
    let base_explains = explained(&matrix, &right, &base, own.len());
    candidates
        .iter()
        .zip(places)
        .filter_map(|(candidate, places)| {
            let all: Vec<usize> = own.iter().chain(&places).copied().collect();
            if all.len() > MAX_UNKNOWNS {
                return None;
            }
            let (matrix, right, _) = grams.sum(&all, 0..count);
            let spectrum = Spectrum::new(&matrix, all.len());
            let solution = spectrum.solve(&right, 0.0);
            let gain = explained(&matrix, &right, &solution, all.len()) - base_explains;
            let with = grams.held_out(&all);
            let gains: Vec<f64> = without.iter().zip(&with).map(|(a, b)| a - b).collect();
            let mean = gains.iter().sum::<f64>() / count as f64;
            let scatter = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>();
            let error = (scatter / (count as f64 - 1.0) / count as f64).sqrt();
            let significance = significance(&grams, &all, &spectrum, &solution, places.len());
            let sizes: Vec<f64> = (own.len()..all.len())
                .map(|i| solution[i] / scales[all[i]])
                .collect();
            let mut held_out = mean * count as f64 / noise;
            if candidate.is_positive() && sizes[0] < 0.0 {
                held_out = held_out.min(0.0);
            }
            let mut shifts = vec![0.0; free.len()];
            for (i, &place) in own.iter().enumerate() {
                shifts[place] = (solution[i] - base[i]) / scales[place];
            }
            // The load of the record is what counts, and the mean of gravity is a part of it.
            if let Some(&place) = own.iter().find(|&&place| free[place] == Effect::Load)
                && candidate.cause == Cause::Gravity
            {
                shifts[place] += range.mean_gravity(sizes.iter().copied());
            }
            Some(Answer {
                candidate: candidate.clone(),
                held_out,
                consistency: mean / error.max(f64::MIN_POSITIVE),
                gain: gain / noise,
                significance,
                sizes,
                shifts,
            })
        })
        .collect()
}

/// χ² of the last sizes of a solution, by the disagreement of the segments' scores.
fn significance(
    grams: &Grams,
    places: &[usize],
    spectrum: &Spectrum,
    solution: &Vector,
    last: usize,
) -> f64 {
    let count = grams.segments.len();
    let inverse = spectrum.inverse();
    let rows = places.len();
    let mut scatter = [[0.0; 2]; 2];
    let first = rows - last;
    for segment in 0..count {
        let (matrix, right, _) = grams.sum(places, std::iter::once(segment));
        let mut moved = [0.0; 2];
        for (k, entry) in moved.iter_mut().enumerate().take(last) {
            *entry = (0..rows)
                .map(|i| {
                    let along: f64 = (0..rows).map(|j| matrix[i][j] * solution[j]).sum();
                    inverse[first + k][i] * (right[i] - along)
                })
                .sum();
        }
        for i in 0..last {
            for j in 0..last {
                scatter[i][j] += moved[i] * moved[j] * count as f64 / (count as f64 - 1.0);
            }
        }
    }
    let size = [
        solution[first],
        if last > 1 { solution[first + 1] } else { 0.0 },
    ];
    if last == 1 {
        return size[0] * size[0] / scatter[0][0].max(f64::MIN_POSITIVE);
    }
    let determinant = scatter[0][0] * scatter[1][1] - scatter[0][1] * scatter[1][0];
    let quadratic = size[0] * size[0] * scatter[1][1] - 2.0 * size[0] * size[1] * scatter[0][1]
        + size[1] * size[1] * scatter[0][0];
    quadratic / determinant.max(f64::MIN_POSITIVE)
}

/// The Gram matrices of the segments with columns scaled to one, and the scales.
fn grams(fitter: &Fitter<'_>, fitted: &Fitted, columns: &[Column]) -> Option<(Grams, Vec<f64>)> {
    let pass = fitter.pass(&fitted.values, fitted.horizon);
    let length = fitter.record.len();
    let count = segments(length);
    let width = columns.len() + 1;
    let mut sums = vec![vec![0.0; width * width]; count];
    let mut row = vec![0.0; width];
    let ran = pass.run(&fitted.values, columns, &mut |sample| {
        let segment = &mut sums[sample.sample * count / length];
        row[..columns.len()].copy_from_slice(sample.regressor);
        row[columns.len()] = sample.innovation;
        let weight = 1.0 / sample.variance;
        for i in 0..width {
            let own = row[i] * weight;
            let entries = &mut segment[i * width..=i * width + i];
            for (entry, other) in entries.iter_mut().zip(&row) {
                *entry += own * other;
            }
        }
    });
    if !ran {
        return None;
    }
    let mut scales = vec![1.0; width];
    for (i, scale) in scales.iter_mut().enumerate().take(columns.len()) {
        let square: f64 = sums.iter().map(|segment| segment[i * width + i]).sum();
        if square > 0.0 && square.is_finite() {
            *scale = (square / length as f64).sqrt();
        }
    }
    for segment in &mut sums {
        for i in 0..width {
            for j in 0..=i {
                let entry = &mut segment[i * width + j];
                *entry /= scales[i] * scales[j];
                if !entry.is_finite() {
                    *entry = 0.0;
                }
            }
        }
    }
    let grams = Grams {
        columns: columns.len(),
        segments: sums,
    };
    Some((grams, scales))
}
