//! The summary of an experiment, gathered sample by sample.

use identifier_core::parameters::{Parameter, ServoParameters, Unknown};

use log_fit::GoesOn;

use identifier_log::verdict::{Motion, State, Status, Verdict, VerdictReason};

use super::assessment::{Assessment, Effort, VerifiedEstimate};
use super::estimate::{SETTLED_A, SETTLED_B, Tracked};
use super::evidence::{self, Known};
use super::reachable::Reachable;
use super::seen::Seen;
use super::sensor_noise::NoiseMeter;
use super::statistics::Statistics;
use super::tail_buffer::TailBuffer;
use super::whole_record::WholeRecord;
use crate::experiment::{Outcome, Sample, TermEstimate};
use crate::found_servo::FoundServo;
use crate::result::{
    Estimate, Estimates, OutputError, ReplayNotes, SettlingTime, Summary, TermSize,
};
use crate::scenario::{CommandUnit, Scenario};

/// The part of a run, at its end, over which tail means are taken.
const TAIL: f64 = 0.25;

/// The parameters in the order of a run's estimates.
const PARAMETERS: [Parameter; 4] = [
    Parameter::A,
    Parameter::B,
    Parameter::Coulomb,
    Parameter::Load,
];

/// Gathers a [`Summary`] from the samples of a run.
#[derive(Debug, Clone)]
pub struct Summariser {
    tail_from: f64,
    duration: f64,
    truth: Option<ServoParameters>,
    sample_time: f64,
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
    /// The record of an estimator that fits the whole record, after its fit. None in it: nothing explains the record.
    whole: Option<Option<WholeRecord>>,
    /// The reachable accuracy of a simulated servo, for a page of the program.
    reachable: Option<Box<Reachable>>,
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
        let kept = if scenario.identifier.law.takes_whole_record() {
            effort.whole
        } else {
            effort.samples
        };
        Self {
            tail_from: (1.0 - TAIL) * duration,
            duration,
            truth: scenario.plant,
            sample_time: scenario.sample_time(),
            tracked: [Tracked::default(); 4],
            has_standard_errors: false,
            tail_buffer: TailBuffer::new(kept),
            effort,
            travelled: 0.0,
            last_position: None,
            error_squares: Statistics::default(),
            error_peak: 0.0,
            has_model: false,
            outside_a: None,
            outside_b: None,
            end: 0.0,
            prediction: None,
            whole: None,
            reachable: None,
        }
    }

    /// The same, which looks at the accuracy that the motion of a simulated servo allows, too.
    #[must_use]
    pub fn with_reachable(mut self, scenario: &Scenario) -> Self {
        self.reachable = Reachable::new(scenario).map(Box::new);
        self
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
        for (tracked, parameter) in self.tracked.iter_mut().zip(PARAMETERS) {
            let at_bound = sample.at_bounds.get(parameter);
            tracked.add(parameter.value_in(&sample.estimates), at_bound, third);
        }
        self.has_standard_errors = sample.standard_errors.is_some();
        self.tail_buffer.add(sample);
        if let Some(reachable) = &mut self.reachable {
            reachable.add(sample);
        }
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
        self.whole = None;
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
        let of = |i: usize| {
            let tail = self.tracked[i].estimate(|_| 0.0);
            if self.has_standard_errors {
                tail.last
            } else {
                tail.tail_mean
            }
        };
        ServoParameters {
            a: of(0),
            b: of(1),
            coulomb: of(2),
            load: of(3),
        }
    }

    /// The estimates of a whole record are those of its end.
    fn take(&mut self, whole: &WholeRecord) {
        self.has_standard_errors = true;
        for (tracked, parameter) in self.tracked.iter_mut().zip(PARAMETERS) {
            *tracked = Tracked::default();
            tracked.add(parameter.value_in(&whole.servo), false, Some(2));
        }
    }

    /// The servo of the whole record as far as the fit may go on, from an estimator that fits it at its end. None for
    /// another estimator, or if nothing explains the record.
    pub fn fit_record(&mut self, scenario: &Scenario, goes_on: GoesOn<'_>) -> Option<FoundServo> {
        if !scenario.identifier.law.takes_whole_record() {
            return None;
        }
        let samples = self.tail_buffer.samples();
        let fit = || WholeRecord::identify(scenario, samples, goes_on);
        let whole = self.whole.get_or_insert_with(fit);
        whole.as_ref().map(|whole| whole.all)
    }

    /// The samples beside the model, from an estimator that fits all of them. None for another estimator, or if nothing
    /// explains them.
    pub fn seen(&mut self, scenario: &Scenario) -> Option<Seen> {
        let _ = self.fit_record(scenario, &|| true);
        let whole = self.whole.as_ref()?.as_ref()?;
        Seen::new(scenario, self.tail_buffer.samples(), whole)
    }

    /// The summary of a run that has ended.
    #[must_use]
    pub fn finish(mut self, scenario: &Scenario, mut outcome: Outcome) -> Summary {
        let is_whole = scenario.identifier.law.takes_whole_record();
        if outcome.abort.is_none() {
            let _ = self.fit_record(scenario, &|| true);
        }
        let whole = self.whole.take().flatten();
        if let Some(whole) = &whole {
            self.take(whole);
            outcome.terms.clone_from(&whole.terms);
        }
        let estimated = scenario.estimated();
        let judged = self.judged();
        let unknowns: Vec<Unknown> = (estimated.iter().copied().map(Unknown::from))
            .chain(outcome.terms.iter().map(|term| term.unknown))
            .collect();
        let mut meter = NoiseMeter::new(scenario.stated.resolution);
        for sample in self.tail_buffer.samples() {
            meter.add(sample.position, sample.begins);
        }
        let mut noise = meter.noise();
        // Differences of a quick motion may hold some of it, which a model explains.
        if let Some(whole) = &whole
            && noise
                .moving_counts
                .is_some_and(|counts| counts > whole.noise)
        {
            noise.moving_counts = Some(whole.noise);
            noise.moving = Some(whole.noise * scenario.stated.resolution);
        }
        let assessment = if is_whole {
            let whole = whole.as_ref();
            whole.map(|whole| Assessment::of_fit(whole, &unknowns))
        } else if cfg!(feature = "experiments") && outcome.abort.is_none() {
            // A page with the fit of a whole record has no other estimator.
            let judged = VerifiedEstimate {
                scenario,
                servo: judged,
                terms: &outcome.terms,
                unknowns: &unknowns,
            };
            Assessment::of_estimator(&judged, self.tail_buffer.samples(), self.effort)
        } else {
            None
        };
        let parameters: Vec<(Parameter, &Tracked, f64)> = (PARAMETERS.iter().zip(&self.tracked))
            .filter(|(parameter, _)| estimated.contains(parameter))
            .map(|(parameter, tracked)| (*parameter, tracked, parameter.value_in(&judged)))
            .collect();
        let mut evidence = evidence::gather(&Known {
            motion: Motion {
                samples: outcome.samples,
                counts_travelled: self.travelled / scenario.stated.resolution,
            },
            outcome: &outcome,
            required: scenario.stated.identifier.terms.demanded,
            parameters: &parameters,
            assessment: assessment.as_ref(),
        });
        let fit = assessment.as_ref().and_then(|found| found.fit);
        [evidence.fit, evidence.judged_by] = if is_whole { [fit, None] } else { [None, fit] };
        evidence.prediction = self.prediction;
        evidence.not_a_servo = is_whole && whole.is_none();
        let verdict = Verdict::on(&evidence);
        let reason = evidence::reason(&verdict, scenario, &outcome);
        let found = |unknown: Unknown| {
            let mut unknowns = evidence.unknowns();
            unknowns.find(|(known, _)| *known == unknown)
        };
        let estimate = |parameter: Parameter| {
            let unknown = Unknown::from(parameter);
            let of = found(unknown);
            let tolerance = of.map_or(0.0, |(_, of)| of.still(unknown));
            // In one direction only their difference is known.
            let is_one_force = verdict.reason == VerdictReason::OneDirection
                && matches!(parameter, Parameter::Coulomb | Parameter::Load);
            let of = of.filter(|_| !is_one_force);
            Estimate {
                std_error: of.map_or(is_one_force.then_some(f64::INFINITY), |(_, of)| {
                    of.uncertainty()
                }),
                state: match of {
                    Some((_, of)) if !verdict.hides_all() => of.state(unknown),
                    _ => State::Unknown,
                },
                unit: unknown.unit(),
                value: parameter.value_in(&judged),
                is_estimated: estimated.contains(&parameter),
                ..self.tracked[place(parameter)].estimate(|_| tolerance)
            }
        };
        let seconds = |samples: u64| samples as f64 * self.sample_time;
        let term = |term: &TermEstimate| TermSize {
            unknown: term.unknown,
            value: term.value,
            std_error: found(term.unknown)
                .and_then(|(_, of)| of.uncertainty())
                .unwrap_or(term.std_error),
            since: seconds(term.since),
            unit: term.unknown.unit(),
        };
        let still_outside = |outside: Option<f64>| outside.is_some_and(|time| time >= self.end);
        let known = self.truth.is_some() && verdict.status != Status::Aborted;
        let settling = |outside: Option<f64>| {
            (known && !still_outside(outside))
                .then(|| outside.map_or(0.0, |time| time + self.sample_time))
        };
        let estimates = Estimates {
            a: estimate(Parameter::A),
            b: estimate(Parameter::B),
            coulomb: estimate(Parameter::Coulomb),
            load: estimate(Parameter::Load),
            terms: outcome.terms.iter().map(term).collect(),
        };
        let covariance = (assessment.as_ref())
            .map(|found| estimates.covariance(|one, other| found.covariance(one, other)));
        let ratios = estimates.ratios(scenario.is_linear());
        let finding = assessment.as_ref().and_then(|found| found.finding.clone());
        let scale = scenario.physical.scale();
        let is_voltage = scenario.physical.command_unit == CommandUnit::Volt;
        Summary {
            law: scenario.identifier.law.name(),
            arithmetic: scenario.identifier.arithmetic.name(),
            samples: outcome.samples,
            sample_time: self.sample_time,
            verdict,
            reason,
            rejection_reason: outcome.rejection_reason,
            cause: finding.filter(|finding| finding.or.is_none()),
            covariance,
            // Where there is no servo, there are no units of it.
            physical: scale.and_then(|scale| ratios.scaled(scale).ok()),
            voltage_gains: (is_voltage.then(|| ratios.voltage_gains().ok())).flatten(),
            estimates,
            truth: self.truth,
            output_error: self.has_model.then(|| OutputError {
                rms: self.error_squares.mean().unwrap_or(0.0).sqrt(),
                max: self.error_peak,
            }),
            settling_time: SettlingTime {
                a: settling(self.outside_a),
                b: settling(self.outside_b),
            },
            terms_entered: (outcome.entered.iter())
                .map(|(term, since)| (*term, seconds(*since)))
                .collect(),
            residual: assessment.as_ref().and_then(|found| found.residual),
            noise,
            outcome,
            fit: whole.map(|whole| whole.notes),
            replay: ReplayNotes::default(),
            reachable: (self.reachable.as_ref())
                .map_or_else(Vec::new, |reachable| reachable.standard_errors()),
        }
    }
}

/// The place of a parameter in [`PARAMETERS`].
fn place(parameter: Parameter) -> usize {
    match parameter {
        Parameter::A => 0,
        Parameter::B => 1,
        Parameter::Coulomb => 2,
        Parameter::Load => 3,
    }
}
