//! Where the search for the servo begins.

use crate::fit::{Effect, Horizon, RecordFitter, Search, Values};
use crate::parallel;
use crate::scales::TimeScale;

/// The first estimates, of a servo with gravity or without, from the time scales that explain most and are surest of b; none if
/// every search diverges.
pub(super) fn start(
    fitter: &RecordFitter<'_>,
    scales: &[TimeScale],
    has_gravity: bool,
) -> Option<Values> {
    /// Starts that are searched from.
    const TRIED: usize = 3;
    /// Starts whose gains differ by less than this factor are one.
    const SAME: f64 = 1.22;
    /// Horizons of the search, deviations of a window's weights, and the least of each, samples.
    const HORIZONS: [[f64; 2]; 2] = [[2.0, 6.0], [8.0, 25.0]];
    const DEVIATION: f64 = 0.144_338;
    let mut left: Vec<(Values, f64, f64)> = (scales.iter())
        .filter_map(|scale| {
            let (values, explained) = scale.starts[usize::from(has_gravity)]?;
            let gain = values.get(Effect::B);
            let missed = (1.0 - explained).hypot(scale.std_errors.get(Effect::B) / gain);
            (gain > 0.0).then_some((values, missed, DEVIATION * scale.span))
        })
        .collect();
    let mut tried = Vec::new();
    while let Some(best) = (left.iter().copied())
        .min_by(|one, other| one.1.total_cmp(&other.1))
        .filter(|_| tried.len() < TRIED)
    {
        let gain = best.0.get(Effect::B);
        left.retain(|other| !(1.0 / SAME..SAME).contains(&(other.0.get(Effect::B) / gain)));
        tried.push(best);
    }
    let most = fitter.record.len() as f64 / 6.0;
    let horizon = |width: f64, [widths, least]: [f64; 2]| (widths * width).max(least).min(most);
    // The last is the same for all, so that their likelihoods are of one filter.
    let widest = (tried.iter())
        .map(|(.., width)| horizon(*width, HORIZONS[1]))
        .fold(0.0, f64::max);
    let search = Search {
        steps: 6,
        tolerance: 1e-5,
    };
    let gravity: &[Effect] = match has_gravity {
        true => &[Effect::GravitySine, Effect::GravityCosine],
        false => &[],
    };
    let free = [&Effect::BASE[..], gravity].concat();
    let searched = parallel::map(&tried, |&(mut values, _, width)| {
        for (effect, [low, high]) in [
            (Effect::A, [0.0, RecordFitter::MAX_RATE]),
            (Effect::Coulomb, [0.0, f64::INFINITY]),
            (Effect::Delay, fitter.bounds(&values, Effect::Delay)),
        ] {
            values.set(effect, values.get(effect).clamp(low, high));
        }
        let first = horizon(width, HORIZONS[0]).min(widest);
        let mut likelihood = f64::INFINITY;
        for white in [first, widest] {
            let horizon = Horizon { white, walk: None };
            if let Some((found, sums)) = fitter.search(&values, &free, horizon, search) {
                values = found;
                likelihood = sums.minus_two_log_likelihood();
            }
        }
        likelihood.is_finite().then_some((values, likelihood))
    });
    let likeliest = (searched.flatten()).min_by(|one, other| one.1.total_cmp(&other.1));
    likeliest.map(|(values, _)| values)
}
