//! Standard errors that hold: chance and autocorrelation, effects that are missing, and the choice of the horizon.

use crate::fit::{Effect, Fitter, Horizon, MAX_UNKNOWNS, QUANTISATION_SIGMA, Search, Values};

use super::candidate::{Answer, TypicalMagnitudes};
use super::model::Model;
use crate::cause::Cause;
use crate::parallel;

/// The parts of standard errors beside chance, autocorrelation, rounding and effects that may be missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ErrorBudget {
    /// The part of a usual size to which a servo is its model.
    pub(super) accuracy: f64,
    /// True if they hold the spread over the horizons, which takes two fits.
    pub(super) has_spread: bool,
    /// True if an estimate of exactly zero friction or dead band gets the error that the other unknowns imply, and is
    /// not unknown.
    pub(super) bounds_at_zero_are_exact: bool,
}

impl ErrorBudget {
    /// Everything, for a servo that is identified.
    pub(super) const ALL: Self = Self {
        accuracy: 1e-3,
        has_spread: true,
        bounds_at_zero_are_exact: false,
    };
}

/// The share of quantisation that is proportional to a motion with a deviation of one count. It makes the motion appear
/// larger or smaller. No length of a record averages it out. It falls with the square root of the deviation, as the
/// first harmonic of a rounded sine does (the asymptote of Bessel's function, 0.3). Over the amplitudes of a motion its
/// sign changes. For drawn servos that move by one to four counts, b is off by a third of it.
const SYSTEMATIC_ROUNDING: f64 = 0.1;

/// Standard errors of the free effects, in their order. The second list holds those whose error is mostly from effects
/// that a command of other sizes would determine. The argument `load` is the load's error by chance and
/// autocorrelation.
///
/// σ² = sandwich + ideal² + ∑ w shift² + spread². The term ideal: no servo matches its model to better than a
/// thousandth. Sampling jitter, an eccentric encoder and the command's shape within a sample remain; no length of
/// record reveals them. A missing effect counts by its probability w (Hoeting, Madigan, Raftery and Volinsky, "Bayesian
/// model averaging", Statistical Science 14(4), 1999). The spread is the shift of the estimates beyond chance if the
/// horizon of the filter is a quarter or four times as long. Its literature is Hausman, "Specification tests in
/// econometrics", Econometrica 46(6), 1978.
pub(super) fn std_errors(
    fitter: &Fitter<'_>,
    model: &Model,
    load: f64,
    answers: &[Answer],
    beyond: ErrorBudget,
) -> (Vec<f64>, Vec<Effect>) {
    let count = model.free.len();
    let own = model.fitted.std_errors();
    let missing = missing(
        answers,
        count,
        &TypicalMagnitudes::new(fitter, &model.fitted.values),
    );
    let spread = if beyond.has_spread {
        spread(fitter, model)
    } else {
        vec![0.0; count]
    };
    let sums = &model.fitted.sums;
    let rounding =
        SYSTEMATIC_ROUNDING * QUANTISATION_SIGMA * fitter.statistics.amplitude().powf(-1.5);
    let alone = |i: usize| {
        let variance = sums.noise() / sums.hessian[i][i].max(f64::MIN_POSITIVE);
        (variance * model.rows_per_row).sqrt()
    };
    let bounds_at_zero_are_exact =
        |i: usize| beyond.bounds_at_zero_are_exact && !own[i].is_finite();
    // At its bound a friction is as uncertain as it were without one.
    let unbounded = sums.covariances(&[false; MAX_UNKNOWNS]).variances;
    let mut needs_more_amplitudes = Vec::new();
    let std_errors = (0..count)
        .map(|i| {
            let own = match model.free[i] {
                Effect::Load => load,
                // None is a bound at which everything else is free.
                Effect::Delay if !own[i].is_finite() => alone(i),
                Effect::Coulomb | Effect::DeadBand if bounds_at_zero_are_exact(i) => alone(i),
                Effect::A | Effect::Coulomb if !own[i].is_finite() => unbounded[i].sqrt(),
                _ => own[i],
            };
            let ideal = beyond.accuracy * fitter.usual_size(&model.fitted.values, model.free[i])
                + match model.free[i] {
                    Effect::B | Effect::Coulomb | Effect::Load => {
                        rounding * model.fitted.values.get(model.free[i]).abs()
                    }
                    _ => 0.0,
                };
            let [all, of_command] = missing[i];
            let variance = own * own + ideal * ideal + all + spread[i];
            if of_command > 0.5 * variance {
                needs_more_amplitudes.push(model.free[i]);
            }
            variance.sqrt()
        })
        .collect();
    (std_errors, needs_more_amplitudes)
}

/// Squares of the shifts by effects that may be missing: by all, and by those that depend on the size of the command.
///
/// Each has a usual size s₀ that is known beforehand, and the record estimates ŝ ± σ. Bayes' factor gives the odds that
/// it exists, √(σ²/(σ² + s₀²)) exp(½ ŝ²/σ² s₀²/(s₀² + σ²)), times [the prior
/// odds](super::candidate::Candidate::prior_odds). Its size is then ŝ s₀²/(s₀² + σ²) ± (1/s₀² + 1/σ²)^−½. Effects of
/// one [kind](Kind) explain the same part of a record and share its weight, because only one of them exists. Those of
/// another kind may be missing beside them. So may the part of a size that the record leaves open.
fn missing(answers: &[Answer], count: usize, usual: &TypicalMagnitudes) -> Vec<[f64; 2]> {
    /// An effect that is possible.
    struct Missing<'a> {
        cause: Cause,
        log_odds: f64,
        /// Squares of its size over ŝ²: of that which was found, and of that which is open.
        found: f64,
        open: f64,
        shifts: &'a [f64],
    }
    // Of each cause the likeliest form counts: those of a limit between the same two sizes of a command are one.
    let mut left: Vec<&Answer> = answers.iter().collect();
    let likelihood = |one: &&Answer, other: &&Answer| {
        let by_sign = one.is_possible().cmp(&other.is_possible());
        by_sign.then(one.gain.total_cmp(&other.gain))
    };
    let mut missing: Vec<Missing<'_>> = Vec::new();
    while let Some(answer) = left.iter().copied().max_by(likelihood) {
        let candidate = &answer.candidate;
        left.retain(|other| other.candidate.cause != candidate.cause);
        let sizes = answer.sizes.len() as f64;
        let square: f64 = answer.sizes.iter().map(|size| size * size).sum();
        let ratio = answer.significance.min(answer.gain).max(f64::MIN_POSITIVE);
        // Variances over ŝ².
        let own = sizes / ratio;
        let before = candidate.usual_size(usual).powi(2) / square.max(f64::MIN_POSITIVE);
        let kept = before / (before + own);
        let (log_factor, found) = if answer.is_possible() {
            let narrowed = sizes * (own / (before + own)).max(f64::MIN_POSITIVE).ln();
            // For an effect of z standard errors, the gain in segments to which it was not fitted scatters by 2z.
            let agreed = (2.0 * answer.consistency.max(0.0)).powi(2);
            (0.5 * (ratio.min(agreed) * kept + narrowed), kept * kept)
        } else {
            // It is there if chance made its size negative, and is small.
            (-0.5 * ratio, 0.0)
        };
        missing.push(Missing {
            cause: candidate.cause,
            log_odds: log_factor + candidate.prior_odds().ln(),
            found,
            open: before * (1.0 - kept),
            shifts: &answer.shifts,
        });
    }
    let mut sums = vec![[0.0; 2]; count];
    for one in &missing {
        // A model that lacks nothing of the kind has odds of one.
        let none = (-one.log_odds).exp();
        let same = missing
            .iter()
            .filter(|other| Kind::of(other.cause) == Kind::of(one.cause));
        let all: f64 = same
            .map(|other| (other.log_odds - one.log_odds).exp())
            .sum();
        let weight = one.found / (none + all) + one.open / (none + 1.0);
        let goes_with_size = goes_with_size(one.cause);
        for ([all, of_command], shift) in sums.iter_mut().zip(one.shifts) {
            let square = weight * shift * shift;
            *all += square;
            if goes_with_size {
                *of_command += square;
            }
        }
    }
    sums
}

/// True of an effect that a command of a single size does not separate from gain, friction and load.
const fn goes_with_size(cause: Cause) -> bool {
    matches!(
        cause,
        Cause::DeadBand | Cause::LoadFriction | Cause::GainAsymmetry | Cause::HiddenLimit
    )
}

/// The quantity of a motion on which an effect depends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// The velocity, as friction.
    Velocity,
    /// The command.
    Command,
    /// The angle.
    Angle,
}

impl Kind {
    const fn of(cause: Cause) -> Self {
        match cause {
            Cause::Load
            | Cause::Gravity
            | Cause::Ripple
            | Cause::TorqueRipple
            | Cause::VaryingInertia
            | Cause::Eccentricity => Self::Angle,
            Cause::Asymmetry
            | Cause::QuadraticFriction
            | Cause::LowSpeedFriction
            | Cause::FrictionDrift
            | Cause::Coulomb
            | Cause::LoadFriction => Self::Velocity,
            _ => Self::Command,
        }
    }
}

/// Squares of the shifts by another horizon, beyond chance.
fn spread(fitter: &Fitter<'_>, model: &Model) -> Vec<f64> {
    const SEARCH: Search = Search {
        steps: 4,
        tolerance: 1e-6,
    };
    let samples = fitter.record.len();
    let shortest = fitter.statistics.shortest_horizon(samples);
    let longest = samples as f64 / 5.0;
    let at = model.fitted.horizon;
    let others = match at.walk {
        None => [0.25, 4.0].map(|factor| Horizon {
            white: (at.white * factor).clamp(shortest, longest.max(shortest)),
            walk: None,
        }),
        Some(walk) => [0.4, 2.5].map(|factor| Horizon {
            walk: Some((walk * factor).clamp((0.5 * shortest).max(4.0), longest)),
            ..at
        }),
    };
    let own = model.fitted.std_errors();
    let mut spread = vec![0.0_f64; model.free.len()];
    let fits = parallel::map(&others, |&horizon| {
        fitter.fit(&model.fitted.values, &model.free, horizon, SEARCH)
    });
    for other in fits.flatten() {
        let errors = other.std_errors();
        for (i, effect) in model.free.iter().enumerate() {
            let shift = if *effect == Effect::Load {
                fitter.load(&other, &model.free).0 - fitter.load(&model.fitted, &model.free).0
            } else {
                other.values.get(*effect) - model.fitted.values.get(*effect)
            };
            if !errors[i].is_finite() || !own[i].is_finite() {
                spread[i] = spread[i].max(if *effect == Effect::Load {
                    shift * shift
                } else {
                    0.0
                });
                continue;
            }
            let chance = (errors[i] * errors[i] - own[i] * own[i]).abs();
            let beyond = shift * shift - chance;
            if beyond.is_finite() {
                spread[i] = spread[i].max(beyond);
            }
        }
    }
    spread
}

/// The least increase of −2 ln L for a gain a quarter off. Below it the curvature at the best gain does not give its
/// uncertainty.
pub const SEPARATED: f64 = 9.0;

/// Fits with b fixed beside its estimate.
pub(super) struct Profile {
    /// The increases of −2 ln L in independent rows at 0.8 and 1.25 of it.
    pub(super) increases: [f64; 2],
    values: [Option<Values>; 2],
}

impl Profile {
    /// Fixes b at either multiple and fits the rest again.
    pub(super) fn new(fitter: &Fitter<'_>, model: &Model) -> Self {
        let mut fits = parallel::map(&[0.8, 1.25], |&factor| increase(fitter, model, factor));
        let sides = [fits.next(), fits.next()].map(|fit| fit.unwrap_or((f64::NAN, None)));
        Self {
            increases: sides.map(|(increase, _)| increase),
            values: sides.map(|(_, values)| values),
        }
    }

    /// If b is barely separated from the rest, the valley is no parabola. The errors are then as wide as the valley.
    pub(super) fn widen(&self, model: &Model, std_errors: &mut [f64]) {
        if self.increases.iter().all(|increase| *increase >= SEPARATED) {
            return;
        }
        for (increase, values) in self.increases.iter().zip(&self.values) {
            // The part of the way to this side that is one standard error.
            let part = 1.0 / increase.max(f64::MIN_POSITIVE).sqrt();
            for (error, &effect) in std_errors.iter_mut().zip(&model.free) {
                let travel = values.map_or(f64::INFINITY, |values| {
                    (values.get(effect) - model.fitted.values.get(effect)).abs()
                });
                if travel > 0.0 {
                    *error = error.max(travel * part);
                }
            }
        }
    }
}

/// The increase at one multiple, and the values there.
fn increase(fitter: &Fitter<'_>, model: &Model, factor: f64) -> (f64, Option<Values>) {
    const SEARCH: Search = Search {
        steps: 5,
        tolerance: 1e-6,
    };
    let mut values = model.fitted.values;
    for effect in [
        Effect::B,
        Effect::Coulomb,
        Effect::Load,
        Effect::LowSpeed,
        Effect::GravitySine,
        Effect::GravityCosine,
        Effect::RippleSine,
        Effect::RippleCosine,
    ] {
        values.set(effect, values.get(effect) * factor);
    }
    let rest: Vec<Effect> = (model.free.iter().copied())
        .filter(|&effect| effect != Effect::B)
        .collect();
    let Some((values, sums)) = fitter.search(&values, &rest, model.fitted.horizon, SEARCH) else {
        return (f64::INFINITY, None);
    };
    let own = &model.fitted.sums;
    let increase = (sums.squares - own.squares) / (own.noise() * model.rows_per_row);
    (increase, Some(values))
}

#[cfg(test)]
mod tests {
    use super::super::candidate::Candidate;
    use super::super::{Logged, Recording};
    use super::*;

    /// A record leaves a size open that it barely shows. The same holds for one that equals the model's own but for
    /// rounding.
    #[test]
    fn a_size_that_a_record_does_not_tell_is_open_at_any_rounding() {
        let sample = |k: i32| Logged {
            position: (0.02 * f64::from(k)).sin(),
            command: -(0.02 * f64::from(k)).sin(),
            begins: k == 0,
        };
        let samples: Vec<Logged> = (0..500).map(sample).collect();
        let recording = Recording::new(&samples, 1000.0, 0.0);
        let record = recording.record();
        let fitter = Fitter::new(&record).expect("a motion");
        let usual = TypicalMagnitudes::new(&fitter, &Values::NONE.with(Effect::B, 0.4));
        let answer = |size: f64, gain: f64| Answer {
            candidate: Candidate::plain(Cause::LoadFriction, &[Effect::LoadFriction]),
            held_out: 0.0,
            consistency: 0.0,
            gain,
            significance: gain,
            sizes: vec![size],
            // A unit of it moves the parameter by one.
            shifts: vec![-size],
        };
        let open = |size, gain| missing(&[answer(size, gain)], 1, &usual)[0][0].sqrt();
        let usual_size = answer(1.0, 1.0).candidate.usual_size(&usual);
        for (size, gain) in [(1e-2, 1e-6), (1e-11, 1e-24)] {
            let found = open(size, gain);
            let of_usual = found / usual_size;
            assert!((0.4..0.6).contains(&of_usual), "{size}: {of_usual}");
        }
        assert!(open(1e-4, 1e-2) < 0.05 * usual_size);
    }
}
