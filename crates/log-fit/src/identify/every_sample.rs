//! The last fit of a long log, to every sample. Its blocks have shown which effects exist, but leave out the motion
//! within them.

use crate::fit::{Effect, Fitter, Horizon, Matrix, Record, RecordStatistics, Search, Values};

use super::model::Model;
use super::recording::Recording;
use super::uncertainty::by_chance;

const SEARCH: Search = Search {
    steps: 6,
    tolerance: 1e-8,
};

/// Fits the model of blocks to every sample of its log. The random part of the covariance is then that of every
/// sample. The rest of them is unchanged. The load where one that is constant was fitted; nothing changes where the log
/// has no blocks.
pub(super) fn refine(
    fitter: &Fitter<'_>,
    recording: &Recording<'_>,
    model: &mut Model,
    covariance: &mut Matrix,
) -> Option<f64> {
    let every = recording.every_sample().filter(|_| (fitter.goes_on)())?;
    let record = every.record();
    let block = recording.block;
    let Model { free, fitted, .. } = model;
    let of_blocks = (fitter, &fitted.values, fitted.horizon);
    let (finest, values, horizon) = of_samples(of_blocks, &record, block);
    let found = finest.fit(&values, free, horizon, SEARCH)?;
    let before = by_chance(fitter, fitted, free);
    let after = by_chance(&finest, &found, free);
    let is_known = |i: usize| before[i][i] > 0.0 && after[i][i] > 0.0;
    let per: Vec<f64> = (free.iter())
        .map(|&effect| 1.0 / in_samples(effect, block))
        .collect();
    for i in (0..free.len()).filter(|&i| is_known(i)) {
        for j in (0..free.len()).filter(|&j| is_known(j)) {
            covariance[i][j] += after[i][j] * per[i] * per[j] - before[i][j];
        }
    }
    fitted.values = (found.values).scaled(|effect| 1.0 / in_samples(effect, block));
    let is_constant = horizon.walk.is_none();
    is_constant.then(|| fitted.values.get(Effect::Load))
}

/// A sample of a record of blocks in samples of the log, raised to its power in an effect's unit.
fn in_samples(effect: Effect, block: f64) -> f64 {
    block.powi(effect.unit()[1])
}

/// Converts range, values and horizon from blocks of this length to a record of the samples.
pub(super) fn of_samples<'a>(
    (fitter, values, horizon): (&Fitter<'a>, &Values, Horizon),
    record: &'a Record<'a>,
    block: f64,
) -> (Fitter<'a>, Values, Horizon) {
    let statistics = RecordStatistics {
        velocity: fitter.statistics.velocity / block,
        bandwidth: fitter.statistics.bandwidth / block,
        ..fitter.statistics
    };
    let fitter = Fitter {
        record,
        statistics,
        earliest: fitter.earliest * block,
        goes_on: fitter.goes_on,
    };
    let horizon = Horizon {
        white: horizon.white * block,
        walk: horizon.walk.map(|walk| walk * block),
    };
    let values = values.scaled(|effect| in_samples(effect, block));
    (fitter, values, horizon)
}
