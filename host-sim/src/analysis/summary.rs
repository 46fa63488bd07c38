//! The summary of an experiment, gathered sample by sample.

use std::collections::VecDeque;

use identifier_core::parameters::{Parameter, ServoParameters, Unknown};
use identifier_log::analysis::{
    Assessment, Effort, Ending, EstimationMethod, Statistics, VerifiedEstimate,
};
use identifier_log::experiment::{Outcome, Sample};
use identifier_log::result::{OutputError, SettlingTime, Summary};
use log_fit::Logged;

use super::estimate::{SETTLED_A, SETTLED_B, Tracked};
use crate::scenario::Scenario;

/// The part of a run, at its end, over which tail means are taken.
const TAIL: f64 = 0.25;

/// Gathers a [`Summary`] from the samples of a run with an estimator that takes them one by one.
#[derive(Debug, Clone, Default)]
pub struct Summariser {
    tail_from: f64,
    duration: f64,
    truth: Option<ServoParameters>,
    sample_time: f64,
    /// In the order of [`Parameter::ALL`].
    tracked: [Tracked; 4],
    has_standard_errors: bool,
    tail_buffer: TailBuffer,
    effort: Effort,
    travelled: f64,
    last_position: Option<f64>,
    error_squares: Statistics,
    error_peak: f64,
    has_model: bool,
    outside_a: Option<f64>,
    outside_b: Option<f64>,
    end: f64,
    prediction: Option<f64>,
}

impl Summariser {
    /// For a run of this scenario.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        Self::lasting(scenario, scenario.duration)
    }

    /// For one of many runs of this scenario: it looks at less.
    #[must_use]
    pub fn brief(scenario: &Scenario) -> Self {
        Self::with(scenario, scenario.duration, Effort::BRIEF)
    }

    /// For a run that lasts so long, s.
    #[must_use]
    pub fn lasting(scenario: &Scenario, duration: f64) -> Self {
        Self::with(scenario, duration, Effort::THOROUGH)
    }

    fn with(scenario: &Scenario, duration: f64, effort: Effort) -> Self {
        Self {
            tail_from: (1.0 - TAIL) * duration,
            duration,
            truth: scenario.plant,
            sample_time: scenario.sample_time(),
            tail_buffer: TailBuffer::new(effort.samples),
            effort,
            ..Self::default()
        }
    }

    /// Takes in a sample. It is inlined so that a sample is never assembled in memory. The processor would wait for
    /// every copy of it. A page in a browser is small before fast.
    #[cfg_attr(feature = "experiments", inline(always))]
    pub fn add(&mut self, sample: &Sample) {
        let time = sample.time;
        let third = (time >= self.tail_from).then(|| {
            let passed = (time - self.tail_from) / (self.duration - self.tail_from);
            ((3.0 * passed) as usize).min(2)
        });
        for (tracked, parameter) in self.tracked.iter_mut().zip(Parameter::ALL) {
            let at_bound = sample.at_bounds.get(parameter);
            tracked.add(sample.estimates.get(parameter), at_bound, third);
        }
        self.has_standard_errors = sample.standard_errors.is_some();
        self.tail_buffer.add(sample);
        if let Some(last) = self.last_position.filter(|_| !sample.begins) {
            self.travelled += (sample.position - last).abs();
        }
        self.last_position = Some(sample.position);
        if let Some(error) = sample.output_error {
            self.has_model = true;
            self.error_squares.add(error * error);
            self.error_peak = self.error_peak.max(error.abs());
        }
        if let Some(truth) = &self.truth {
            let within = |off: f64, tolerance: f64| off.abs() <= tolerance;
            // No estimate is outside too.
            if !within(sample.estimates.a - truth.a, SETTLED_A) {
                self.outside_a = Some(time);
            }
            if !within(sample.estimates.b - truth.b, SETTLED_B * truth.b) {
                self.outside_b = Some(time);
            }
        }
        self.end = time;
    }

    /// The next pass over a log begins: its end is what is judged.
    pub fn begin_pass(&mut self) {
        self.tail_buffer.clear();
        self.last_position = None;
    }

    /// Takes the error with which the estimates predicted an unseen motion, relative to the motion. The largest counts.
    pub fn predicted(&mut self, error: f64) {
        // NaN is no small error.
        let worse = |known: f64| error.is_nan() || error > known;
        if self.prediction.is_none_or(worse) {
            self.prediction = Some(error);
        }
    }

    /// The servo that is judged. Estimators with standard errors of their own give the last estimates, which contain
    /// all samples. Others give the mean over the tail.
    fn judged(&self) -> ServoParameters {
        ServoParameters::from_fn(|parameter| {
            let tail = self.tracked[parameter as usize].estimate(|_| 0.0);
            if self.has_standard_errors {
                tail.last
            } else {
                tail.tail_mean
            }
        })
    }

    /// The summary of a run that has ended.
    #[must_use]
    pub fn finish(mut self, scenario: &Scenario, outcome: Outcome) -> Summary {
        let servo = self.judged();
        let assessment = if outcome.abort.is_some() {
            None
        } else {
            let estimated = scenario.estimated();
            let unknowns: Vec<Unknown> = (estimated.iter().copied().map(Unknown::from))
                .chain(outcome.terms.iter().map(|term| term.unknown))
                .collect();
            let judged = VerifiedEstimate {
                options: scenario,
                servo,
                terms: &outcome.terms,
                unknowns: &unknowns,
            };
            Assessment::of_estimator(&judged, self.tail_buffer.samples(), self.effort)
        };
        let still_outside = |outside: Option<f64>| outside.is_some_and(|time| time >= self.end);
        let settling = |outside: Option<f64>| {
            (self.truth.is_some() && !still_outside(outside))
                .then(|| outside.map_or(0.0, |time| time + self.sample_time))
        };
        let settling_time = SettlingTime {
            a: settling(self.outside_a),
            b: settling(self.outside_b),
        };
        let output_error = self.has_model.then(|| OutputError {
            rms: self.error_squares.mean().unwrap_or(0.0).sqrt(),
            max: self.error_peak,
        });
        let tracked = self.tracked;
        Ending {
            options: scenario,
            method: EstimationMethod::Recursive(assessment),
            samples: self.tail_buffer.samples(),
            travelled: self.travelled,
            outcome,
            servo,
            course: &|parameter, tolerance| tracked[parameter as usize].estimate(|_| tolerance),
            prediction: self.prediction,
            truth: self.truth,
            output_error,
            settling_time,
            unstable_loop: scenario.unstable_loop(),
        }
        .summary()
    }
}

/// The last samples of a run: position and the command that acted from there on. A shorter run is kept whole. A longer
/// one is judged by its end, where the estimates are best.
#[derive(Debug, Clone, Default)]
struct TailBuffer {
    samples: VecDeque<Logged>,
    most: usize,
}

impl TailBuffer {
    /// Keeps a number of samples at most.
    pub(super) fn new(most: usize) -> Self {
        Self {
            samples: VecDeque::new(),
            most,
        }
    }

    /// Takes in a sample.
    #[inline]
    pub(super) fn add(&mut self, sample: &Sample) {
        if self.samples.len() == self.most {
            self.samples.pop_front();
        }
        self.samples.push_back(sample.logged());
    }

    /// Forgets everything: the record continues elsewhere.
    pub(super) fn clear(&mut self) {
        self.samples.clear();
    }

    /// The kept samples, in order.
    pub(super) fn samples(&mut self) -> &[Logged] {
        self.samples.make_contiguous()
    }
}
