//! The products of the columns of a pass and the innovation, by segments of the record.

use crate::fit::{Column, Fitted, MAX_UNKNOWNS, Matrix, RecordFitter, Row, Vector, segments};

/// Gram matrices of the rows of each segment: of all columns and, last, of the innovation.
pub(super) struct NormalBlocks {
    columns: usize,
    segments: Vec<Vec<f64>>,
    /// Deviations of the columns, which are scaled to one.
    pub(super) scales: Vec<f64>,
}

impl NormalBlocks {
    /// The normal equations of a pass, with the `free` columns of the model first and those of candidates at `places`
    /// behind them. It has no products of candidates with one another, which would be most of the work. None if the
    /// model diverges.
    pub(super) fn new(
        fitter: &RecordFitter<'_>,
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
        // Of each row the first column behind the model's that is needed: of a candidate its own, of the innovation all.
        let mut first: Vec<usize> = (0..width).map(|i| i.min(free)).collect();
        for own in places {
            for &place in own {
                first[place] = own[0];
            }
        }
        let most = rows_together(fitter, fitted, columns);
        let mut rows = Rows::new(width);
        let ran = pass.run(&fitted.values, columns, &mut |sample| {
            let segment = sample.sample * count / length;
            if rows.segment != segment || rows.count == most {
                rows.add_to(&mut sums[rows.segment], free, &first);
                rows.segment = segment;
            }
            rows.take(sample);
        });
        rows.add_to(&mut sums[rows.segment], free, &first);
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

/// Rows that are summed as one. They span a small part of the horizon, and of the periods of waves, over which columns barely
/// change.
fn rows_together(fitter: &RecordFitter<'_>, fitted: &Fitted, columns: &[Column]) -> usize {
    const SHARE: f64 = 0.15;
    const PHASE: f64 = 1.0;
    const MOST: usize = 8;
    let horizon = fitted.horizon.walk.unwrap_or(fitted.horizon.white);
    let orders = columns.iter().filter(|column| column.effect.is_wave());
    let order = orders.fold(0.0, |most, column| f64::max(most, column.setting));
    let turned = order * fitter.statistics.velocity / fitter.record.radian.max(f64::MIN_POSITIVE);
    let rows = (SHARE * horizon).min(PHASE / turned.max(f64::MIN_POSITIVE));
    (rows as usize / fitter.record.stride.max(1)).clamp(1, MOST)
}

/// Sums of successive rows: of each column, and last of the innovation.
struct Rows {
    sums: Vec<f64>,
    count: usize,
    /// Sum of the innovations' variances.
    variance: f64,
    segment: usize,
}

impl Rows {
    fn new(width: usize) -> Self {
        Self {
            sums: vec![0.0; width],
            count: 0,
            variance: 0.0,
            segment: 0,
        }
    }

    fn take(&mut self, row: &Row<'_>) {
        let (columns, innovation) = self.sums.split_at_mut(row.regressor.len());
        for (sum, value) in columns.iter_mut().zip(row.regressor) {
            *sum += value;
        }
        innovation[0] += row.innovation;
        self.variance += row.variance;
        self.count += 1;
    }

    /// Adds the products to those of a segment, and begins again.
    fn add_to(&mut self, segment: &mut [f64], free: usize, first: &[usize]) {
        if self.count == 0 {
            return;
        }
        let width = self.sums.len();
        let weight = 1.0 / self.variance;
        for (i, &first) in first.iter().enumerate() {
            let own = self.sums[i] * weight;
            let entries = &mut segment[i * width..=i * width + i];
            let of_model = i.min(free);
            let (model, others) = (&self.sums[..of_model], &self.sums[first..=i]);
            for j in 0..of_model {
                entries[j] += own * model[j];
            }
            let entries = &mut entries[first..];
            for j in 0..others.len() {
                entries[j] += own * others[j];
            }
        }
        self.sums.fill(0.0);
        (self.count, self.variance) = (0, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use crate::fit::{Effect, Horizon, Record, Search, Values};

    use super::*;

    /// Columns that barely change over the summed rows have the products of the single rows.
    #[test]
    fn rows_that_are_taken_together_have_the_sums_of_a_fit() {
        const FREE: [Effect; 3] = [Effect::A, Effect::B, Effect::Load];
        let samples = 0..6000;
        let phase = |k: i32| 0.004 * f64::from(k);
        let positions: Vec<f64> = samples
            .clone()
            .map(|k| (3000.0 * phase(k).sin() + 900.0 * (0.37 * phase(k)).cos()).round())
            .collect();
        let commands: Vec<f64> = samples.map(|k| -phase(k).sin()).collect();
        let record = Record::of(&positions, &commands);
        let fitter = RecordFitter::new(&record).expect("a motion");
        let values = Values::NONE.with(Effect::B, 0.04).with(Effect::A, 1e-3);
        let horizon = Horizon {
            white: 100.0,
            walk: None,
        };
        let none = Search {
            steps: 0,
            tolerance: 1e-6,
        };
        let fitted = fitter.fit(&values, &FREE, horizon, none).expect("a fit");
        assert!(rows_together(&fitter, &fitted, &[]) > 4);
        let columns = FREE.map(Column::from);
        let normal_blocks =
            NormalBlocks::new(&fitter, &fitted, &columns, FREE.len(), &[]).expect("it runs");
        let (matrix, right) = normal_blocks.sum(&[0, 1, 2], 0..normal_blocks.count());
        let sums = &fitted.sums;
        let size = |i: usize| sums.hessian[i][i].sqrt();
        for i in 0..FREE.len() {
            let [of_rows, of_sums] = [right[i] * normal_blocks.scales[i], sums.gradient[i]];
            let least = 0.01 * size(i) * sums.squares.sqrt();
            assert!(
                (of_rows - of_sums).abs() < least,
                "{i}: {of_rows} {of_sums}"
            );
            for j in 0..FREE.len() {
                let of_rows = matrix[i][j] * normal_blocks.scales[i] * normal_blocks.scales[j];
                let off = (of_rows - sums.hessian[i][j]) / (size(i) * size(j));
                assert!(off.abs() < 0.01, "{i} {j}: {off}");
            }
        }
    }
}
