//! The choice of the horizon.

use super::fitter::RecordFitter;
use super::search::Fitted;
use super::{Effect, Horizon};

impl RecordFitter<'_> {
    /// Fits the same effects at several [horizons](Self::horizons) and chooses the one with the least robust variance.
    /// Among those that are nearly as good it takes the likeliest. A filter that trusts its model less than the model
    /// deserves costs variance. One that trusts it more costs bias, which the segments' disagreement shows.
    #[must_use]
    pub fn best_horizon(
        &self,
        fits: impl IntoIterator<Item = Fitted>,
        free: &[Effect],
    ) -> Option<Fitted> {
        /// Logarithm of a standard error within which two horizons are as good.
        const AS_GOOD: f64 = 0.25;
        /// By which a walking load must be better than a constant one; it must be likelier, too.
        const WALK_MUST_GAIN: f64 = 0.4;
        let mut best: [Option<Fitted>; 2] = [None; 2];
        let mut least = [f64::INFINITY; 2];
        let mut scores = [f64::INFINITY; 2];
        for fitted in fits {
            let score = self.spread(&fitted, free);
            if score.is_nan() || fitted.covariances.condition.is_infinite() {
                continue;
            }
            let family = usize::from(fitted.horizon.walk.is_some());
            let likelihood = |fitted: &Fitted| fitted.sums.minus_two_log_likelihood();
            // Among those as good as the smallest so far, the likeliest is kept.
            let stands = match &best[family] {
                None => true,
                Some(_) if score < least[family] - AS_GOOD => true,
                Some(kept) => {
                    let kept_is_good = scores[family] < least[family].min(score) + AS_GOOD;
                    score < least[family] + AS_GOOD
                        && (!kept_is_good || likelihood(&fitted) < likelihood(kept))
                }
            };
            least[family] = least[family].min(score);
            if stands {
                best[family] = Some(fitted);
                scores[family] = score;
            }
        }
        let unexplained = best.each_ref().map(|best| {
            let likelihood = |fitted: &Fitted| fitted.sums.minus_two_log_likelihood();
            best.as_ref().map_or(f64::INFINITY, likelihood)
        });
        let [constant, walking] = best;
        let walks = least[1] < least[0] - WALK_MUST_GAIN && unexplained[1] < unexplained[0];
        if walks {
            walking.or(constant)
        } else {
            constant.or(walking)
        }
    }

    /// The load of a fit and its standard error. For a random-walk load it is the mean, and the error is from the
    /// disagreement of the segments.
    #[must_use]
    pub fn load(&self, fitted: &Fitted, free: &[Effect]) -> (f64, f64) {
        const SEGMENTS: usize = 16;
        /// Neighbours of a load that walks agree more than strangers.
        const AUTOCORRELATION: f64 = 1.5;
        let load = fitted.values.get(Effect::Load);
        if fitted.horizon.walk.is_none() {
            let place = free.iter().position(|&effect| effect == Effect::Load);
            let error = place.map_or(0.0, |place| fitted.std_errors()[place]);
            return (load, error);
        }
        let mut sums = [[0.0; 2]; SEGMENTS];
        let length = self.record.len();
        self.pass(&fitted.values, fitted.horizon)
            .run(&fitted.values, &[], &mut |row| {
                let sum = &mut sums[row.sample * SEGMENTS / length];
                sum[0] += row.walk;
                sum[1] += 1.0;
            });
        let means = sums.map(|[sum, rows]| sum / f64::max(rows, 1.0));
        let count = SEGMENTS as f64;
        let mean = means.iter().sum::<f64>() / count;
        let scatter = means
            .iter()
            .map(|one| (one - mean) * (one - mean))
            .sum::<f64>();
        let error = AUTOCORRELATION * libm::sqrt(scatter / (count - 1.0) / count);
        (load + mean, error)
    }

    /// The relative standard errors of a fit, in one logarithm.
    fn spread(&self, fitted: &Fitted, free: &[Effect]) -> f64 {
        let errors = fitted.std_errors();
        let of = |effect: Effect| {
            let place = free.iter().position(|&one| one == effect);
            place.map_or(f64::NAN, |place| errors[place])
        };
        let values = &fitted.values;
        let usual = self.usual_size(values, Effect::Coulomb);
        let rate = self.usual_size(values, Effect::A);
        let floor = |value: f64, share: f64| value.abs() + share;
        let log = |error: f64, scale: f64, least: f64| {
            let error = if error.is_finite() { error } else { least };
            libm::log(error / scale)
        };
        let mut spread = log(of(Effect::B), values.get(Effect::B), values.get(Effect::B))
            + 0.5
                * log(
                    of(Effect::Coulomb),
                    floor(values.get(Effect::Coulomb), 0.02 * usual),
                    usual,
                )
            + 0.5
                * log(
                    of(Effect::A),
                    floor(values.get(Effect::A), 0.03 * rate),
                    rate,
                );
        if values.get(Effect::A) <= self.bounds(values, Effect::A)[0] {
            spread += 1.0;
        }
        spread
    }

    /// A geometric series of horizons, of a constant load and of one that walks.
    pub fn horizons(&self) -> impl Iterator<Item = Horizon> {
        /// Ratio of the series.
        const RATIO: f64 = 2.2;
        let samples = self.record.len();
        let rows = samples as f64;
        let shortest = self.statistics.shortest_horizon(samples);
        let longest = rows / 6.0;
        let series = move |first: f64, last: f64| {
            core::iter::successors(Some(first), move |last| Some(last * RATIO))
                .take_while(move |&one| one < last)
        };
        let constant = series(shortest, longest).map(|white| Horizon { white, walk: None });
        let walking = series((0.5 * shortest).max(4.0), rows / 12.0).map(move |walk| Horizon {
            white: longest.max(walk),
            walk: Some(walk),
        });
        constant.chain(walking)
    }

    /// Horizons about one.
    pub fn horizons_about(&self, horizon: Horizon) -> impl Iterator<Item = Horizon> {
        let samples = self.record.len();
        let shortest = self.statistics.shortest_horizon(samples);
        let longest = samples as f64 / 6.0;
        // At either end several are one.
        let mut last = None;
        [1.0 / 1.8, 1.0, 1.8, 4.0]
            .into_iter()
            .filter_map(move |factor| match horizon.walk {
                None => Some(Horizon {
                    white: (horizon.white * factor).clamp(shortest, longest.max(shortest)),
                    walk: None,
                }),
                Some(_) if factor > 2.0 => None,
                Some(walk) => Some(Horizon {
                    white: horizon.white,
                    walk: Some((walk * factor).max((0.5 * shortest).max(4.0))),
                }),
            })
            .filter(move |&one| last.replace(one) != Some(one))
    }
}
