//! A record beside the model that was identified.

use crate::fit::{Effect, Horizon, Record, RecordFitter};

use super::every_sample::of_samples;
use super::{Identified, Recording};

/// The residuals of a model over a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// The model without correction; none if no window is long enough to tell where it starts.
    pub free_run: Option<FreeRun>,
    /// Deviation of the model's prediction of the next sample, counts, and its correlation from sample to sample.
    pub innovation: f64,
    /// See `innovation`.
    pub correlation: f64,
}

/// The residuals of a model that runs free from the beginning of each window, with the start that fits the measurements
/// there so far.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeRun {
    /// The measured position minus that of the model for every sample of the log, counts. NaN until the start of its window
    /// is known.
    pub errors: Vec<f64>,
    /// Samples of a window.
    pub window: usize,
}

/// Windows in shortest horizons of the filter.
const HORIZONS: f64 = 30.0;

/// Variance of a prediction over that of a measurement below which the start of a window is known.
const KNOWN: f64 = 1.5;

impl Identified {
    /// With what its model leaves of the record in the errors: where that is more than the sensor's noise, b may be off by its
    /// difference to the equation of motion at the surest time scale, beyond that one's own error.
    pub(super) fn with_the_rest(mut self, recording: &Recording<'_>) -> Self {
        /// Deviations of the sensor's noise, and the correlation from sample to sample, beyond which it is more.
        const MORE: [f64; 2] = [1.5, 0.5];
        let course = self.course(recording);
        self.is_explained = course.is_none_or(|course| {
            course.innovation < MORE[0] * self.statistics.noise || course.correlation < MORE[1]
        });
        let mut estimated = self.estimated.iter();
        let gain = estimated.position(|(effect, _)| *effect == Effect::B);
        if let Some((scale, gain)) = self.acting.zip(gain).filter(|_| !self.is_explained) {
            let off = scale.values.get(Effect::B) - self.values.get(Effect::B);
            let own = scale.std_errors.get(Effect::B);
            self.covariance[gain][gain] += (off * off - own * own).max(0.0);
            self.estimated[gain].1 = self.covariance[gain][gain].sqrt();
        }
        self
    }

    /// The course of the recording beside its model; none if the model diverges in it.
    #[must_use]
    pub fn course(&self, recording: &Recording<'_>) -> Option<Course> {
        let every = recording.every_sample();
        let record = every.as_ref().unwrap_or(recording).record();
        let whole = recording.record();
        let fitter = RecordFitter {
            record: &whole,
            statistics: self.statistics,
            earliest: 0.0,
            block: 1.0,
            goes_on: &|| true,
        };
        let values = recording.about_middle(&self.values);
        let of_blocks = (&fitter, &values, self.horizon);
        let (fitter, values, own) = of_samples(of_blocks, &record, recording.block);
        let (mut squares, mut lagged, mut last, mut rows) = (0.0, 0.0, 0.0, 0.0);
        let ran = fitter.pass(&values, own).run(&values, &[], &mut |row| {
            squares += row.innovation * row.innovation / row.variance;
            lagged += row.innovation * last / row.variance;
            last = row.innovation;
            rows += 1.0;
        });
        let shortest = fitter.statistics.shortest_horizon(record.len());
        let window = (HORIZONS * shortest) as usize;
        let begins: Vec<usize> = (record.motions())
            .flat_map(|(first, end)| {
                // No window is a short rest.
                let count = ((end - first) / window).max(1);
                (0..count).map(move |k| first + k * window)
            })
            .collect();
        let windows = Record {
            begins: &begins,
            ..record
        };
        let free = RecordFitter {
            record: &windows,
            ..fitter
        };
        let horizon = Horizon {
            white: record.len() as f64,
            walk: own.walk,
        };
        let mut errors = vec![f64::NAN; record.len()];
        let ran_free = free.pass(&values, horizon).run(&values, &[], &mut |row| {
            if row.variance < KNOWN {
                errors[row.sample] = row.innovation;
            }
        });
        let is_known = errors.iter().any(|error| error.is_finite());
        (ran && ran_free).then_some(Course {
            free_run: is_known.then_some(FreeRun { errors, window }),
            innovation: f64::sqrt(squares / rows),
            correlation: lagged / squares,
        })
    }
}
