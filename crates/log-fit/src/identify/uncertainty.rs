//! The covariance of the estimates' errors: chance and autocorrelation, effects that the record leaves open, and the
//! choice of the horizon. Whatever moves several estimates at once is one direction in it, so standard errors and
//! correlations are of the same parts.

use crate::fit::{
    Effect, Fitted, Horizon, MAX_UNKNOWNS, Matrix, QUANTISATION_SIGMA, RecordFitter, Search,
    Values, Vector,
};

use super::candidate::{Answer, TypicalMagnitudes};
use super::model::Model;
use crate::cause::Cause;
use crate::parallel;

/// The parts of the covariance beside chance, autocorrelation, rounding and effects that may be missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ErrorBudget {
    /// True if it holds the spread over the horizons, which takes two fits.
    pub(super) has_spread: bool,
    /// True if an estimate of exactly zero friction or dead band gets the error that the other unknowns imply, and is
    /// not unknown.
    pub(super) bounds_at_zero_are_exact: bool,
}

impl ErrorBudget {
    /// Everything, for a servo that is identified.
    pub(super) const ALL: Self = Self {
        has_spread: true,
        bounds_at_zero_are_exact: false,
    };
}

/// The share of quantisation that is proportional to a motion with a deviation of one count. It makes the motion appear
/// larger or smaller. No length of a record averages it out. It falls with the square root of the deviation, as the
/// first harmonic of a rounded sine does (the asymptote of Bessel's function, 0.3). Over the amplitudes of a motion its
/// sign changes. For drawn servos that move by one to four counts, b is off by a third of it.
const SYSTEMATIC_ROUNDING: f64 = 0.1;

/// Adds errors that are one: each unknown is off by its part of `shift`.
pub(super) fn add(covariance: &mut Matrix, shift: &[f64], weight: f64) {
    for (row, one) in covariance.iter_mut().zip(shift) {
        for (entry, other) in row.iter_mut().zip(shift) {
            *entry += weight * one * other;
        }
    }
}

/// The covariance of a fit by chance and autocorrelation. Zero for unknowns that stand at a bound.
pub(super) fn by_chance(fitter: &RecordFitter<'_>, fitted: &Fitted, free: &[Effect]) -> Matrix {
    let held = fitter.held(&fitted.values, free, fitted.horizon, &fitted.sums);
    let mut covariance = fitted.sums.correlations(&held);
    let own = fitted
        .std_errors()
        .map(|own| if own.is_finite() { own } else { 0.0 });
    for (row, one) in covariance.iter_mut().zip(own) {
        for (entry, other) in row.iter_mut().zip(own) {
            *entry *= one * other;
        }
    }
    covariance
}

/// The covariance of the free effects, in their order; infinite on its diagonal where nothing is known of one. The second
/// list holds those whose error is mostly from effects that a command of other sizes would determine. The argument
/// `load` is the load's error by chance and autocorrelation.
///
/// C = sandwich + rounding + ∑ w shift shiftᵀ + spread spreadᵀ. A missing effect counts by its probability w (Hoeting,
/// Madigan, Raftery and Volinsky, "Bayesian model averaging", Statistical Science 14(4), 1999). The spread is the shift
/// of the estimates beyond chance if the horizon of the filter is a quarter or four times as long. Its literature is
/// Hausman, "Specification tests in econometrics", Econometrica 46(6), 1978.
pub(super) fn covariance(
    fitter: &RecordFitter<'_>,
    model: &Model,
    load: f64,
    answers: &[Answer],
    beyond: ErrorBudget,
) -> (Matrix, Vec<Effect>) {
    let Model { free, fitted, .. } = model;
    let count = free.len();
    let own = fitted.std_errors();
    let sums = &fitted.sums;
    let alone = |i: usize| {
        let variance = sums.noise() / sums.hessian[i][i].max(f64::MIN_POSITIVE);
        variance * model.rows_per_row
    };
    let bounds_at_zero_are_exact =
        |i: usize| beyond.bounds_at_zero_are_exact && !own[i].is_finite();
    // At its bound a friction is as uncertain as it were without one.
    let unbounded = sums.covariances(&[false; MAX_UNKNOWNS]).variances;
    let mut covariance = by_chance(fitter, fitted, free);
    for i in 0..count {
        covariance[i][i] = match free[i] {
            Effect::Load => load * load,
            // None is a bound at which everything else is free.
            Effect::Delay if !own[i].is_finite() => alone(i),
            Effect::Coulomb | Effect::DeadBand if bounds_at_zero_are_exact(i) => alone(i),
            Effect::A | Effect::Coulomb if !own[i].is_finite() => unbounded[i],
            _ => own[i] * own[i],
        };
    }
    let rounding =
        SYSTEMATIC_ROUNDING * QUANTISATION_SIGMA * fitter.statistics.amplitude().powf(-1.5);
    let larger = |&effect: &Effect| match effect {
        Effect::B | Effect::Coulomb | Effect::Load => rounding * fitted.values.get(effect),
        _ => 0.0,
    };
    add(
        &mut covariance,
        &free.iter().map(larger).collect::<Vec<_>>(),
        1.0,
    );
    let usual = TypicalMagnitudes::new(fitter, &fitted.values);
    let of_command = add_missing(&mut covariance, answers, &usual);
    if beyond.has_spread {
        add(&mut covariance, &spread(fitter, model), 1.0);
    }
    let needs_more_amplitudes = (0..count)
        .filter(|&i| of_command[i] > 0.5 * covariance[i][i])
        .map(|i| free[i]);
    (covariance, needs_more_amplitudes.collect())
}

/// Adds the shifts by effects that may be missing. The result is the variances by those that depend on the size of the
/// command.
///
/// Each has a usual size s₀ that is known beforehand, and the record estimates ŝ ± σ. Bayes' factor gives the odds that
/// it exists, √(σ²/(σ² + s₀²)) exp(½ ŝ²/σ² s₀²/(s₀² + σ²)), times [the prior
/// odds](super::candidate::Candidate::prior_odds). Its size is then ŝ s₀²/(s₀² + σ²) ± (1/s₀² + 1/σ²)^−½. Effects of
/// one [kind](Kind) explain the same part of a record and share its weight, because only one of them exists. Those of
/// another kind may be missing beside them. So may the part of a size that the record leaves open.
fn add_missing(covariance: &mut Matrix, answers: &[Answer], usual: &TypicalMagnitudes) -> Vector {
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
    let mut of_command = [0.0; MAX_UNKNOWNS];
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
        add(covariance, one.shifts, weight);
        if goes_with_size(one.cause) {
            for (sum, shift) in of_command.iter_mut().zip(one.shifts) {
                *sum += weight * shift * shift;
            }
        }
    }
    of_command
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

/// The shifts by another horizon, beyond chance.
fn spread(fitter: &RecordFitter<'_>, model: &Model) -> Vec<f64> {
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
    let load = |fitted: &Fitted| fitter.load(fitted, &model.free).0;
    let fits = parallel::map(&others, |&horizon| {
        fitter.fit(&model.fitted.values, &model.free, horizon, SEARCH)
    });
    let shifts = fits.map(|other| {
        let Some(other) = other else {
            return vec![0.0; own.len()];
        };
        let errors = other.std_errors();
        let free = model.free.iter().enumerate();
        let shift = |(i, effect): (usize, &Effect)| {
            let of = |fitted: &Fitted| fitted.values.get(*effect);
            let shift = match effect {
                Effect::Load => load(&other) - load(&model.fitted),
                _ => of(&other) - of(&model.fitted),
            };
            let chance = if errors[i].is_finite() && own[i].is_finite() {
                (errors[i] * errors[i] - own[i] * own[i]).abs()
            } else if *effect == Effect::Load {
                0.0
            } else {
                f64::INFINITY
            };
            (shift * shift - chance).max(0.0).sqrt().copysign(shift)
        };
        free.map(shift).collect()
    });
    farther(shifts)
}

/// Of the shifts to two opposite sides the larger of each unknown, as one direction.
fn farther(mut sides: impl Iterator<Item = Vec<f64>>) -> Vec<f64> {
    let [low, high] = [sides.next(), sides.next()].map(Option::unwrap_or_default);
    let larger = |(low, high): (f64, f64)| if low.abs() > high.abs() { -low } else { high };
    low.into_iter().zip(high).map(larger).collect()
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
    pub(super) fn new(fitter: &RecordFitter<'_>, model: &Model) -> Self {
        let mut fits = parallel::map(&[0.8, 1.25], |&factor| increase(fitter, model, factor));
        let sides = [fits.next(), fits.next()].map(|fit| fit.unwrap_or((f64::NAN, None)));
        Self {
            increases: sides.map(|(increase, _)| increase),
            values: sides.map(|(_, values)| values),
        }
    }

    /// The errors are as wide as the valley along b, of which the curvature at its bottom tells little where friction holds
    /// and releases the servo, or where b is barely separated from the rest.
    pub(super) fn widen(&self, model: &Model, covariance: &mut Matrix) {
        /// An increase below which the valley has no end: 25 times b is open.
        const FLAT: f64 = 1e-4;
        let sides = self
            .increases
            .iter()
            .zip(self.values)
            .map(|(increase, values)| {
                // The part of the way to this side that is one standard error.
                let part = 1.0 / increase.max(FLAT).sqrt();
                let way = |&effect: &Effect| {
                    values.map_or(0.0, |values| {
                        part * (values.get(effect) - model.fitted.values.get(effect))
                    })
                };
                model.free.iter().map(way).collect()
            });
        let farther = farther(sides);
        let by_curvature = model.fitted.std_errors();
        for (i, _) in (model.free.iter().enumerate()).filter(|(_, effect)| **effect == Effect::B) {
            let known = by_curvature[i] / farther[i];
            add(covariance, &farther, (1.0 - known * known).max(0.0));
        }
    }
}

/// The increase at one multiple, and the values there.
fn increase(fitter: &RecordFitter<'_>, model: &Model, factor: f64) -> (f64, Option<Values>) {
    const SEARCH: Search = Search {
        steps: 5,
        tolerance: 1e-6,
    };
    let mut values = model.fitted.values;
    let forces = [Effect::B, Effect::Coulomb, Effect::Load, Effect::LowSpeed];
    for effect in forces.iter().chain(Effect::FORCES.as_flattened()) {
        let effect = *effect;
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
    use super::super::{Axis, Logged, Recording, Way};
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
        let recording = Recording::new(&samples, Axis::new(1000.0, Way::Path { length: 2.0 }));
        let record = recording.record();
        let fitter = RecordFitter::new(&record).expect("a motion");
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
        let open = |size, gain| {
            let mut covariance = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
            add_missing(&mut covariance, &[answer(size, gain)], &usual);
            covariance[0][0].sqrt()
        };
        let usual_size = answer(1.0, 1.0).candidate.usual_size(&usual);
        for (size, gain) in [(1e-2, 1e-6), (1e-11, 1e-24)] {
            let found = open(size, gain);
            let of_usual = found / usual_size;
            assert!((0.4..0.6).contains(&of_usual), "{size}: {of_usual}");
        }
        assert!(open(1e-4, 1e-2) < 0.05 * usual_size);
    }
}
