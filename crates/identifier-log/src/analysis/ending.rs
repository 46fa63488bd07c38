//! The end of an identification, from which its summary follows.

use identifier_core::parameters::{Parameter, ServoParameters, Unknown};
use identifier_core::stability::SampledLoopError;
use log_fit::Logged;

use super::assessment::Assessment;
use super::evidence::{self, Known};
use super::rough::RoughAnswer;
use super::sensor_noise::NoiseMeter;
use super::whole_record::WholeRecord;
use crate::experiment::{Outcome, TermEstimate};
use crate::result::{
    Estimate, Estimates, FitNotes, OutputError, ReplayNotes, SettlingTime, Summary, TermSize,
};
use crate::scenario::{CommandUnit, Options};
use crate::verdict::{Motion, Residual, State, Status, Verdict, VerdictReason};

/// How the estimates came about.
#[derive(Debug)]
pub enum EstimationMethod<'a> {
    /// By a fit to the whole record, with what it leaves from one sample to the next; none: nothing explains the record. Its time
    /// scales have the rough answer.
    Fit(Option<(&'a WholeRecord, Option<Residual>)>, &'a RoughAnswer),
    /// By an estimator that was shown sample by sample, and how the record judges its estimates.
    Recursive(Option<Assessment>),
}

/// An identification that has ended.
pub struct Ending<'a> {
    /// What is stated of it.
    pub options: &'a Options,
    /// The method.
    pub method: EstimationMethod<'a>,
    /// Its samples, or the last of them.
    pub samples: &'a [Logged],
    /// Distance that the servo travelled, forth and back, rad.
    pub travelled: f64,
    /// The course of the estimator.
    pub outcome: Outcome,
    /// The estimates that are judged, SI.
    pub servo: ServoParameters,
    /// The course of an estimate, with the tolerance within which it counts as being at rest.
    pub course: &'a dyn Fn(Parameter, f64) -> Estimate,
    /// The largest error with which the estimates predicted an unseen motion, relative to the motion.
    pub prediction: Option<f64>,
    /// The true servo, where it is known.
    pub truth: Option<ServoParameters>,
    /// The output error of an estimator with a model.
    pub output_error: Option<OutputError>,
    /// Times at which the estimates came near the truth, s.
    pub settling_time: SettlingTime,
    /// Why the loop cannot hold its servo.
    pub unstable_loop: Option<SampledLoopError>,
}

impl std::fmt::Debug for Ending<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Ending")
            .field("servo", &self.servo)
            .finish_non_exhaustive()
    }
}

impl Ending<'_> {
    /// Its summary.
    #[must_use]
    pub fn summary(self) -> Summary {
        let (options, course) = (self.options, self.course);
        let (mut outcome, mut servo) = (self.outcome, self.servo);
        let (rough, fitted, refit) = match self.method {
            EstimationMethod::Fit(fitted, rough) => (Some(rough), fitted, None),
            EstimationMethod::Recursive(refit) => (None, None, refit),
        };
        let is_whole = rough.is_some();
        let mut whole = fitted.map(|(whole, _)| whole);
        if let Some(whole) = whole {
            outcome.terms.clone_from(&whole.terms);
        }
        let estimated = options.estimated();
        let unknowns: Vec<Unknown> = (estimated.iter().copied().map(Unknown::from))
            .chain(outcome.terms.iter().map(|term| term.unknown))
            .collect();
        let mut meter = NoiseMeter::new(options.stated.resolution);
        for sample in self.samples {
            meter.add(sample.position, sample.begins);
        }
        let mut noise = meter.noise();
        // Differences of a quick motion may hold some of it, which a model explains.
        if let Some(whole) = whole
            && noise
                .moving_counts
                .is_some_and(|counts| counts > whole.noise)
        {
            noise.moving_counts = Some(whole.noise);
            noise.moving = Some(whole.noise * options.stated.resolution);
        }
        let assessment = match whole {
            Some(whole) => Some(Assessment::of_fit(whole, &unknowns)),
            None => refit,
        };
        let mut evidence = evidence::gather(&Known {
            motion: Motion {
                samples: outcome.samples,
                counts_travelled: self.travelled / options.stated.resolution,
            },
            outcome: &outcome,
            required: options.stated.identifier.terms.demanded,
            parameters: &estimated,
            servo: &servo,
            course,
            assessment: assessment.as_ref(),
        });
        let fit = assessment.as_ref().and_then(|found| found.fit);
        [evidence.fit, evidence.judged_by] = if is_whole { [fit, None] } else { [None, fit] };
        evidence.prediction = self.prediction;
        evidence.not_a_servo = is_whole && whole.is_none();
        evidence.innovation = fitted.and_then(|(_, innovation)| innovation);
        evidence.command_was_computed = options.inner.is_some();
        evidence.is_assumed = (options.reading.as_ref()).is_some_and(|of| !of.assumed.is_empty());
        evidence.gain_of_scales = rough.and_then(RoughAnswer::gain_of_fit);
        let mut verdict = Verdict::on(&evidence);
        let mut refused = None;
        let instead = rough.and_then(|rough| rough.instead(&verdict, &evidence));
        if let Some((rough, rough_verdict)) = instead {
            refused = Some(std::mem::replace(&mut verdict, rough_verdict).reason);
            servo = rough.servo;
            for parameter in Parameter::ALL {
                evidence.replace(parameter, &rough.servo, &rough.std_errors);
            }
            (whole, outcome.terms) = (None, Vec::new());
        }
        let reason = evidence::reason(
            &verdict,
            refused,
            options.motion_unit(),
            self.unstable_loop,
            &outcome,
        );
        let position_unit = options.motion_unit();
        let scales_differ = matches!(verdict.reason, VerdictReason::ScalesDiffer { .. });
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
                    Some((_, of)) if !verdict.hides_all() => match of.state(unknown) {
                        _ if unknown == Unknown::B && scales_differ => State::Unknown,
                        State::Unknown => State::Unknown,
                        _ if instead.is_some() => State::Rough,
                        state => state,
                    },
                    _ => State::Unknown,
                },
                unit: position_unit.of(unknown),
                value: servo.get(parameter),
                is_estimated: estimated.contains(&parameter),
                ..match instead {
                    Some(_) => Estimate::of_fit(servo.get(parameter)),
                    None => course(parameter, tolerance),
                }
            }
        };
        let seconds = |samples: u64| samples as f64 * options.sample_time();
        let term = |term: &TermEstimate| TermSize {
            unknown: term.unknown,
            value: term.value,
            std_error: found(term.unknown)
                .and_then(|(_, of)| of.uncertainty())
                .unwrap_or(term.std_error),
            since: seconds(term.since),
            unit: position_unit.of(term.unknown),
        };
        let estimates = Estimates {
            a: estimate(Parameter::A),
            b: estimate(Parameter::B),
            coulomb: estimate(Parameter::Coulomb),
            load: estimate(Parameter::Load),
            terms: outcome.terms.iter().map(term).collect(),
        };
        let covariance = (assessment.as_ref().filter(|_| instead.is_none()))
            .map(|found| estimates.covariance(|one, other| found.covariance(one, other)));
        let axis = position_unit.axis().ok().filter(|_| !evidence.is_assumed);
        let ratios = axis.map(|axis| estimates.ratios(covariance.as_ref(), axis));
        let finding = assessment.as_ref().and_then(|found| found.finding.clone());
        let scale = options.physical.scale();
        let is_voltage = options.physical.command_unit == CommandUnit::Volt;
        let settling_time = match verdict.status {
            Status::Aborted => SettlingTime { a: None, b: None },
            _ => self.settling_time,
        };
        Summary {
            law: options.identifier.law.name(),
            arithmetic: options.identifier.arithmetic.name(),
            samples: outcome.samples,
            sample_time: options.sample_time(),
            verdict,
            reason,
            rejection_reason: outcome.rejection_reason,
            refused,
            cause: finding.filter(|finding| finding.or.is_none()),
            covariance,
            position_unit,
            // Where there is no servo, there are no units of it.
            physical: scale.and_then(|scale| ratios?.scaled(scale).ok()),
            voltage_gains: (is_voltage.then(|| ratios?.voltage_gains().ok())).flatten(),
            estimates,
            truth: self.truth,
            output_error: self.output_error,
            settling_time,
            terms_entered: (outcome.entered.iter())
                .map(|(term, since)| (*term, seconds(*since)))
                .collect(),
            residual: assessment.as_ref().and_then(|found| found.residual),
            noise,
            fit: is_whole.then(|| {
                let none = || FitNotes {
                    samples: outcome.samples,
                    ..FitNotes::default()
                };
                whole.map_or_else(none, |whole| whole.notes.clone())
            }),
            scales: rough.map_or_else(Vec::new, |rough| rough.scales.clone()),
            reading: options.log_reading(),
            replay: ReplayNotes::default(),
            outcome,
        }
    }
}
