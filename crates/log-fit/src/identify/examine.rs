//! Tests an estimator's estimates against a record. The result is the estimates that fit the record, their uncertainty,
//! and the effect that the estimator's model lacks.

use crate::fit::{Effect, Horizon, RecordFitter, RecordStatistics, Search, Values};

use super::candidate::Range;
use super::effect_selection::EffectSelection;
use super::model::{Entered, Model};
use super::recording::Recording;
use super::uncertainty::{self, ErrorBudget, Profile};

/// Estimates and their model, counts and samples of a recording.
#[derive(Debug, Clone)]
pub struct Estimated {
    /// The estimates, and the values that the model takes for granted.
    pub values: Values,
    /// The effects that are estimated.
    pub free: Vec<Effect>,
    /// True if the errors and the effects may take many passes.
    pub is_thorough: bool,
}

/// The evidence of a record for an estimator's estimates, counts and samples.
#[derive(Debug, Clone)]
pub struct Examined {
    /// The estimator's model, refitted to the record, with the effect that it lacks.
    pub values: Values,
    /// The effects that are estimated in it, and their standard errors.
    pub estimated: Vec<(Effect, f64)>,
    /// The covariance of their errors, in the same order.
    pub covariance: Vec<Vec<f64>>,
    /// The estimates that a command of other sizes would determine better.
    pub needs_more_amplitudes: Vec<Effect>,
    /// Deviation of a measurement from the estimator's refitted model, counts.
    pub noise: f64,
    /// Correlation of its innovations from sample to sample.
    pub correlation: f64,
    /// The effect that the estimator's model lacks.
    pub lacking: Option<Lacking>,
    /// Gain in −2 ln L over b fixed at 0.8 and 1.25 times itself. None if it was not requested or b is not estimated.
    pub profile: Option<[f64; 2]>,
    /// Figures of the record.
    pub statistics: RecordStatistics,
}

/// An effect that an estimator's model lacks.
#[derive(Debug, Clone)]
pub struct Lacking {
    /// The effect.
    pub entered: Entered,
    /// The part of the innovations' squares that it explains.
    pub share: f64,
}

/// The horizon of the examination, in units of the shortest. It is long enough for the model to show its errors.
const HORIZON: f64 = 4.0;

const SEARCH: Search = Search {
    steps: 6,
    tolerance: 1e-6,
};

/// Examines estimates; none without motion or if the model cannot follow the record. The function `is_explained` is
/// true if this noise and correlation of the innovations need no further effect.
pub fn examine(
    recording: &Recording<'_>,
    law: &Estimated,
    is_explained: impl Fn(f64, f64) -> bool,
) -> Option<Examined> {
    let record = recording.record();
    let earliest = RecordFitter::new(&record)?;
    let on_time = RecordFitter {
        earliest: 0.0,
        ..earliest
    };
    let fitter = &on_time;
    let own = recording.about_middle(&law.values);
    let mut model = follow(fitter, &own, &law.free, || {
        super::start(&earliest, &recording.scales(), false)
    })?;
    let noise = model.fitted.sums.noise().sqrt();
    let correlation = model.fitted.sums.correlation();
    let mut answers = Vec::new();
    let mut lacking = None;
    if !is_explained(noise, correlation) {
        let range = Range::new(recording, &fitter.statistics);
        let effect_selection = EffectSelection {
            fitter,
            range: &range,
        };
        answers = effect_selection.answers(&model);
        if effect_selection.enter(&mut model, &answers) {
            // Without the effect it may have stood far off.
            effect_selection.settle(&mut model);
            effect_selection.mark_short_waves(&mut model);
            let left = model.fitted.sums.noise() / (noise * noise);
            lacking = model.entered.last().cloned().map(|entered| Lacking {
                entered,
                share: 1.0 - left,
            });
            answers = effect_selection.answers(&model);
        }
    }
    let load = fitter.load(&model.fitted, &model.free);
    let beyond = ErrorBudget {
        has_spread: law.is_thorough,
        bounds_at_zero_are_exact: true,
    };
    let (mut covariance, needs_more_amplitudes) =
        uncertainty::covariance(fitter, &model, load.1, &answers, beyond);
    let has_profile = law.is_thorough && model.free.contains(&Effect::B);
    let profile = has_profile.then(|| Profile::new(fitter, &model));
    if let Some(profile) = &profile {
        profile.widen(&model, &mut covariance);
    }
    let (values, estimated, covariance) =
        recording.about_zero(&model.fitted.values, &model.free, &covariance);
    Some(Examined {
        values,
        estimated,
        covariance,
        needs_more_amplitudes,
        noise,
        correlation,
        lacking,
        profile: profile.map(|profile| profile.increases),
        statistics: fitter.statistics,
    })
}

/// Refits an estimator's model to the record. The search starts from the estimator's estimates, or from a start of its
/// own if there are none.
fn follow(
    fitter: &RecordFitter<'_>,
    estimates: &Values,
    free: &[Effect],
    start: impl FnOnce() -> Option<Values>,
) -> Option<Model> {
    let horizon = Horizon {
        white: HORIZON * fitter.statistics.shortest_horizon(fitter.record.len()),
        walk: None,
    };
    let fit = |values: &Values| fitter.fit(values, free, horizon, SEARCH);
    let is_servo = estimates.get(Effect::B) > 0.0
        && free.iter().all(|&effect| estimates.get(effect).is_finite());
    let from_start = || {
        let start = start()?;
        let mut values = *estimates;
        for &effect in free {
            values.set(effect, start.get(effect));
        }
        fit(&values)
    };
    let fitted = is_servo
        .then(|| fit(estimates))
        .flatten()
        .or_else(from_start)?;
    Some(Model {
        free: free.to_vec(),
        rows_per_row: fitted.covariances.rows_per_independent_row(),
        fitted,
        entered: Vec::new(),
    })
}
