//! What the rows of a log leave open of the time between them.

use crate::fit::{Effect, Fitted, Matrix, RecordFitter, Search};
use crate::parallel;

use super::between::Between;
use super::every_sample::{in_samples, of_samples};
use super::model::Model;
use super::recording::{Axis, Recording};
use super::uncertainty::{add, beyond_chance};

/// A model under the likelier of the commands that were not held.
#[derive(Debug, Clone)]
pub(super) struct Rival {
    axis: Axis,
    fitted: Fitted,
}

impl Rival {
    /// That of a model of rows.
    pub(super) fn find(
        judge: &RecordFitter<'_>,
        judged: &Model,
        log: &Recording<'_>,
    ) -> Option<Self> {
        let others = [Between::Sampled, Between::Averaged];
        let fits = parallel::map(&others, |&between| {
            let axis = Axis {
                between,
                ..log.axis()
            };
            let fitted = fit(judge, judged, &log.of_rows(log.samples(), axis), 1.0)?;
            Some(Self { axis, fitted })
        });
        let left = |rival: &Self| rival.fitted.sums.minus_two_log_likelihood();
        (fits.into_iter().flatten()).min_by(|one, other| left(one).total_cmp(&left(other)))
    }

    /// How its rows are to be taken, if it is clearly likelier.
    pub(super) fn wins(&self, judged: &Model) -> Option<Axis> {
        /// The increase of −2 ln L in independent rows.
        const CLEARLY: f64 = 20.0;
        (judged.gain_over(&self.fitted) < -CLEARLY).then_some(self.axis)
    }

    /// Adds to the covariance of a model what the rows do not tell of the time between them, if they leave out enough to show.
    /// With this rival the estimates are others: it counts by its probability. And they go on to change where every second row
    /// is left out: about as much as by what the log's own rows leave out.
    pub(super) fn widen(
        &self,
        judge: &RecordFitter<'_>,
        judged: &Model,
        log: &Recording<'_>,
        covariance: &mut Matrix,
    ) {
        /// What is left doubles with the time from row to row: the part of that which shows that rows leave out something.
        const SHOWS: f64 = 0.25;
        /// Odds before the log is seen, as of most effects that may be missing.
        const PRIOR_ODDS: f64 = 0.1;
        let against = (0.5 * judged.gain_over(&self.fitted)).exp() / PRIOR_ODDS;
        let probability = 1.0 / (1.0 + against);
        let not_held = match log.axis().between {
            Between::Held => probability,
            Between::Sampled | Between::Averaged => 1.0,
        };
        let shift = |from: &Fitted, to: &Fitted| {
            let [load, other] = [from, to].map(|of| of.values.get(Effect::Load));
            beyond_chance(&judged.free, [from, to], other - load)
        };
        let rows = log.every_second();
        let Some(fewer) = fit(judge, judged, &log.of_rows(&rows, self.axis), 2.0) else {
            return;
        };
        let part = 2.0 * self.fitted.sums.noise() / fewer.sums.noise();
        if part > SHOWS {
            let [own, other] = [&judged.fitted, &self.fitted];
            add(covariance, &shift(own, other), probability);
            add(covariance, &shift(other, &fewer), not_held * part.min(1.0));
        }
    }
}

/// A model of rows refitted to others of the same log, of `each`-fold length.
fn fit(
    judge: &RecordFitter<'_>,
    Model { free, fitted, .. }: &Model,
    rows: &Recording<'_>,
    each: f64,
) -> Option<Fitted> {
    const SEARCH: Search = Search {
        steps: 6,
        tolerance: 1e-7,
    };
    let record = rows.record();
    let of_rows = (judge, &fitted.values, fitted.horizon);
    let (fitter, values, horizon) = of_samples(of_rows, &record, 1.0 / each);
    let mut found = fitter.fit(&values, free, horizon, SEARCH)?;
    found.values = found.values.scaled(|effect| in_samples(effect, each));
    for (variance, &effect) in found.covariances.variances.iter_mut().zip(free) {
        *variance *= in_samples(effect, each).powi(2);
    }
    Some(found)
}
