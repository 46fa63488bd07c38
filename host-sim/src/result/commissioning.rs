//! The result of a commissioning.

use std::collections::BTreeMap;
use std::fmt;

use commissioning::{HoldingGains, LargestMotion, Limits, Phase, TrialResult};
use identifier_core::parameters::{IdentifiedServo, ServoParameters, Unknown};
use identifier_core::reason::Reason;
use identifier_core::tuning::{Cap, PredictedResponse, Resonance, Tuning, TuningError};
use serde::{Serialize, Serializer};

use crate::commission::{Excursion, FrequencyResponse, Outcome, PhaseSpan};
use crate::scenario::Scenario;
use identifier_log::result::Gains;
use identifier_log::verdict::Cause;

/// The end of a commissioning, simulated or of a drive.
#[derive(Debug, Clone, Serialize)]
pub struct CommissioningEnd {
    /// Name of the phase that it ended in.
    pub status: &'static str,
    /// Number of the reason; 0 where the new gains hold, none for one that did not end.
    pub code: Option<u8>,
    /// The reason why there are no new gains.
    #[serde(serialize_with = "identifier_log::result::serialize_reason")]
    pub reason: Option<Reason>,
    /// The reason why no gains were found, with the possible value.
    pub no_gains: Option<Untuned>,
    /// Sample time, s.
    pub sample_time: f64,
    /// Limits on the axis.
    pub limits: Limits,
    /// The largest motion before the servo is known.
    #[serde(serialize_with = "motion")]
    pub largest_motion: LargestMotion,
    /// The identified servo.
    #[serde(serialize_with = "servo")]
    pub servo: Option<IdentifiedServo>,
    /// Standard deviation of the position that the model leaves unexplained, rad.
    pub unexplained: Option<f64>,
    /// The gains before.
    pub gains_before: Option<Gains>,
    /// The new gains.
    pub gains: Option<Gains>,
    /// ω of the poles, rad/s.
    pub bandwidth: Option<f64>,
    /// The reason why it is not faster.
    pub cap: Option<&'static str>,
    /// Predicted response of the new gains.
    pub predicted_response: Option<PredictedResponse>,
    /// Measurements of the trial.
    pub trial: Option<TrialResult>,
    /// Standard deviation of the encoder's noise at rest before the first motion, rad; 0 where rounding hides it.
    pub encoder_noise: f64,
    /// Names of the effects that its model lacks, by the fit of what it recorded.
    pub effects: Vec<&'static str>,
}

/// Why there are no gains for a servo, with the figure that is possible.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Untuned {
    /// The reason in words.
    pub message: String,
    /// The requested bandwidth, rad/s, where it is too high.
    pub bandwidth: Option<f64>,
    /// The largest possible one, rad/s.
    pub most: Option<f64>,
    /// The cause of that limit.
    pub cap: Option<&'static str>,
}

/// What a commissioning found, simulated or of a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct CommissioningOutcome {
    /// The phase that it ended in.
    pub phase: Phase,
    /// Why there are no new gains; none where they hold.
    pub reason: Option<Reason>,
    /// The identified servo.
    pub servo: Option<IdentifiedServo>,
    /// The new gains, and their predicted response.
    pub tuning: Option<Tuning>,
    /// Why no gains were found.
    pub untuned: Option<Untuned>,
    /// Measurements of the trial.
    pub trial: Option<TrialResult>,
    /// Standard deviation of the encoder's noise at rest before the first motion, rad.
    pub noise: f64,
}

/// The result of a simulated commissioning.
#[derive(Debug, Clone, Serialize)]
pub struct CommissioningResult {
    /// Its end.
    #[serde(flatten)]
    pub end: CommissioningEnd,
    /// Name of the phase in which the end was decided.
    pub phase: Option<&'static str>,
    /// The number format's name.
    pub arithmetic: &'static str,
    /// Samples run.
    pub samples: u64,
    /// Time at which it ended, s.
    pub duration: Option<f64>,
    /// The phases, in their order.
    pub phases: Vec<PhaseSpan>,
    /// The motion that there was, in truth, and the commands that acted.
    pub extremes: Excursion,
    /// The frequency response that was measured.
    #[serde(serialize_with = "response")]
    pub response: Option<FrequencyResponse>,
    /// The true servo, with its delay.
    #[serde(serialize_with = "truth")]
    pub truth: Option<[f64; 5]>,
}

/// The identified unknowns, with their places in the covariance.
pub const COMMISSIONED: [(Unknown, usize); 5] = [
    (Unknown::A, IdentifiedServo::A),
    (Unknown::B, IdentifiedServo::B),
    (Unknown::Coulomb, IdentifiedServo::COULOMB),
    (Unknown::Load, IdentifiedServo::LOAD),
    (Unknown::Delay, IdentifiedServo::DELAY),
];

/// The values in the order of [`COMMISSIONED`].
#[must_use]
pub fn commissioned_values(parameters: &ServoParameters, delay: f64) -> [f64; 5] {
    [
        parameters.a,
        parameters.b,
        parameters.coulomb,
        parameters.load,
        delay,
    ]
}

/// Those of a scenario's servo, at its start. A slow current loop delays by its time constant.
#[must_use]
pub fn commissioned_truth(scenario: &Scenario) -> Option<[f64; 5]> {
    let effects = &scenario.effects;
    let delay = effects.delay + effects.current_loop;
    let plant = scenario.plant.as_ref();
    plant.map(|plant| commissioned_values(plant, delay))
}

impl CommissioningEnd {
    /// The end of a commissioning of a sample time, s, within limits.
    #[must_use]
    pub fn new(
        sample_time: f64,
        limits: &Limits,
        largest: &LargestMotion,
        before: Option<&HoldingGains>,
        outcome: &CommissioningOutcome,
        effects: &[Cause],
    ) -> Self {
        let &CommissioningOutcome { phase, reason, .. } = outcome;
        let tuning = outcome.tuning.as_ref();
        Self {
            status: phase.name(),
            code: Some(reason.map_or(0, Reason::number)),
            reason,
            no_gains: outcome.untuned.clone(),
            sample_time,
            limits: *limits,
            largest_motion: *largest,
            servo: outcome.servo,
            unexplained: outcome.servo.map(|servo| servo.unexplained),
            gains_before: before.map(|gains| Gains::of(&gains.controller, gains.cutoff)),
            gains: tuning.map(Gains::tuned),
            bandwidth: tuning.map(|tuning| tuning.bandwidth),
            cap: tuning.and_then(|tuning| tuning.cap).map(Cap::name),
            predicted_response: tuning.map(|tuning| tuning.predicted_response),
            trial: outcome.trial,
            encoder_noise: outcome.noise,
            effects: effects.iter().map(|cause| cause.name()).collect(),
        }
    }
}

impl CommissioningResult {
    /// The result of a commissioning that has run.
    #[must_use]
    pub fn new(
        scenario: &Scenario,
        limits: &Limits,
        largest: &LargestMotion,
        before: Option<&HoldingGains>,
        outcome: &Outcome,
        effects: &[Cause],
    ) -> Self {
        let end = outcome.end.as_ref();
        let as_of_a_drive = CommissioningOutcome {
            phase: end.map_or(Phase::Idle, |end| end.phase),
            reason: outcome.reason(),
            servo: outcome.servo().copied(),
            tuning: outcome.tuning,
            untuned: outcome.no_gains.as_ref().map(Untuned::from),
            trial: outcome.trial,
            noise: outcome.noise,
        };
        let sample_time = scenario.sample_time();
        let common = CommissioningEnd::new(
            sample_time,
            limits,
            largest,
            before,
            &as_of_a_drive,
            effects,
        );
        let common = match end {
            Some(_) => common,
            None => CommissioningEnd {
                status: "unfinished",
                code: None,
                ..common
            },
        };
        Self {
            end: common,
            phase: end.map(|end| end.within.name()),
            arithmetic: scenario.identifier.arithmetic.name(),
            samples: outcome.course.samples(),
            duration: end.map(|end| end.time),
            phases: outcome.course.phases.clone(),
            extremes: outcome.course.excursion(),
            response: outcome.response.clone(),
            truth: commissioned_truth(scenario),
        }
    }
}

impl<Name: fmt::Display> From<&TuningError<Name>> for Untuned {
    fn from(error: &TuningError<Name>) -> Self {
        let (bandwidth, most, cap) = match *error {
            TuningError::TooFast {
                bandwidth,
                most,
                cap,
            } => (Some(bandwidth), Some(most), Some(cap.name())),
            _ => (None, None, None),
        };
        Self {
            message: error.to_string(),
            bandwidth,
            most,
            cap,
        }
    }
}

fn motion<S: Serializer>(motion: &LargestMotion, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Keys {
        travel: [f64; 2],
        speed: f64,
    }
    let keys = Keys {
        travel: motion.travel,
        speed: motion.speed,
    };
    keys.serialize(serializer)
}

fn servo<S: Serializer>(servo: &Option<IdentifiedServo>, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Keys {
        value: f64,
        std_error: f64,
        unit: &'static str,
    }
    let unknowns = servo.as_ref().map(|servo| {
        let values = commissioned_values(&servo.parameters, servo.delay);
        let unknowns = COMMISSIONED.into_iter().zip(values);
        let keys = unknowns.map(|((unknown, place), value)| {
            let keys = Keys {
                value,
                std_error: servo.standard_error(place),
                unit: unknown.unit(),
            };
            (unknown.name(), keys)
        });
        keys.collect::<BTreeMap<_, _>>()
    });
    unknowns.serialize(serializer)
}

fn response<S: Serializer>(
    response: &Option<FrequencyResponse>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Line {
        frequency: f64,
        gain: [f64; 2],
        std_dev: f64,
    }
    #[derive(Serialize)]
    struct Found {
        frequency: f64,
        antiresonance: f64,
        damping: f64,
        inertia_ratio: f64,
        relative_std_errors: [f64; 2],
    }
    #[derive(Serialize)]
    struct Keys {
        highest_frequency: f64,
        resonance: Option<Found>,
        lines: Vec<Line>,
    }
    let keys = response.as_ref().map(|response| Keys {
        highest_frequency: response.highest_frequency(),
        resonance: response
            .resonance
            .map(|Resonance { mode, errors, .. }| Found {
                frequency: mode.frequency,
                antiresonance: mode.antiresonance(),
                damping: mode.damping,
                inertia_ratio: mode.ratio,
                relative_std_errors: errors,
            }),
        lines: (response.lines.iter())
            .map(|line| Line {
                frequency: line.frequency,
                gain: [line.gain.re, line.gain.im],
                std_dev: line.deviation,
            })
            .collect(),
    });
    keys.serialize(serializer)
}

fn truth<S: Serializer>(truth: &Option<[f64; 5]>, serializer: S) -> Result<S::Ok, S::Error> {
    let names = COMMISSIONED.map(|(unknown, _)| unknown.name());
    let truth = truth.map(|values| names.into_iter().zip(values).collect::<BTreeMap<_, _>>());
    truth.serialize(serializer)
}
