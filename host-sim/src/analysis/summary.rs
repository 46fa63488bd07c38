//! What came out of an experiment, gathered sample by sample.

use identifier_core::model::ServoParameters;
use identifier_core::parameters::Parameter;

use super::estimate::{Estimate, SETTLED_A, SETTLED_B, Tracked, tolerance};
use super::statistics::Statistics;
use super::verdict::{PARAMETERS, Status, verdict};
use crate::experiment::{Outcome, Sample};
use crate::scenario::Scenario;

/// The part of a run, at its end, over which tail means are taken.
const TAIL: f64 = 0.25;

/// What came out of an experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// The law's name.
    pub law: &'static str,
    /// The number format's name.
    pub arithmetic: &'static str,
    /// Sample time, s.
    pub sample_time: f64,
    /// What the run itself knows.
    pub outcome: Outcome,
    /// Whether the estimates have come to rest.
    pub status: Status,
    /// Why that status, and what else a user should know.
    pub reason: String,
    /// The parameters that the law estimates.
    pub estimated: Vec<Parameter>,
    /// â, 1/s; constant if it is not estimated.
    pub a: Estimate,
    /// b̂, rad/s² per command unit; constant if it is not estimated.
    pub b: Estimate,
    /// ĉ, rad/s²; constant if it is not estimated.
    pub coulomb: Estimate,
    /// d̂, rad/s²; constant if it is not estimated.
    pub load: Estimate,
    /// The true servo, where it is known.
    pub truth: Option<ServoParameters>,
    /// Root mean square and largest magnitude of the output error, rad, for laws with a model.
    pub output_error: Option<(f64, f64)>,
    /// The last time at which â was outside ±0.1 1/s of the truth, s; none if it still was at the
    /// end.
    pub settling_a: Option<f64>,
    /// The last time at which b̂ was outside 2 % of the truth, s; none if it still was at the end.
    pub settling_b: Option<f64>,
}

/// Gathers a [`Summary`] from the samples of a run.
#[derive(Debug, Clone)]
pub struct Summariser {
    tail_from: f64,
    duration: f64,
    truth: Option<ServoParameters>,
    sample_time: f64,
    tracked: [Tracked; 4],
    standard_errors: Option<ServoParameters>,
    command_squares: Statistics,
    error_squares: Statistics,
    error_peak: f64,
    has_model: bool,
    outside_a: Option<f64>,
    outside_b: Option<f64>,
    end: f64,
}

impl Summariser {
    /// For a run of this scenario.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        Self::lasting(scenario, scenario.duration)
    }

    /// For a run that lasts so long, s.
    #[must_use]
    pub fn lasting(scenario: &Scenario, duration: f64) -> Self {
        Self {
            tail_from: (1.0 - TAIL) * duration,
            duration,
            truth: scenario.plant,
            sample_time: scenario.sample_time(),
            tracked: [Tracked::default(); 4],
            standard_errors: None,
            command_squares: Statistics::default(),
            error_squares: Statistics::default(),
            error_peak: 0.0,
            has_model: false,
            outside_a: None,
            outside_b: None,
            end: 0.0,
        }
    }

    /// Takes in a sample.
    #[inline]
    pub fn add(&mut self, sample: &Sample) {
        let time = sample.time;
        let third = (time >= self.tail_from).then(|| {
            let passed = (time - self.tail_from) / (self.duration - self.tail_from);
            ((3.0 * passed) as usize).min(2)
        });
        for (tracked, parameter) in self.tracked.iter_mut().zip(PARAMETERS) {
            let at_bound = sample.at_bounds.of(parameter);
            tracked.add(parameter.of(&sample.estimates), at_bound, third);
        }
        self.standard_errors = sample.standard_errors;
        self.command_squares.add(sample.command * sample.command);
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

    /// An acceleration that friction and load are small beside, rad/s²: what the proportional gain
    /// gives the servo of the initial estimate for an error of one, or else ten times what the command
    /// gave the servo that was found.
    fn usual_acceleration(&self, scenario: &Scenario) -> f64 {
        let given = &scenario.stated;
        let kp = match given.controller {
            Some(controller) => Some(controller.kp),
            None => given.correction_gains().ok().map(|gains| gains.kp()),
        };
        let stated = given.identifier.initial.b.zip(kp).map(|(b, kp)| b * kp);
        stated.unwrap_or_else(|| {
            let [_, b, ..] = &self.tracked;
            10.0 * b.last.abs() * self.command_squares.mean().unwrap_or(0.0).sqrt()
        })
    }

    /// The summary of a run that has ended.
    #[must_use]
    pub fn finish(self, scenario: &Scenario, outcome: Outcome) -> Summary {
        let usual = self.usual_acceleration(scenario);
        let estimates: [Estimate; 4] = std::array::from_fn(|i| {
            let parameter = PARAMETERS[i];
            let std_error = self.standard_errors.map(|errors| parameter.of(&errors));
            self.tracked[i].estimate(|value| tolerance(parameter, value, usual), std_error)
        });
        let estimated = scenario.estimated();
        let (status, reason) = verdict(&estimates, scenario, usual, &outcome);
        let still_outside = |outside: Option<f64>| outside.is_some_and(|time| time >= self.end);
        let known = self.truth.is_some() && status != Status::Aborted;
        let settling = |outside: Option<f64>| {
            (known && !still_outside(outside))
                .then(|| outside.map_or(0.0, |time| time + self.sample_time))
        };
        let [a, b, coulomb, load] = estimates;
        Summary {
            law: scenario.identifier.law.name(),
            arithmetic: scenario.identifier.arithmetic.name(),
            sample_time: self.sample_time,
            outcome,
            status,
            reason,
            estimated,
            a,
            b,
            coulomb,
            load,
            truth: self.truth,
            output_error: self.has_model.then(|| {
                let mean_square = self.error_squares.mean().unwrap_or(0.0);
                (mean_square.sqrt(), self.error_peak)
            }),
            settling_a: settling(self.outside_a),
            settling_b: settling(self.outside_b),
        }
    }
}

impl Summary {
    /// One estimate; none if the law does not estimate the parameter.
    #[must_use]
    pub fn estimate(&self, parameter: Parameter) -> Option<&Estimate> {
        let estimate = match parameter {
            Parameter::A => &self.a,
            Parameter::B => &self.b,
            Parameter::Coulomb => &self.coulomb,
            Parameter::Load => &self.load,
        };
        self.estimated.contains(&parameter).then_some(estimate)
    }
}
