//! The score test: how much of the rest each candidate explains that no unknown of the model does, and
//! where the unknowns would be with it (Rao, "Large sample tests of statistical hypotheses", 1948).

use crate::result::Finding;
use identifier_core::parameters::Unknown;

use super::effect::Effect;
use super::least_squares::{Basis, dot};
use super::{Fit, GROUPS, Judged};

/// The best candidate of each cause, by the share that it explains, most first.
pub(super) fn findings(
    judged: &Judged<'_>,
    fit: &Fit,
    candidates: &[Vec<Effect>],
    columns: &[Vec<f64>],
    swing: f64,
) -> Vec<Finding> {
    let mut columns = columns.iter();
    let mut findings: Vec<Finding> = Vec::new();
    for effects in candidates {
        let columns: Vec<&Vec<f64>> = columns.by_ref().take(effects.len()).collect();
        let found = finding(judged, fit, effects, &columns);
        let Some(finding) = found.filter(|found| {
            let machine = found.size / effects[0].si(&judged.scenario.units()).0;
            effects[0].can_be(machine, swing)
        }) else {
            continue;
        };
        match findings
            .iter_mut()
            .find(|known| known.cause == finding.cause)
        {
            Some(known) if known.share < finding.share => *known = finding,
            Some(_) => {}
            None => findings.push(finding),
        }
    }
    findings.sort_by(|x, y| y.share.total_cmp(&x.share));
    findings
}

fn finding(
    judged: &Judged<'_>,
    fit: &Fit,
    effects: &[Effect],
    columns: &[&Vec<f64>],
) -> Option<Finding> {
    /// A candidate of which less than this part is left, without the unknowns, is one of them.
    const MIN_INDEPENDENT_SHARE: f64 = 1e-4;
    let mut coefficients = Vec::new();
    let mut own_parts = Vec::new();
    for column in columns {
        let mut left = fit.whitening.apply(column);
        let whole = dot(&left, &left).sqrt();
        own_parts.push(fit.own.take_from(&mut left));
        let apart = dot(&left, &left).sqrt();
        if !apart.is_finite() || apart <= MIN_INDEPENDENT_SHARE * whole {
            return None;
        }
        coefficients.push(left);
    }
    let basis = Basis::new(coefficients.clone());
    let mut rest = fit.rest.clone();
    let sizes = basis.multiples(&basis.take_from(&mut rest));
    let before = dot(&fit.rest, &fit.rest);
    let share = 1.0 - dot(&rest, &rest) / before;
    // The candidate with its parts as they are found.
    let whole: Vec<f64> = (0..fit.rest.len())
        .map(|k| {
            coefficients
                .iter()
                .zip(&sizes)
                .map(|(column, size)| size * column[k])
                .sum()
        })
        .collect();
    let units = judged.scenario.units();
    let moves = |own: &Vec<f64>, size: f64| -> Vec<f64> {
        let along: Vec<f64> = own.iter().map(|part| -size * part).collect();
        fit.own.multiples(&along)
    };
    let mut shifts = vec![0.0; judged.unknowns.len()];
    for (own, size) in own_parts.iter().zip(&sizes) {
        for (shift, part) in shifts.iter_mut().zip(moves(own, *size)) {
            *shift += part;
        }
    }
    // A drifting parameter is further from its mean at the end of the run.
    let drifting = match effects[0] {
        Effect::GainDrift => Some((Unknown::B, judged.servo.b * units.acceleration())),
        Effect::FrictionDrift => Some((Unknown::Coulomb, 1.0)),
        _ => None,
    };
    if let Some((unknown, whole)) = drifting
        && let Some(place) = judged.unknowns.iter().position(|own| *own == unknown)
    {
        shifts[place] += 0.5 * whole * sizes[0];
    }
    let (scale, unit) = effects[0].si(&units);
    let size = match sizes[..] {
        [size] => size,
        _ => sizes.iter().map(|size| size * size).sum::<f64>().sqrt(),
    };
    Some(Finding {
        cause: effects[0].cause()?,
        share,
        significance: significance(&whole, &fit.rest),
        size: size * scale,
        unit,
        shifts: (judged.unknowns.iter().zip(shifts))
            .map(|(unknown, shift)| (*unknown, shift / unknown.scale(&units)))
            .collect(),
    })
}

/// The sum of a product over its standard error, by how far groups of samples disagree.
fn significance(column: &[f64], rest: &[f64]) -> f64 {
    let length = column.len().div_ceil(GROUPS).max(1);
    let groups: Vec<f64> = column
        .chunks(length)
        .zip(rest.chunks(length))
        .map(|(column, rest)| dot(column, rest))
        .collect();
    let count = groups.len() as f64;
    let sum: f64 = groups.iter().sum();
    let mean = sum / count;
    let scatter: f64 = groups.iter().map(|group| (group - mean).powi(2)).sum();
    let deviation = (scatter * count / (count - 1.0).max(1.0)).sqrt();
    if deviation > 0.0 {
        sum / deviation
    } else {
        0.0
    }
}
