//! The machine-readable result.

use std::collections::BTreeMap;

use identifier_core::parameters::Parameter;
use identifier_core::unknowns::Unknown;
use serde::Serialize;

use crate::analysis::{Finding, Summary};
use crate::experiment::TermEstimate;
use crate::replay::Agreement;
use crate::report::logs::{LogDocument, PredictionDocument};

/// The result of one experiment as the command line promises it.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct Document {
    pub law: &'static str,
    pub arithmetic: &'static str,
    pub samples: u64,
    pub sample_time: f64,
    pub status: &'static str,
    pub code: u8,
    pub reason: String,
    pub cause: Option<CauseDocument>,
    pub estimates: Estimates,
    pub truth: Option<Truth>,
    pub output_error: Option<OutputError>,
    pub settling_time: SettlingTime,
    pub terms_entered: BTreeMap<&'static str, f64>,
    pub slowed_samples: u64,
    pub model_restarts: u64,
    pub standing_samples: u64,
    pub load_steps: u64,
    pub not_following_samples: u64,
    pub certified: bool,
    pub gain_margin: Option<f64>,
    pub gamma: Option<Vec<Vec<f64>>>,
    pub mu: Option<f64>,
    pub residual: Option<Residual>,
    pub agreement: Option<AgreementDocument>,
    pub logs: Vec<LogDocument>,
    pub predictions: Vec<PredictionDocument>,
}

/// How well the declared controller reproduces the recorded command of a log.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct AgreementDocument {
    pub holds: bool,
    pub relative: f64,
    pub largest: f64,
    pub line: u64,
}

/// What the output error says of the model.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct Residual {
    pub rms: f64,
    pub resolution_rms: f64,
    pub correlation: f64,
}

/// What the model lacks, where something stands out.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct CauseDocument {
    pub name: &'static str,
    pub meaning: &'static str,
    pub remedy: &'static str,
    pub share: f64,
    pub size: f64,
    pub unit: &'static str,
    pub shifts: BTreeMap<&'static str, f64>,
}

/// The estimates, null where the law has none.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct Estimates {
    pub a: Option<EstimateDocument>,
    pub b: Option<EstimateDocument>,
    pub coulomb: Option<EstimateDocument>,
    pub load: Option<EstimateDocument>,
    #[serde(flatten)]
    pub terms: BTreeMap<&'static str, TermDocument>,
}

/// The size of an optional term that has entered.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct TermDocument {
    #[serde(rename = "final")]
    pub last: f64,
    pub std_error: f64,
    pub since: f64,
    pub unit: &'static str,
}

/// One estimate.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct EstimateDocument {
    #[serde(rename = "final")]
    pub last: f64,
    pub tail_mean: f64,
    pub tail_std: f64,
    pub std_error: Option<f64>,
    pub at_bound: bool,
    pub unit: &'static str,
}

/// The true servo.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct Truth {
    pub a: f64,
    pub b: f64,
    pub coulomb: f64,
    pub load: f64,
}

/// The output error, rad.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct OutputError {
    pub rms: f64,
    pub max: f64,
}

/// Settling times, s; null where the estimate had not settled.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct SettlingTime {
    pub a: Option<f64>,
    pub b: Option<f64>,
}

impl TermDocument {
    fn new(term: &TermEstimate, sample_time: f64) -> Self {
        Self {
            last: term.value,
            std_error: term.std_error,
            since: term.since as f64 * sample_time,
            unit: term.unknown.unit(),
        }
    }
}

impl CauseDocument {
    fn new(finding: &Finding) -> Self {
        let shifts = finding.shifts.iter();
        Self {
            name: finding.cause.name(),
            meaning: finding.cause.meaning(),
            remedy: finding.cause.remedy(),
            share: finding.share,
            size: finding.size,
            unit: finding.unit,
            shifts: shifts
                .map(|(unknown, shift)| (unknown.name(), *shift))
                .collect(),
        }
    }
}

impl Document {
    /// The document of a summary.
    #[must_use]
    pub fn new(summary: &Summary, agreement: Option<&Agreement>) -> Self {
        let events = &summary.outcome.events;
        let document = |parameter: Parameter| {
            summary
                .estimate(parameter)
                .map(|estimate| EstimateDocument {
                    last: estimate.last,
                    tail_mean: estimate.tail_mean,
                    tail_std: estimate.tail_std,
                    std_error: estimate.std_error,
                    at_bound: estimate.at_bound,
                    unit: Unknown::from(parameter).unit(),
                })
        };
        Self {
            law: summary.law,
            arithmetic: summary.arithmetic,
            samples: summary.outcome.samples,
            sample_time: summary.sample_time,
            status: summary.status().name(),
            code: summary.verdict.reason.code(),
            reason: summary.reason.clone(),
            cause: summary.cause().map(CauseDocument::new),
            estimates: Estimates {
                a: document(Parameter::A),
                b: document(Parameter::B),
                coulomb: document(Parameter::Coulomb),
                load: document(Parameter::Load),
                terms: (summary.outcome.terms.iter())
                    .map(|term| {
                        (
                            term.unknown.name(),
                            TermDocument::new(term, summary.sample_time),
                        )
                    })
                    .collect(),
            },
            truth: summary.truth.map(|truth| Truth {
                a: truth.a,
                b: truth.b,
                coulomb: truth.coulomb,
                load: truth.load,
            }),
            output_error: summary
                .output_error
                .map(|(rms, max)| OutputError { rms, max }),
            settling_time: SettlingTime {
                a: summary.settling_a,
                b: summary.settling_b,
            },
            terms_entered: (summary.outcome.entered.iter())
                .map(|(term, since)| (term.name(), *since as f64 * summary.sample_time))
                .collect(),
            slowed_samples: events.slowed,
            model_restarts: events.restarted,
            standing_samples: events.standing,
            load_steps: events.load_steps,
            not_following_samples: events.not_following,
            certified: summary.outcome.certified,
            gain_margin: summary.outcome.gain_margin,
            gamma: summary.outcome.gamma.clone(),
            mu: summary.outcome.mu,
            residual: summary.batch.as_ref().map(|batch| Residual {
                rms: batch.residual.rms,
                resolution_rms: batch.residual.resolution_rms,
                correlation: batch.residual.correlation,
            }),
            agreement: agreement.map(|agreement| AgreementDocument {
                holds: agreement.holds(),
                relative: agreement.relative(),
                largest: agreement.largest,
                line: agreement.line,
            }),
            logs: Vec::new(),
            predictions: Vec::new(),
        }
    }

    /// With what there is to be said of the logs of a replay.
    #[must_use]
    pub fn of_logs(self, logs: Vec<LogDocument>, predictions: Vec<PredictionDocument>) -> Self {
        Self {
            logs,
            predictions,
            ..self
        }
    }
}
