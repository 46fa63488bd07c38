//! The last fit of a long log, to every sample: its blocks have shown which effects there are, and leave out what the
//! servo did within them.

use crate::fit::{Effect, Fitter, Horizon, Search, Survey};

use super::recording::Recording;
use super::tournament::Model;

const SEARCH: Search = Search {
    steps: 6,
    tolerance: 1e-8,
};

/// Fits the model of blocks to every sample of its log. The chance in the standard errors is then that of every
/// sample, and what they hold beyond it stays. The load where one that is constant was fitted; nothing changes where the log has
/// no blocks.
pub(super) fn refine(
    fitter: &Fitter<'_>,
    recording: &Recording<'_>,
    model: &mut Model,
    std_errors: &mut [f64],
) -> Option<f64> {
    let every = recording.every_sample()?;
    let record = every.record();
    let block = recording.block;
    // A unit of the blocks in those of samples.
    let per_block = |effect: Effect| block.powi(effect.unit()[1]);
    let horizon = model.fitted.horizon;
    let finest = Fitter {
        record: &record,
        survey: Survey {
            velocity: fitter.survey.velocity / block,
            bandwidth: fitter.survey.bandwidth / block,
            ..fitter.survey
        },
        earliest: fitter.earliest * block,
    };
    let horizon = Horizon {
        white: horizon.white * block,
        walk: horizon.walk.map(|walk| walk * block),
    };
    let values = model.fitted.values.scaled(per_block);
    let found = finest.fit(&values, &model.free, horizon, SEARCH)?;
    let [of_blocks, of_samples] = [&model.fitted, &found].map(|fitted| fitted.std_errors());
    for (i, &effect) in model.free.iter().enumerate() {
        let own = of_samples[i] / per_block(effect);
        let beyond = std_errors[i] * std_errors[i] - of_blocks[i] * of_blocks[i];
        if own.is_finite() && beyond.is_finite() {
            std_errors[i] = beyond.max(0.0).sqrt().hypot(own);
        }
    }
    model.fitted.values = found.values.scaled(|effect| 1.0 / per_block(effect));
    let is_constant = horizon.walk.is_none();
    is_constant.then(|| model.fitted.values.get(Effect::Load))
}
