//! Identification of a whole record at once: the fit, and the effects that it needs.

mod between;
mod candidate;
mod course;
mod effect_selection;
mod every_sample;
mod examine;
mod finish;
mod free_run;
mod jitter;
mod load_steps;
mod model;
mod normal_blocks;
mod partial_regression;
mod recording;
mod scan;
mod shown;
mod start;
mod uncertainty;

#[cfg(test)]
mod tests;

use crate::fit::{
    Effect, GoesOn, Horizon, QUANTISATION_SIGMA, Record, RecordFitter, RecordStatistics, Search,
    Values, acting_commands,
};

use candidate::Range;
use effect_selection::EffectSelection;
use jitter::Jitter;
use load_steps::LoadSteps;
use model::Model;
use start::start;

use crate::cause::Cause;
use crate::parallel;
use crate::scales::{TimeScale, scales, surest};

pub use model::Entered;

pub use between::Between;
pub use candidate::effects;
pub use course::{Course, FreeRun};
pub use examine::{Estimated, Examined, Lacking, examine};
pub use free_run::free_run;
pub use recording::{Axis, Logged, MAX_SAMPLES, Recording, Way};
pub use shown::SecondMode;
use uncertainty::Profile;
pub use uncertainty::SEPARATED;

/// A servo identified from a record, counts and samples.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The estimates.
    pub values: Values,
    /// The effects that were estimated, and their standard errors.
    pub estimated: Vec<(Effect, f64)>,
    /// The covariance of their errors, in the same order.
    pub covariance: Vec<Vec<f64>>,
    /// The estimates that a command of other sizes would determine better.
    pub needs_more_amplitudes: Vec<Effect>,
    /// The effects that entered, in the order in which they did.
    pub entered: Vec<Entered>,
    /// Deviation of the sensor's noise, counts.
    pub noise: f64,
    /// The sample of the record from which on the last load acts, where the load steps.
    pub last_load: Option<f64>,
    /// Deviation of the sampling instants, samples of the record, where they are uneven.
    pub jitter: Option<f64>,
    /// By how much the command was recorded late, samples of the log; none where it was not.
    pub lateness: Option<f64>,
    /// Gain in −2 ln L over b fixed at 0.8 and 1.25 of itself.
    pub profile: [f64; 2],
    /// What acted between two rows.
    pub between: Between,
    /// True if the delay is the longest that is looked for.
    pub delay_at_bound: bool,
    /// Figures of the record.
    pub statistics: RecordStatistics,
    /// The horizon of its filter.
    horizon: Horizon,
    /// True if the servo moved in both directions.
    pub reverses: bool,
    /// The braking force of a motion in one direction, friction and load together, and its standard error: c − d ahead,
    /// c + d back.
    pub braking: Option<[f64; 2]>,
    /// What the time scales say of the command that acted by this model; none where the model has no one inertia.
    pub acting: Option<TimeScale>,
    /// What the record says of a second mode beside this model, by its frequency.
    pub second_modes: Vec<SecondMode>,
    /// True if the model explains the record down to the noise of its sensor.
    pub is_explained: bool,
    /// True if it was stopped before its end: this is what was known then.
    pub was_stopped: bool,
}

/// The model with which a record is fitted.
#[derive(Debug, Clone)]
pub struct ModelDemand {
    /// Values that are declared and not fitted.
    pub known: Values,
    /// Effects that it has from the first fit on, beside those of every servo.
    pub required: Vec<Effect>,
    /// The most others that may enter.
    pub max_effects: usize,
}

/// Identifies the servo of a record, beginning from what its [time scales](Recording::scales) say; none where there is no
/// motion or nothing explains it. Where it may not go on, the result is the best model until then.
pub fn identify(
    recording: &Recording<'_>,
    scales: &[TimeScale],
    demand: &ModelDemand,
    goes_on: GoesOn<'_>,
) -> Option<Identified> {
    let record = recording.record();
    let earliest = RecordFitter {
        goes_on,
        ..RecordFitter::new(&record)?
    };
    let without = start(&earliest, scales, false);
    // A pendulum that nothing holds cannot be told as a servo without gravity.
    let has_gravity = without.is_none();
    let start = without.or_else(|| start(&earliest, scales, true))?;
    let mut demand = demand.clone();
    let mut values = demand.known;
    for effect in Effect::BASE {
        values.set(effect, start.get(effect));
    }
    if has_gravity {
        for effect in [Effect::GravitySine, Effect::GravityCosine] {
            values.set(effect, start.get(effect));
            if !demand.required.contains(&effect) {
                demand.required.push(effect);
            }
        }
    }
    let between = recording.axis().between;
    if between == Between::Held
        && let Some(acted) = recording.between_rows(&values)
    {
        return identify(&acted, &acted.scales(), &demand, goes_on);
    }
    let range = Range::new(recording, &earliest.statistics);
    let on_time = RecordFitter {
        earliest: 0.0,
        ..earliest
    };
    let mut found = (on_time, model(&on_time, &range, &values, &demand));
    let late = earliest.lateness(&values);
    let late = late.filter(|late| late.is_certain() && !has_gravity);
    if let Some(late) = late {
        let fitter = RecordFitter {
            earliest: -late.samples.round(),
            ..earliest
        };
        let other = model(&fitter, &range, &late.values, &demand);
        // An effect that is missing looks like a shift, too: on time with it the record has the say.
        if other.as_ref().is_some_and(|late| {
            let is_better =
                |on_time: &Model| late.gain_over(&on_time.fitted) > effect_selection::MIN_GAIN;
            found.1.as_ref().is_none_or(is_better)
        }) {
            found = (fitter, other);
        }
    }
    let (fitter, Some(mut model)) = found else {
        return None;
    };
    let is_finite = |effect: &Effect| model.fitted.values.get(*effect).is_finite();
    if !model.free.iter().all(is_finite) {
        return None;
    }
    let steps = LoadSteps::find(&fitter, &model.fitted);
    let some = recording.judged_samples().filter(|_| goes_on());
    let some_rows = some.as_ref().map(Recording::record);
    let refitted = (some_rows.as_ref())
        .and_then(|rows| every_sample::refit(&fitter, &model, rows, recording.block));
    // Blocks leave out what friction does within them: the errors are those of samples.
    let (judge, mut judged, log, block) = match (&refitted, &some) {
        (Some((judge, judged)), Some(some)) => (judge, judged.clone(), some, recording.block),
        _ => (&fitter, model.clone(), recording, 1.0),
    };
    let range = Range::new(log, &judge.statistics);
    let effect_selection = EffectSelection {
        fitter: judge,
        range: &range,
    };
    let mut modes = shown::modes(judge, &judged, &range);
    // Blocks have not shown a resonance that is faster than they are.
    let is_of_samples = refitted.is_some() && !judged.free.contains(&Effect::ResonanceFrequency);
    if is_of_samples && effect_selection.enter_best(&mut judged, modes.clone()) {
        (model.free, model.entered) = (judged.free.clone(), judged.entered.clone());
        modes = shown::modes(judge, &judged, &range);
    }
    let second_modes = modes
        .iter()
        .filter_map(|answer| SecondMode::of(answer, block));
    let second_modes: Vec<SecondMode> = second_modes.collect();
    let mut answers = effect_selection.answers(&judged);
    effect_selection.refine(&judged, &mut answers);
    // Of several loads the last is the servo's.
    let per_load = every_sample::in_samples(Effect::Load, block);
    let (load, by_chance) = steps.map_or_else(
        || judge.load(&judged.fitted, &judged.free),
        |steps| (steps.load.0 * per_load, steps.load.1 * per_load),
    );
    let authority = judge.usual_size(&judged.fitted.values, Effect::Load);
    let load_error = beyond_authority(load, authority)
        .max(by_chance)
        .hypot(ripple_as_load(log, &judged));
    let beyond = uncertainty::ErrorBudget::ALL;
    let (mut covariance, needs_more_amplitudes) =
        uncertainty::covariance(judge, &judged, load_error, &answers, beyond);
    let profile = Profile::new(judge, &judged);
    profile.widen(&judged, &mut covariance);
    let direction = recording.direction();
    let braking = direction.and_then(|direction| braking(&fitter, &model, direction));
    let mut load = load;
    if refitted.is_some() {
        let every = recording.every_sample().filter(|_| goes_on());
        if let Some(every) = every.filter(|every| every.record().len() > judge.record.len()) {
            every_sample::refine(judge, &mut judged, &every.record(), &mut covariance);
            if steps.is_none() && judged.fitted.horizon.walk.is_none() {
                load = judged.fitted.values.get(Effect::Load);
            }
        }
        every_sample::to_blocks(&model.free, &mut covariance, block);
        load /= per_load;
        model.fitted.values =
            (judged.fitted.values).scaled(|effect| 1.0 / every_sample::in_samples(effect, block));
    }
    let effect_selection = EffectSelection {
        fitter: &fitter,
        range: &range,
    };
    let delay = model.free.iter().position(|one| *one == Effect::Delay);
    let delay =
        delay.and_then(|place| effect_selection.delay(&model, covariance[place][place].sqrt()));
    let jitter = Jitter::find(&fitter, &model.fitted);
    let shown = steps.iter().map(LoadSteps::entered).chain(delay);
    let shown = shown.chain(jitter.iter().map(Jitter::entered));
    model.entered.extend(shown);
    let values = &model.fitted.values;
    let [_, longest] = fitter.bounds(values, Effect::Delay);
    let delay_at_bound = values.get(Effect::Delay) >= longest;
    // In a quick motion third differences contain more than noise, and so do the innovations of a model that lacks
    // much.
    let innovations = model.fitted.sums.noise().sqrt();
    let noise = fitter
        .statistics
        .noise
        .min(innovations.max(QUANTISATION_SIGMA));
    let (found, estimated, covariance) =
        recording.about_zero(&values.with(Effect::Load, load), &model.free, &covariance);
    let found = Identified {
        values: found,
        estimated,
        covariance,
        needs_more_amplitudes,
        entered: model.entered,
        noise,
        last_load: steps.map(|steps| recording.place(steps.last)),
        jitter: jitter.map(|jitter| jitter.deviation),
        lateness: (fitter.earliest < 0.0).then(|| -values.get(Effect::Delay) * recording.block),
        profile: profile.increases,
        between,
        delay_at_bound,
        statistics: fitter.statistics,
        horizon: model.fitted.horizon,
        reverses: direction.is_none(),
        braking,
        acting: acting(&record, fitter.statistics.noise, values),
        second_modes,
        was_stopped: !goes_on(),
        is_explained: true,
    };
    Some(found.with_the_rest(recording))
}

/// The surest time scale of a record with the command that acted by a model, and without the forces that it knows.
fn acting(record: &Record<'_>, noise: f64, values: &Values) -> Option<TimeScale> {
    /// The effects with which positions are not those of one inertia.
    const OTHERS: [Effect; 8] = [
        Effect::InertiaSine,
        Effect::InertiaCosine,
        Effect::Compliance,
        Effect::ResonanceFrequency,
        Effect::LoadShare,
        Effect::Backlash,
        Effect::EccentricitySine,
        Effect::EccentricityCosine,
    ];
    if OTHERS.iter().any(|effect| values.get(*effect) != 0.0) {
        return None;
    }
    let commands = acting_commands(record, values);
    let acted = Record {
        commands: &commands,
        recorded: &[],
        ..*record
    };
    surest(&scales(&acted, noise)).copied()
}

/// The braking force of a motion in one direction, in which friction and load are one force. A fit without friction
/// gives it.
fn braking(fitter: &RecordFitter<'_>, model: &Model, direction: f64) -> Option<[f64; 2]> {
    const SEARCH: Search = Search {
        steps: 4,
        tolerance: 1e-6,
    };
    let values = &model.fitted.values;
    let load = values.get(Effect::Load) - direction * values.get(Effect::Coulomb);
    let values = values.with(Effect::Coulomb, 0.0).with(Effect::Load, load);
    let free: Vec<Effect> = (model.free.iter().copied())
        .filter(|effect| *effect != Effect::Coulomb)
        .collect();
    let fitted = fitter.fit(&values, &free, model.fitted.horizon, SEARCH)?;
    let (load, error) = fitter.load(&fitted, &free);
    error.is_finite().then_some([-direction * load, error])
}

/// The excess of a load over the force that held the servo against it. This excess is the error of an effect's form.
fn beyond_authority(load: f64, authority: f64) -> f64 {
    (load.abs() - authority).max(0.0)
}

/// The mean over the motion of a ripple of which it shows less than a period. That mean is a load as well.
fn ripple_as_load(recording: &Recording<'_>, model: &Model) -> f64 {
    let mut ripples = model
        .entered
        .iter()
        .filter(|one| one.cause == Cause::Ripple);
    if !ripples.any(|ripple| ripple.error_of == Some(Cause::Gravity)) {
        return 0.0;
    }
    let values = &model.fitted.values;
    let mean = |(wave, order): ([Effect; 2], f64)| {
        let [sizes, means] = [
            wave.map(|effect| values.get(effect)),
            recording.mean_wave(order),
        ];
        sizes[0] * means[0] + sizes[1] * means[1]
    };
    values.ripples().map(mean).sum()
}

/// The model of a record with the effects that it shows; none if every search diverges.
fn model(
    fitter: &RecordFitter<'_>,
    range: &Range,
    values: &Values,
    demand: &ModelDemand,
) -> Option<Model> {
    const FIRST: Search = Search {
        steps: 4,
        tolerance: 1e-7,
    };
    const AGAIN: Search = Search {
        steps: 3,
        tolerance: 1e-7,
    };
    const LAST: Search = Search {
        steps: 6,
        tolerance: 1e-8,
    };
    let mut values = *values;
    let delay = values.get(Effect::Delay).max(fitter.earliest);
    values.set(Effect::Delay, delay);
    let free = [&Effect::BASE[..], &demand.required].concat();
    let best = |values: &Values, free: &[Effect], horizons: Vec<Horizon>, search: Search| {
        let fit = |&horizon: &Horizon| fitter.fit(values, free, horizon, search);
        let fits = parallel::map(&horizons, fit);
        fitter.best_horizon(fits.flatten(), free)
    };
    let fitted = best(&values, &free, fitter.horizons().collect(), FIRST)?;
    let effect_selection = EffectSelection { fitter, range };
    let mut model = Model {
        free,
        rows_per_row: fitted.covariances.rows_per_independent_row(),
        fitted,
        entered: Vec::new(),
    };
    let rehorizon = |model: &mut Model, search: Search, wide: bool| {
        let horizons = if wide {
            fitter.horizons().collect()
        } else {
            fitter.horizons_about(model.fitted.horizon).collect()
        };
        if let Some(fitted) = best(&model.fitted.values, &model.free, horizons, search) {
            model.fit_is(fitted);
        }
    };
    let mut is_first = true;
    while model.entered.len() <= demand.max_effects
        && effect_selection.round(&mut model, demand.max_effects)
        && (fitter.goes_on)()
    {
        rehorizon(&mut model, AGAIN, is_first);
        is_first = false;
    }
    effect_selection.prune(&mut model);
    effect_selection.mark_short_waves(&mut model);
    rehorizon(&mut model, LAST, false);
    Some(model)
}
