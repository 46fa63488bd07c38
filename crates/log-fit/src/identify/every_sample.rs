//! The last fit of a long log, to its samples. Its blocks have shown which effects exist, but leave out the motion within
//! them, and what friction does there.

use crate::fit::{Effect, Horizon, Matrix, Record, RecordFitter, RecordStatistics, Search, Values};
use crate::parallel;

use super::model::Model;
use super::uncertainty::by_chance;

const SEARCH: Search = Search {
    steps: 6,
    tolerance: 1e-8,
};

/// The model of blocks of a length, fitted to samples of their log at the horizon that is best for these.
pub(super) fn refit<'a>(
    fitter: &RecordFitter<'a>,
    model: &Model,
    record: &'a Record<'a>,
    block: f64,
) -> Option<(RecordFitter<'a>, Model)> {
    let of_blocks = (fitter, &model.fitted.values, model.fitted.horizon);
    let (finest, values, of_blocks) = of_samples(of_blocks, record, block);
    let horizons: Vec<Horizon> = finest.horizons_about(of_blocks).collect();
    let fits = parallel::map(&horizons, |&horizon| {
        finest.fit(&values, &model.free, horizon, SEARCH)
    });
    let mut found = model.clone();
    found.fit_is(finest.best_horizon(fits.flatten(), &model.free)?);
    Some((finest, found))
}

/// Fits a model of some pieces of a log to all of it. The random part of the covariance is then that of every sample. The rest
/// of it is unchanged.
pub(super) fn refine(
    judge: &RecordFitter<'_>,
    model: &mut Model,
    record: &Record<'_>,
    covariance: &mut Matrix,
) {
    let all = RecordFitter { record, ..*judge };
    let Model { free, fitted, .. } = model;
    let Some(found) = all.fit(&fitted.values, free, fitted.horizon, SEARCH) else {
        return;
    };
    let before = by_chance(judge, fitted, free);
    let after = by_chance(&all, &found, free);
    let is_known = |i: usize| before[i][i] > 0.0 && after[i][i] > 0.0;
    for i in 0..free.len() {
        for j in 0..free.len() {
            if is_known(i) && is_known(j) {
                covariance[i][j] += after[i][j] - before[i][j];
            } else if i != j {
                // One that is at its bound in either has errors of its own.
                covariance[i][j] -= before[i][j];
            }
        }
    }
    fitted.values = found.values;
}

/// Converts the covariance of a model's free effects from samples to blocks of a length.
pub(super) fn to_blocks(free: &[Effect], covariance: &mut Matrix, block: f64) {
    let per: Vec<f64> = (free.iter())
        .map(|&effect| 1.0 / in_samples(effect, block))
        .collect();
    for (row, one) in covariance.iter_mut().zip(&per) {
        for (entry, other) in row.iter_mut().zip(&per) {
            *entry *= one * other;
        }
    }
}

/// A sample of a record of blocks in samples of the log, raised to its power in an effect's unit.
pub(super) fn in_samples(effect: Effect, block: f64) -> f64 {
    block.powi(effect.unit()[1])
}

/// Converts range, values and horizon from blocks of this length to a record of the samples.
pub(super) fn of_samples<'a>(
    (fitter, values, horizon): (&RecordFitter<'a>, &Values, Horizon),
    record: &'a Record<'a>,
    block: f64,
) -> (RecordFitter<'a>, Values, Horizon) {
    let statistics = RecordStatistics {
        velocity: fitter.statistics.velocity / block,
        bandwidth: fitter.statistics.bandwidth / block,
        ..fitter.statistics
    };
    let fitter = RecordFitter {
        record,
        statistics,
        earliest: fitter.earliest * block,
        block,
        goes_on: fitter.goes_on,
    };
    let horizon = Horizon {
        white: horizon.white * block,
        walk: horizon.walk.map(|walk| walk * block),
    };
    let values = values.scaled(|effect| in_samples(effect, block));
    (fitter, values, horizon)
}
