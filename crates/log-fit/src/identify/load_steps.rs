//! Steps of the load: a load that walks, followed over the record, stays between a few steps.

use crate::fit::{Effect, Fitted, Horizon, RecordFitter};

use super::model::Entered;
use crate::cause::Cause;

/// Parts of the record over which the load is averaged.
const PARTS: usize = 120;

/// The fewest samples of a part.
const MIN_PART: usize = 4;

/// Parts at the beginning in which the filter still finds the load.
const FIRST_PARTS: usize = 2;

/// The most steps that are looked for.
const MAX_STEPS: usize = 3;

/// The least part of the load's scatter that a step explains.
const MIN_STEP_SHARE: f64 = 0.02;

/// The same for all steps together. A random-walk load, or a load that depends on angle or velocity, leaves more to its
/// parts. For drawn servos without steps the steps explain 0.74 or less.
const MIN_SHARE: f64 = 0.9;

/// Neighbours of a load that walks agree more than strangers.
const AUTOCORRELATION: f64 = 1.5;

/// The least deviation of the load, of the acceleration by the largest command.
const MIN_SIZE: f64 = 0.001;

/// A load that is constant between steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LoadSteps {
    /// The part of the load's scatter that the steps explain.
    share: f64,
    /// The sample of the record from which on the last load acts.
    pub(super) last: usize,
    /// That load and its standard error by the disagreement of its parts.
    pub(super) load: (f64, f64),
}

impl LoadSteps {
    /// The load steps of a fitted record. None if the load is constant or if no steps explain it. The best fit of a
    /// constant load has no drift.
    pub(super) fn find(fitter: &RecordFitter<'_>, fitted: &Fitted) -> Option<Self> {
        let length = fitter.record.len();
        if length < MIN_PART * PARTS || fitted.horizon.walk.is_none() {
            return None;
        }
        let means = walked(fitter, fitted)?;
        let ends = steps(&means);
        let parts = || ends.windows(2).map(|ends| &means[ends[0]..ends[1]]);
        let all = scatter(&means);
        let share = 1.0 - parts().map(scatter).sum::<f64>() / all;
        let deviation = (all / means.len() as f64).sqrt();
        let usual = fitter.usual_size(&fitted.values, Effect::Load);
        if ends.len() < 3 || share < MIN_SHARE || deviation < MIN_SIZE * usual {
            return None;
        }
        let last = parts().next_back()?;
        let count = last.len() as f64;
        let partial_regression = last.iter().sum::<f64>() / count;
        let variance = scatter(last) / (count - 1.0).max(1.0) / count;
        Some(Self {
            share,
            last: (means.len() - last.len() + FIRST_PARTS) * length / PARTS,
            load: (
                fitted.values.get(Effect::Load) + partial_regression,
                AUTOCORRELATION * variance.sqrt(),
            ),
        })
    }

    /// As an effect that the record shows; its gain is that of the parts' likelihood.
    pub(super) fn entered(&self) -> Entered {
        let left = (1.0 - self.share).max(f64::EPSILON);
        Entered::certain(Cause::LoadSteps, -(PARTS as f64) * left.ln())
    }
}

/// The means over parts of a random-walk load beside the fitted one. None if the model diverges.
fn walked(fitter: &RecordFitter<'_>, fitted: &Fitted) -> Option<Vec<f64>> {
    let length = fitter.record.len();
    let rows = length as f64;
    // The load is followed within a quarter of a part.
    let walk = (0.25 * rows / PARTS as f64).max(0.5 * fitter.statistics.shortest_horizon(length));
    let horizon = Horizon {
        white: walk.max(rows / 6.0),
        walk: Some(walk),
    };
    let mut sums = [[0.0; 2]; PARTS];
    let pass = fitter.pass(&fitted.values, horizon);
    let ran = pass.run(&fitted.values, &[], &mut |row| {
        let [sum, rows] = &mut sums[row.sample * PARTS / length];
        *sum += row.walk;
        *rows += 1.0;
    });
    let means = sums.iter().map(|[sum, rows]| sum / f64::max(*rows, 1.0));
    ran.then(|| means.skip(FIRST_PARTS).collect())
}

/// The ends of the parts between steps, the first and the last included. It takes the step that explains most,
/// repeatedly.
fn steps(means: &[f64]) -> Vec<usize> {
    /// The fewest means between steps.
    const MIN_LENGTH: usize = 2;
    let least = MIN_STEP_SHARE * scatter(means);
    let mut ends = vec![0, means.len()];
    for _ in 0..MAX_STEPS {
        let mut best = (least, None);
        for pair in ends.windows(2) {
            let part = &means[pair[0]..pair[1]];
            let all = scatter(part);
            for at in MIN_LENGTH..=part.len().saturating_sub(MIN_LENGTH) {
                let gain = all - scatter(&part[..at]) - scatter(&part[at..]);
                if gain > best.0 {
                    best = (gain, Some(pair[0] + at));
                }
            }
        }
        let Some(at) = best.1 else { break };
        let place = ends.partition_point(|end| *end < at);
        ends.insert(place, at);
    }
    ends
}

/// Sum of the squared deviations from the mean.
fn scatter(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|one| (one - mean).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The part of the scatter that steps explain.
    fn share(means: &[f64]) -> f64 {
        let ends = steps(means);
        let left: f64 = (ends.windows(2))
            .map(|ends| scatter(&means[ends[0]..ends[1]]))
            .sum();
        1.0 - left / scatter(means)
    }

    #[test]
    fn steps_are_found_where_they_are_and_a_wave_is_none() {
        let noise = |k: usize| 0.1 * ((37 * k % 11) as f64 - 5.0) / 5.0;
        let level = |k: usize| match k {
            0..30 => 1.0,
            30..80 => -1.0,
            _ => 0.3,
        };
        let stepped: Vec<f64> = (0..118).map(|k| level(k) + noise(k)).collect();
        assert_eq!(steps(&stepped), [0, 30, 80, 118]);
        assert!(share(&stepped) > MIN_SHARE);
        let wave: Vec<f64> = (0..118).map(|k| (0.3 * k as f64).sin()).collect();
        assert!(share(&wave) < MIN_SHARE);
        let noise: Vec<f64> = (0..118).map(noise).collect();
        assert!(share(&noise) < MIN_SHARE);
    }
}
