//! Standard errors that hold: chance and colour, effects that are missing, and the choice of the horizon.

use identifier_core::identification::{Effect, Fitter, Horizon, Search, segments};

use super::scan::Answer;
use super::tournament::Model;

/// The part of a usual size to which a servo is its model.
const MODEL_ACCURACY: f64 = 1e-3;

/// Standard errors of the free effects, in their order; `inseparable` is the part of a load that may be gravity.
///
/// σ² = sandwich + ideal² + ∑ w shift² + spread²: no servo is its model to better than a thousandth (jitter of
/// the samples, an encoder off its centre, the command's shape within a sample), which no length of a record shows; a missing effect counts by its probability (Hoeting,
/// Madigan, Raftery and Volinsky, "Bayesian model averaging", Statistical Science 14(4), 1999), and the
/// spread is by how much the estimates move beyond chance where the filter trusts the model over a quarter of
/// the horizon or four times it (Hausman, "Specification tests in econometrics", Econometrica 46(6), 1978).
pub(super) fn std_errors(
    fitter: &Fitter<'_>,
    model: &Model,
    answers: &[Answer],
    inseparable: f64,
) -> Vec<f64> {
    let count = model.free.len();
    let own = model.fitted.std_errors();
    let missing = missing(answers, count, fitter.record.len());
    let spread = spread(fitter, model);
    let (_, load) = fitter.load(&model.fitted, &model.free);
    let load = load.hypot(inseparable);
    let sums = &model.fitted.sums;
    (0..count)
        .map(|i| {
            let own = match model.free[i] {
                Effect::Load => load,
                // No delay is a bound at which everything else is free.
                Effect::Delay if !own[i].is_finite() => {
                    let variance = sums.noise() / sums.hessian[i][i].max(f64::MIN_POSITIVE);
                    (variance * model.rows_per_row).sqrt()
                }
                _ => own[i],
            };
            let ideal = MODEL_ACCURACY * fitter.usual_size(&model.fitted.values, model.free[i]);
            (own * own + ideal * ideal + missing[i] + spread[i]).sqrt()
        })
        .collect()
}

/// Squares of the shifts by the effect that may be missing, each weighted by the probability that it is the one:
/// two that explain the same of the record share its weight.
fn missing(answers: &[Answer], count: usize, samples: usize) -> Vec<f64> {
    /// χ² of a size that chance gives one time in twenty.
    const CHANCE: f64 = 4.0;
    let price = (segments(samples) as f64).ln();
    let mut seen = Vec::new();
    let mut by_gain: Vec<&Answer> = answers.iter().collect();
    by_gain.sort_by(|one, other| other.gain.total_cmp(&one.gain));
    let mut missing: Vec<(f64, &[f64])> = Vec::new();
    for answer in by_gain {
        let cause = answer.candidate.cause;
        if seen.contains(&cause) {
            continue;
        }
        seen.push(cause);
        let ratio = answer.significance.min(answer.gain);
        // What chance alone gives moves an estimate far where the two look alike.
        if ratio >= CHANCE * answer.sizes.len() as f64 {
            let log_odds = 0.5 * (ratio - answer.sizes.len() as f64 * price - 2.0);
            missing.push((log_odds, &answer.shifts));
        }
    }
    // A model that lacks nothing has odds of one.
    let likeliest = missing
        .iter()
        .fold(0.0_f64, |most, (odds, _)| most.max(*odds));
    let odds = |log_odds: f64| (log_odds - likeliest).exp();
    let all = odds(0.0) + missing.iter().map(|one| odds(one.0)).sum::<f64>();
    let mut sum = vec![0.0; count];
    for (log_odds, shifts) in missing {
        for (sum, shift) in sum.iter_mut().zip(shifts) {
            *sum += odds(log_odds) / all * shift * shift;
        }
    }
    sum
}

/// Squares of the shifts by another horizon, beyond chance.
fn spread(fitter: &Fitter<'_>, model: &Model) -> Vec<f64> {
    const SEARCH: Search = Search {
        steps: 4,
        tolerance: 1e-6,
    };
    let samples = fitter.record.len();
    let shortest = fitter.survey.shortest_horizon(samples);
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
    for horizon in others {
        let Some(other) = fitter.fit(&model.fitted.values, &model.free, horizon, SEARCH) else {
            continue;
        };
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

/// The increase of −2 ln L in independent rows where b is fixed at a multiple of itself and the rest is fitted
/// again.
pub(super) fn profile(fitter: &Fitter<'_>, model: &Model, factor: f64) -> f64 {
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
    let Some((_, sums)) = fitter.search(&values, &rest, model.fitted.horizon, SEARCH) else {
        return f64::INFINITY;
    };
    (sums.squares - model.fitted.sums.squares) / (model.fitted.sums.noise() * model.rows_per_row)
}
