//! One pass that asks of every candidate how much of the innovations it would explain, without fitting it.

use crate::fit::{Column, Effect, RecordFitter};

use super::candidate::{Answer, Candidate, Range};
use super::model::Model;
use super::normal_blocks::NormalBlocks;
use super::partial_regression::{ModelColumns, product};
use crate::cause::Cause;

/// Asks some candidates beside a model, whose columns are with its own no more than a pass has.
pub(super) fn scan(
    fitter: &RecordFitter<'_>,
    model: &Model,
    range: &Range,
    candidates: &[Candidate],
) -> Vec<Answer> {
    let Model { free, fitted, .. } = model;
    let mut columns: Vec<Column> = free.iter().copied().map(Column::from).collect();
    let places: Vec<Vec<usize>> = candidates
        .iter()
        .map(|candidate| {
            let first = columns.len();
            columns.extend(&candidate.columns);
            (first..columns.len()).collect()
        })
        .collect();
    let Some(normal_blocks) = NormalBlocks::new(fitter, fitted, &columns, free.len(), &places)
    else {
        return Vec::new();
    };
    let noise = fitted.sums.noise() * model.rows_per_row;
    // A load that walks takes a constant one over.
    let own = (0..free.len())
        .filter(|&i| fitted.horizon.walk.is_none() || free[i] != Effect::Load)
        .collect();
    let own = ModelColumns::new(&normal_blocks, own);
    let answer = |(candidate, places): (&Candidate, Vec<usize>)| {
        let partial_regression = own.partial_regression(&normal_blocks, &places);
        let sum = partial_regression.sum(0, 1);
        let inverse = partial_regression.inverse(&sum, 0.0);
        let step = product(&inverse, &sum.right);
        let gains = partial_regression.held_out();
        let count = gains.len() as f64;
        let mean = gains.iter().sum::<f64>() / count;
        let scatter = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>();
        let error = (scatter / (count - 1.0) / count).sqrt();
        let sizes: Vec<f64> = (places.iter().zip(step))
            .map(|(&place, step)| step / normal_blocks.scales[place])
            .collect();
        let mut held_out = mean * count / noise;
        if candidate.is_positive() && sizes[0] < 0.0 {
            held_out = held_out.min(0.0);
        }
        let mut shifts = vec![0.0; free.len()];
        for (i, &place) in own.places.iter().enumerate() {
            let moved =
                partial_regression.taken[0][i] * step[0] + partial_regression.taken[1][i] * step[1];
            shifts[place] = -moved / normal_blocks.scales[place];
        }
        // The load of the record is what counts, and the mean of gravity is a part of it.
        if let Some(&place) = own
            .places
            .iter()
            .find(|&&place| free[place] == Effect::Load)
            && candidate.cause == Cause::Gravity
        {
            shifts[place] += range.mean_gravity(sizes.iter().copied());
        }
        Answer {
            candidate: candidate.clone(),
            held_out,
            consistency: mean / error.max(f64::MIN_POSITIVE),
            gain: sum.explained(&step) / noise,
            significance: partial_regression.significance(&inverse, &step),
            sizes,
            shifts,
        }
    };
    candidates.iter().zip(places).map(answer).collect()
}
