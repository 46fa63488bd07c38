//! The first estimates, and the time at which the command acts.

use super::fitter::Fitter;
use super::search::Search;
use super::weak_form::{Start, starts};
use super::{Effect, Horizon, Values};

impl Fitter<'_> {
    /// The first estimates, at the likeliest of the starts, their delay free.
    #[must_use]
    pub fn start(&self) -> Option<Values> {
        /// Starts whose gains differ by less than this factor are one.
        const SAME: f64 = 1.22;
        /// Starts that are searched from.
        const TRIED: usize = 3;
        /// Horizons of the search, widths of the start's weights, and the least of each, samples.
        const HORIZONS: [[f64; 2]; 2] = [[2.0, 6.0], [8.0, 25.0]];
        let found = starts(self.record, &self.survey);
        let mut order = [0; super::weak_form::MAX_STARTS];
        for (i, place) in order.iter_mut().enumerate() {
            *place = i;
        }
        let explained = |place: &usize| {
            found[*place].map_or(f64::NEG_INFINITY, |start| {
                if start.values.get(Effect::B) > 0.0 {
                    start.explained
                } else {
                    f64::NEG_INFINITY
                }
            })
        };
        order.sort_unstable_by(|one, other| explained(other).total_cmp(&explained(one)));
        let mut tried: [Option<Start>; TRIED] = [None; TRIED];
        let mut count = 0;
        for start in order.iter().filter_map(|&place| found[place]) {
            let gain = start.values.get(Effect::B);
            let is_new = gain > 0.0
                && tried.iter().flatten().all(|other| {
                    let ratio = gain / other.values.get(Effect::B);
                    !(1.0 / SAME..SAME).contains(&ratio)
                });
            if is_new && count < TRIED {
                tried[count] = Some(start);
                count += 1;
            }
        }
        let most = self.record.len() as f64 / 6.0;
        let widest = tried
            .iter()
            .flatten()
            .map(|start| (HORIZONS[1][0] * start.width).max(HORIZONS[1][1]))
            .fold(0.0, f64::max)
            .min(most);
        let mut best: Option<(f64, Values)> = None;
        for start in tried.iter().flatten() {
            let mut values = start.values;
            let [low, high] = self.bounds(&values, Effect::Delay);
            values.set(Effect::Delay, values.get(Effect::Delay).clamp(low, high));
            let first = (HORIZONS[0][0] * start.width)
                .max(HORIZONS[0][1])
                .min(widest);
            let mut likelihood = f64::INFINITY;
            for white in [first, widest] {
                let horizon = Horizon { white, walk: None };
                let search = Search {
                    steps: 6,
                    tolerance: 1e-5,
                };
                let Some((found, sums)) = self.search(&values, &Effect::BASE, horizon, search)
                else {
                    continue;
                };
                values = found;
                likelihood = sums.minus_two_log_likelihood();
            }
            if best.is_none_or(|(least, _)| likelihood < least) && likelihood.is_finite() {
                best = Some((likelihood, values));
            }
        }
        best.map(|(_, values)| values)
    }

    /// Where the command acts before it was recorded it was recorded late: by how much, samples, and its
    /// standard error, with the estimates at a long horizon, at which a command that already answers the
    /// position cannot explain it.
    #[must_use]
    pub fn lateness(&self, values: &Values) -> Option<Lateness> {
        let rows = self.record.len() as f64;
        let white = (8.0 / self.survey.bandwidth).clamp(30.0, (rows / 10.0).max(30.0));
        let search = Search {
            steps: 10,
            tolerance: 1e-7,
        };
        let horizon = Horizon { white, walk: None };
        let fitted = self.fit(values, &Effect::BASE, horizon, search)?;
        Some(Lateness {
            samples: -fitted.values.get(Effect::Delay),
            std_error: fitted.std_errors()[4],
            values: fitted.values,
        })
    }
}

/// How late the command was recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lateness {
    /// By how much, samples; negative is a delay of the servo.
    pub samples: f64,
    /// Standard error.
    pub std_error: f64,
    /// The estimates with it.
    pub values: Values,
}

impl Lateness {
    /// True if it cannot be a delay: beyond 0.6 samples, and beyond 0.3 by four standard errors.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.samples > 0.6 && self.samples - 0.3 > 4.0 * self.std_error
    }
}
