//! The products of the columns of a pass and the innovation, by segments of the record.

use identifier_core::identification::{
    Column, Fitted, Fitter, MAX_UNKNOWNS, Matrix, Vector, segments,
};

/// Gram matrices of the rows of each segment: of all columns and, last, of the innovation.
pub(super) struct Grams {
    columns: usize,
    segments: Vec<Vec<f64>>,
    /// Deviations of the columns, which are scaled to one.
    pub(super) scales: Vec<f64>,
}

impl Grams {
    /// Of a pass with the `free` columns of the model and those of candidates at `places` behind them. Of candidates it has
    /// no products with one another, which would be most of the work. None if the model runs away.
    pub(super) fn new(
        fitter: &Fitter<'_>,
        fitted: &Fitted,
        columns: &[Column],
        free: usize,
        places: &[Vec<usize>],
    ) -> Option<Self> {
        let pass = fitter.pass(&fitted.values, fitted.horizon);
        let length = fitter.record.len();
        let count = segments(length);
        let width = columns.len() + 1;
        let mut sums = vec![vec![0.0; width * width]; count];
        let mut row = vec![0.0; width];
        // Of each row the first column behind the model's that is needed: of a candidate its own, of the innovation all.
        let mut first: Vec<usize> = (0..width).map(|i| i.min(free)).collect();
        for own in places {
            for &place in own {
                first[place] = own[0];
            }
        }
        let ran = pass.run(&fitted.values, columns, &mut |sample| {
            let segment = &mut sums[sample.sample * count / length];
            row[..columns.len()].copy_from_slice(sample.regressor);
            row[columns.len()] = sample.innovation;
            let weight = 1.0 / sample.variance;
            for (i, &first) in first.iter().enumerate() {
                let own = row[i] * weight;
                let entries = &mut segment[i * width..=i * width + i];
                let (model, others) = entries.split_at_mut(i.min(free));
                for (entry, other) in model.iter_mut().zip(&row) {
                    *entry += own * other;
                }
                let others = &mut others[first - i.min(free)..];
                for (entry, other) in others.iter_mut().zip(&row[first..]) {
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
        Some(Self {
            columns: columns.len(),
            segments: sums,
            scales,
        })
    }

    /// The number of segments.
    pub(super) fn count(&self) -> usize {
        self.segments.len()
    }

    /// The place of the innovation.
    pub(super) const fn innovation(&self) -> usize {
        self.columns
    }

    /// The product of two columns in a segment.
    pub(super) fn entry(&self, segment: usize, row: usize, column: usize) -> f64 {
        let (low, high) = (row.min(column), row.max(column));
        self.segments[segment][high * (self.columns + 1) + low]
    }

    /// Sum over some segments of the rows and columns of some places.
    pub(super) fn sum(
        &self,
        places: &[usize],
        segments: impl Iterator<Item = usize>,
    ) -> (Matrix, Vector) {
        let mut matrix = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
        let mut right = [0.0; MAX_UNKNOWNS];
        for segment in segments {
            for (i, &row) in places.iter().enumerate() {
                right[i] += self.entry(segment, row, self.columns);
                for (j, &column) in places.iter().enumerate() {
                    matrix[i][j] += self.entry(segment, row, column);
                }
            }
        }
        (matrix, right)
    }
}
