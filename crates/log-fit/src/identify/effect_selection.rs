//! Effects enter the model one at a time by forward selection. The best candidates are fitted. The best stays if it
//! explains enough that the model did not.

use std::f64::consts::TAU;

use crate::fit::{
    Effect, Fitted, Horizon, MAX_COLUMNS, MAX_UNKNOWNS, RecordFitter, Search, Values, segments,
};

use super::candidate::{Answer, Candidate, Range, TypicalMagnitudes};
use super::model::{Entered, Model};
use super::scan::scan;
use crate::cause::Cause;
use crate::parallel;

/// The least gain with which an effect enters, in independent rows.
pub(super) const MIN_GAIN: f64 = 30.0;

/// Candidates that are fitted in a round.
const MAX_FITTED: usize = 5;

/// A candidate with less than this part of the best's gain is not fitted.
const MIN_SHARE: f64 = 0.2;

const SEARCH: Search = Search {
    steps: 8,
    tolerance: 1e-7,
};

/// The search for an effect that another may beat, and for a shift, which is an error itself.
const BRIEF: Search = Search {
    steps: 5,
    tolerance: 1e-5,
};

pub(super) struct EffectSelection<'a> {
    pub(super) fitter: &'a RecordFitter<'a>,
    pub(super) range: &'a Range,
}

impl EffectSelection<'_> {
    /// A round: false if no effect enters. Beside the most effects only a further wave of ripple may.
    pub(super) fn round(&self, model: &mut Model, most: usize) -> bool {
        // A model that is not at its best yet would let any effect gain.
        self.settle(model);
        let has_room = model.entered.len() < most || model.has(Cause::Ripple);
        if has_room && self.enter_wave(model) {
            return true;
        }
        let mut answers = self.answers(model);
        if model.entered.len() >= most {
            answers.retain(|answer| model.has(answer.candidate.cause));
        }
        let order = |answer: &Answer| answer.candidate.columns[0].setting;
        let clear = self.clear_wave(&answers).map(order);
        answers.retain(|answer| {
            answer.candidate.cause != Cause::Ripple || Some(order(answer)) == clear
        });
        self.enter(model, &answers)
    }

    /// Lets the clearest wave of ripple enter. With a short memory the filter leaves nothing of what is slower than a wave;
    /// with a longer one any wave would explain a part of that.
    fn enter_wave(&self, model: &mut Model) -> bool {
        /// Memories, samples.
        const MEMORIES: [f64; 3] = [8.0, 25.0, 80.0];
        const AS_IT_IS: Search = Search {
            steps: 0,
            tolerance: 1.0,
        };
        let waves = Candidate::waves(self.range, &model.free, self.range.order);
        let near = parallel::map(&MEMORIES, |&white| {
            let horizon = Horizon { white, walk: None };
            let (values, free) = (&model.fitted.values, &model.free);
            let mut near = model.clone();
            near.fit_is(self.fitter.fit(values, free, horizon, AS_IT_IS)?);
            let answers = self.answers_of(&near, &waves);
            let clear = self.clear_wave(&answers)?;
            // A gain that goes with the angle has the same wave.
            let other = Candidate::torque_ripple(clear.candidate.columns[0].setting, &model.free);
            let either: Vec<Candidate> =
                other.into_iter().chain([clear.candidate.clone()]).collect();
            let held_out = clear.held_out;
            let answers = self.answers_of(&near, &either);
            Some((near, answers, held_out))
        });
        let best = near
            .flatten()
            .reduce(|best, other| if other.2 > best.2 { other } else { best });
        best.is_some_and(|(mut near, answers, _)| {
            if self.enter(model, &answers) {
                return true;
            }
            let enters = self.enter(&mut near, &answers);
            if enters {
                *model = near;
            }
            enters
        })
    }

    /// The best wave of ripple, if it explains clearly more than so many waves as a motor has.
    fn clear_wave<'a>(&self, answers: &'a [Answer]) -> Option<&'a Answer> {
        const CLEAR: f64 = 2.0;
        let mut waves = answers
            .iter()
            .filter(|answer| answer.candidate.cause == Cause::Ripple);
        let best = waves.next()?;
        let order = |answer: &Answer| answer.candidate.columns[0].setting;
        let is_other =
            |other: &&Answer| (order(other) - order(best)).abs() * self.range.angle > TAU;
        let other = waves.filter(is_other).nth(Effect::FORCES.len() - 2);
        other
            .is_none_or(|other| best.held_out > CLEAR * other.held_out)
            .then_some(best)
    }

    /// Goes on with the search for the model's values.
    pub(super) fn settle(&self, model: &mut Model) {
        if let Some(fitted) = self.fit(&model.fitted.values, &model.free, &model.fitted) {
            model.fit_is(fitted);
        }
    }

    /// The same of answers in any order.
    pub(super) fn enter_best(&self, model: &mut Model, mut answers: Vec<Answer>) -> bool {
        sort(&mut answers, |answer| answer.held_out);
        self.enter(model, &answers)
    }

    /// Lets the effect of some answers enter that wins; false if none does.
    pub(super) fn enter(&self, model: &mut Model, answers: &[Answer]) -> bool {
        let mut fits = self.fits(model, &self.promising(answers, model));
        let best = |fits: &[Fit], is_meant: &dyn Fn(&Fit) -> bool| {
            let meant = fits.iter().filter(|fit| is_meant(fit));
            let best = meant.reduce(|best, fit| if fit.gain > best.gain { fit } else { best });
            best.cloned()
        };
        let Some(mut won) = best(&fits, &|fit| fit.gain >= MIN_GAIN) else {
            return false;
        };
        if won.free.contains(&Effect::ResonanceFrequency) {
            fits.extend(self.fits(model, &starts_of_modes(answers)));
            won = best(&fits, &|fit| fit.cause == won.cause).unwrap_or(won);
        }
        let mut entered = model.entered.iter_mut();
        if let Some(ripple) = entered.find(|entered| entered.cause == won.cause) {
            ripple.gain += won.gain;
        } else {
            model.entered.push(Entered {
                alternative: best(&fits, &|fit| fit.cause != won.cause)
                    .map(|other| (other.cause, other.gain)),
                ..Entered::certain(won.cause, won.gain)
            });
        }
        (model.free, model.fitted) = (won.free, won.fitted);
        true
    }

    /// Fits of the model with answers, of effects that matter.
    fn fits(&self, model: &Model, answers: &[Answer]) -> Vec<Fit> {
        /// Part of the best gain from which a brief search goes on.
        const NEAR: f64 = 0.5;
        let price = (segments(self.fitter.record.len()) as f64).ln();
        let gain = |(fitted, free): &(Fitted, Vec<Effect>)| {
            let change = model.fitted.sums.minus_two_log_likelihood()
                - fitted.sums.minus_two_log_likelihood();
            change / model.rows_per_row - (free.len() - model.free.len()) as f64 * price
        };
        let brief = parallel::map(answers, |answer| self.with(model, answer, BRIEF));
        let brief: Vec<_> = (answers.iter().zip(brief))
            .filter_map(|(answer, with)| Some((&answer.candidate, with?)))
            .collect();
        let most = (brief.iter()).fold(0.0, |most, (_, with)| f64::max(most, gain(with)));
        let further = parallel::map(&brief, |(candidate, with)| {
            let (fitted, free) = with;
            let with = if gain(with) >= NEAR * most {
                self.inside(model, &fitted.values, free.clone(), SEARCH)?
            } else {
                with.clone()
            };
            let gain = gain(&with);
            let (fitted, free) = with;
            let usual = TypicalMagnitudes::new(self.fitter, &fitted.values);
            let is_one = gain.is_finite() && candidate.matters(&fitted.values, &usual);
            let cause = candidate.cause;
            is_one.then_some(Fit {
                gain,
                cause,
                fitted,
                free,
            })
        });
        further.flatten().collect()
    }

    /// A fit of the model with a candidate, and the effects that are free in it.
    fn with(
        &self,
        model: &Model,
        answer: &Answer,
        search: Search,
    ) -> Option<(Fitted, Vec<Effect>)> {
        let (values, free) =
            answer
                .candidate
                .enter(&model.fitted.values, &model.free, answer, self.range);
        self.inside(model, &values, free, search)
    }

    /// A fit with more effects than a model; none if the record would have one of them beyond its bounds. That is another.
    fn inside(
        &self,
        model: &Model,
        values: &Values,
        free: Vec<Effect>,
        search: Search,
    ) -> Option<(Fitted, Vec<Effect>)> {
        let has_room = free.len() <= MAX_UNKNOWNS;
        let horizon = model.fitted.horizon;
        let fit = || self.fitter.fit(values, &free, horizon, search);
        let fitted = has_room.then(fit)??;
        let errors = fitted.std_errors();
        let mut own = (model.free.len()..free.len()).map(|i| (free[i], errors[i]));
        // But a resonance without damping.
        let is_inside =
            own.all(|(effect, error)| error.is_finite() || effect == Effect::ResonanceDamping);
        is_inside.then_some((fitted, free))
    }

    /// Replaces the shifts of the missing effects by those of fits, not linear algebra, where they may matter.
    pub(super) fn refine(&self, model: &Model, answers: &mut [Answer]) {
        /// Gain from which a shift is worth a fit.
        const MIN_GAIN: f64 = 3.0;
        /// Effects that are fitted.
        const MAX_REFINED: usize = 8;
        let (load, _) = self.fitter.load(&model.fitted, &model.free);
        sort(answers, |answer| answer.gain);
        let mut seen = Vec::new();
        let mut refined: Vec<&mut Answer> = (answers.iter_mut())
            .filter(|answer| {
                let cause = answer.candidate.cause;
                let is_new = answer.is_possible() && !seen.contains(&cause);
                let is_worth = is_new && answer.gain >= MIN_GAIN;
                if is_worth {
                    seen.push(cause);
                }
                is_worth
            })
            .take(MAX_REFINED)
            .collect();
        let fits: Vec<_> =
            parallel::map(&refined, |answer| self.with(model, answer, BRIEF)).collect();
        for (answer, with) in refined.iter_mut().zip(fits) {
            let candidate = &answer.candidate;
            // One that explains less than the model without the effect has not found it.
            let unexplained = |of: &Fitted| of.sums.minus_two_log_likelihood();
            let is_found = |of: &(Fitted, _)| unexplained(&of.0) <= unexplained(&model.fitted);
            let Some((fitted, free)) = with.filter(is_found) else {
                continue;
            };
            let values = &fitted.values;
            let mut load = self.fitter.load(&fitted, &free).0 - load;
            if candidate.cause == Cause::Gravity {
                let sizes = candidate
                    .columns
                    .iter()
                    .map(|column| values.get(column.effect));
                load += self.range.mean_gravity(sizes);
            }
            answer.shifts = (model.free.iter())
                .map(|&effect| match effect {
                    Effect::Load => load,
                    _ => values.get(effect) - model.fitted.values.get(effect),
                })
                .collect();
        }
    }

    pub(super) fn fit(&self, values: &Values, free: &[Effect], at: &Fitted) -> Option<Fitted> {
        self.fitter.fit(values, free, at.horizon, SEARCH)
    }

    /// The answers of all candidates that have not entered, the most convincing first.
    pub(super) fn answers(&self, model: &Model) -> Vec<Answer> {
        self.answers_of(model, &Candidate::all(self.range, &model.free))
    }

    fn answers_of(&self, model: &Model, candidates: &[Candidate]) -> Vec<Answer> {
        // Two columns at most each, beside those of the model.
        let at_once = (MAX_COLUMNS - model.free.len()) / 2;
        let parts: Vec<&[Candidate]> = candidates.chunks(at_once).collect();
        let scanned = parallel::map(&parts, |some| scan(self.fitter, model, self.range, some));
        let mut answers: Vec<Answer> = scanned.flatten().collect();
        sort(&mut answers, |answer| answer.held_out);
        answers
    }

    /// The answers that are worth a fit, one of each cause.
    fn promising(&self, answers: &[Answer], model: &Model) -> Vec<Answer> {
        /// Held-out gain, and of each of its sizes, and χ², from which an effect is worth a fit.
        const MIN_HELD_OUT: [f64; 2] = [10.0, 4.0];
        const MIN_SIGNIFICANCE: f64 = 12.0;
        const MIN_CONSISTENCY: f64 = 2.0;
        /// A current loop looks like the delay that is in the model already. It is fitted in any case, samples.
        const MIN_LAG_DELAY: f64 = 0.3;
        let is_worth = |answer: &&Answer| {
            let sizes = answer.sizes.len() as f64;
            answer.held_out * model.rows_per_row > MIN_HELD_OUT[0] + MIN_HELD_OUT[1] * sizes
                && answer.consistency > MIN_CONSISTENCY
                && answer.significance > MIN_SIGNIFICANCE
        };
        let best = answers
            .iter()
            .find(is_worth)
            .map_or(0.0, |best| best.held_out);
        let mut promising: Vec<&Answer> = Vec::new();
        for answer in answers.iter().filter(is_worth) {
            let cause = answer.candidate.cause;
            let form = |answer: &Answer| (answer.candidate.is_stiff(), answer.sizes.len());
            let is_new = (promising.iter())
                .all(|other| (other.candidate.cause, form(other)) != (cause, form(answer)));
            let is_weak = answer.held_out < MIN_SHARE * best && cause != Cause::CurrentLoop;
            if is_new && !is_weak && promising.len() < MAX_FITTED {
                promising.push(answer);
            }
        }
        // Linear algebra does not show what friction has absorbed: a dead band is fitted once in any case.
        let band = answers
            .iter()
            .find(|answer| answer.candidate.cause == Cause::DeadBand);
        let is_new = |band: &&Answer| {
            promising
                .iter()
                .all(|other| other.candidate.cause != band.candidate.cause)
        };
        promising.extend(band.filter(|band| model.entered.is_empty() && is_new(band)));
        let delayed = model.fitted.values.get(Effect::Delay) - self.fitter.earliest.max(0.0);
        let lag = answers
            .iter()
            .find(|answer| answer.candidate.cause == Cause::CurrentLoop && delayed > MIN_LAG_DELAY);
        if let Some(lag) = lag
            && promising
                .iter()
                .all(|other| other.candidate.cause != Cause::CurrentLoop)
        {
            promising.push(lag);
        }
        promising.into_iter().cloned().collect()
    }
}

/// A fit of a model with an effect.
#[derive(Clone)]
struct Fit {
    gain: f64,
    cause: Cause,
    fitted: Fitted,
    free: Vec<Effect>,
}

/// Answers from which fits of a second mass begin: at every frequency that is looked at, with a light load and the encoder on
/// either side. Its likelihood has many peaks, of which linear algebra does not know the highest.
fn starts_of_modes(answers: &[Answer]) -> Vec<Answer> {
    /// β of [`SecondMode`](super::SecondMode).
    const RATIOS: [f64; 2] = [0.5, -0.5];
    let is_mode = |of: &&Answer| of.candidate.is_mode();
    let starts = answers.iter().filter(is_mode).flat_map(|answer| {
        let frequency = answer.candidate.columns[0].setting;
        RATIOS.map(|ratio| Answer {
            sizes: vec![ratio / (frequency * frequency)],
            ..answer.clone()
        })
    });
    starts.collect()
}

/// Sorts answers, the largest first.
fn sort(answers: &mut [Answer], by: fn(&Answer) -> f64) {
    // There are few, and a browser loads no other sort for them.
    for end in 1..answers.len() {
        let mut place = end;
        while place > 0
            && by(&answers[place - 1])
                .total_cmp(&by(&answers[place]))
                .is_lt()
        {
            answers.swap(place - 1, place);
            place -= 1;
        }
    }
}
