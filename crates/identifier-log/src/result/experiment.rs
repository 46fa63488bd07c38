//! The result of a run or a replay.

use std::collections::BTreeMap;

use identifier_core::parameters::{Parameter, ServoParameters, Term, Unknown};
use identifier_core::reason::Reason;
use serde::{Deserialize, Serialize, Serializer};

use super::{Finding, FitNotes, LogReading, Prediction, Reading, ScaleEstimate};
use crate::experiment::Outcome;
use crate::motion_unit::{AxisKind, MotionUnit};
use crate::physical::{Physical, Ratios, VoltageGains};
use crate::replay::Agreement;
use crate::verdict::{Residual, State, Status, Verdict, VerdictReason};

/// The result of a run or a replay.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The estimator's name.
    pub law: &'static str,
    /// The number format's name.
    pub arithmetic: &'static str,
    /// Samples run.
    pub samples: u64,
    /// Sample time, s.
    pub sample_time: f64,
    /// Reliability of the estimates, with the reason.
    #[serde(flatten, serialize_with = "verdict")]
    pub verdict: Verdict,
    /// The verdict's reason in words, and remarks on the run.
    pub reason: String,
    /// Why an estimator that begins by a fit had none after a second of motion.
    #[serde(serialize_with = "serialize_reason")]
    #[serde(rename = "first_fit_rejection")]
    pub rejection_reason: Option<Reason>,
    /// The effect that the model lacks, if one is distinct.
    pub cause: Option<Finding>,
    /// The unit of positions, and what errors of them and noise are in.
    pub position_unit: MotionUnit,
    /// The estimates.
    pub estimates: Estimates,
    /// The covariance of the estimates that were judged by the record, SI.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Covariance>,
    /// The servo in physical units, where the scale of torques is stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub physical: Option<Physical>,
    /// The feed-forward of a motor driven by a voltage.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voltage_gains: Option<VoltageGains>,
    /// The true servo, where it is known.
    pub truth: Option<ServoParameters>,
    /// The output error, for estimators with a model.
    pub output_error: Option<OutputError>,
    /// Times at which the estimates came near the truth.
    pub settling_time: SettlingTime,
    /// Time at which each optional term entered the model, s.
    #[serde(serialize_with = "entries")]
    pub terms_entered: Vec<(Term, f64)>,
    /// Record of the run itself.
    #[serde(flatten)]
    pub outcome: Outcome,
    /// The output error of the model with the final estimates over the end of the run. None if that is too short, or
    /// the estimates are no servo.
    pub residual: Option<Residual>,
    /// Noise of the position sensor over the end of the run.
    pub noise: SensorNoise,
    /// The reason that refused a fit in whose place the answer is rough; its number is `refused_code`.
    #[serde(
        rename = "refused_code",
        serialize_with = "code",
        skip_serializing_if = "Option::is_none"
    )]
    pub refused: Option<VerdictReason>,
    /// Findings of a fit to the whole record, for the estimator that makes one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit: Option<FitNotes>,
    /// The gain at every time scale of the record, for that estimator.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub scales: Vec<ScaleEstimate>,
    /// How the columns of its log were read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reading: Option<Reading>,
    /// Logs and predictions of a replay.
    #[serde(flatten)]
    pub replay: ReplayNotes,
}

/// The estimates of a, b, c and d, constant if the estimator does not estimate them, and of optional terms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimates {
    /// â, 1/s.
    #[serde(serialize_with = "if_estimated")]
    pub a: Estimate,
    /// b̂, rad/s² per command unit.
    #[serde(serialize_with = "if_estimated")]
    pub b: Estimate,
    /// ĉ, rad/s².
    #[serde(serialize_with = "if_estimated")]
    pub coulomb: Estimate,
    /// d̂, rad/s².
    #[serde(serialize_with = "if_estimated")]
    pub load: Estimate,
    /// The sizes of optional terms that have entered.
    #[serde(flatten, serialize_with = "by_name")]
    pub terms: Vec<TermSize>,
}

/// One estimate over a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The value that the verdict judges and that every page, table, file and tool shows. An estimator with standard
    /// errors of its own gives the last one, which contains all samples. Others give the mean over the last quarter.
    /// NaN, like everything that follows from it, if the method had none at the end.
    pub value: f64,
    /// At the end.
    #[serde(skip)]
    pub last: f64,
    /// Mean over the last quarter.
    #[serde(skip)]
    pub tail_mean: f64,
    /// Wander: standard deviation over the last quarter.
    pub tail_std: f64,
    /// Standard error of the [value](Self::value): chance, the encoder, and the distance still to go. None if it is
    /// unknown, infinite if the motion contains no information on it.
    pub std_error: Option<f64>,
    /// The state of knowledge from the motion.
    pub state: State,
    /// True if it stood at a bound for most of the last quarter: such a value is no result.
    pub at_bound: bool,
    /// Its unit.
    pub unit: &'static str,
    /// Distance still to go at the end of the run, from the means over the thirds of the last quarter. Infinite if its
    /// steps did not get shorter.
    #[serde(skip)]
    pub remaining_change: f64,
    /// True if the estimator estimates it.
    #[serde(skip)]
    pub is_estimated: bool,
}

/// The size of an optional term that has entered.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TermSize {
    /// The unknown.
    #[serde(skip)]
    pub unknown: Unknown,
    /// Its value, SI.
    pub value: f64,
    /// Its standard error, SI.
    pub std_error: f64,
    /// Time at which the term entered, s.
    pub since: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// The covariance of estimates, with all parts of their standard errors, the squares of which are its diagonal.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Covariance {
    /// Their names, in the order of rows and columns.
    pub names: Vec<&'static str>,
    /// By rows; infinite where nothing is known of one.
    pub matrix: Vec<Vec<f64>>,
}

impl Covariance {
    /// That of two parameters.
    fn of(&self, one: Parameter, other: Parameter) -> Option<f64> {
        let place = |of: Parameter| {
            let name = Unknown::from(of).name();
            self.names.iter().position(|own| *own == name)
        };
        Some(self.matrix[place(one)?][place(other)?])
    }
}

/// Output error, rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OutputError {
    /// Root mean square.
    pub rms: f64,
    /// Largest magnitude.
    pub max: f64,
}

/// Last times at which estimates were away from the truth, s; none where one still was at the end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SettlingTime {
    /// Time of â, outside ±0.1 1/s.
    pub a: Option<f64>,
    /// Time of b̂, outside 2 %.
    pub b: Option<f64>,
}

/// Logs and predictions of a replay; empty for a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct ReplayNotes {
    /// Agreement of the declared controller with the recorded command.
    pub agreement: Option<Agreement>,
    /// Properties of the logs.
    pub logs: Vec<LogReading>,
    /// Errors of the predictions of logs.
    pub predictions: Vec<Prediction>,
}

impl Summary {
    /// The verdict's status.
    #[must_use]
    pub fn status(&self) -> Status {
        self.verdict.status
    }

    /// One estimate; none if the estimator does not estimate the parameter.
    #[must_use]
    pub fn estimate(&self, parameter: Parameter) -> Option<&Estimate> {
        let estimate = self.estimates.get(parameter);
        estimate.is_estimated.then_some(estimate)
    }
}

impl Estimate {
    /// That of a fit, which has no course.
    pub(crate) fn of_fit(value: f64) -> Self {
        let spread = if value.is_finite() { 0.0 } else { f64::NAN };
        Self {
            value,
            last: value,
            tail_mean: value,
            tail_std: spread,
            std_error: None,
            state: State::Unknown,
            at_bound: false,
            unit: "",
            remaining_change: spread,
            is_estimated: false,
        }
    }
}

impl Estimates {
    /// That of a parameter, constant if it is not estimated.
    #[must_use]
    pub fn get(&self, parameter: Parameter) -> &Estimate {
        match parameter {
            Parameter::A => &self.a,
            Parameter::B => &self.b,
            Parameter::Coulomb => &self.coulomb,
            Parameter::Load => &self.load,
        }
    }

    /// The ratios of a servo on an axis, of estimates with a covariance.
    #[must_use]
    pub fn ratios(&self, covariance: Option<&Covariance>, axis: AxisKind) -> Ratios {
        let known = |estimate: &Estimate| (estimate.value, estimate.std_error);
        let if_estimated = |estimate: &Estimate| estimate.is_estimated.then(|| known(estimate));
        Ratios {
            a: known(&self.a),
            b: known(&self.b),
            coulomb: if_estimated(&self.coulomb),
            load: if_estimated(&self.load),
            with_b: [Parameter::A, Parameter::Coulomb, Parameter::Load].map(|parameter| {
                let of = covariance.and_then(|of| of.of(parameter, Parameter::B));
                of.unwrap_or(0.0)
            }),
            axis,
        }
    }

    /// The covariance, of that of two unknowns.
    pub(crate) fn covariance(&self, of: impl Fn(Unknown, Unknown) -> Option<f64>) -> Covariance {
        let parameters = Parameter::ALL.into_iter().filter_map(|parameter| {
            let one = self.get(parameter);
            let error = one.std_error.unwrap_or(f64::INFINITY);
            one.is_estimated.then(|| (Unknown::from(parameter), error))
        });
        let terms = self.terms.iter().map(|term| (term.unknown, term.std_error));
        let known: Vec<(Unknown, f64)> = parameters.chain(terms).collect();
        let row = |&(one, error): &(Unknown, f64)| {
            let entries = known.iter().map(|&(other, _)| match one == other {
                true => error * error,
                // What was not estimated beside the others goes with none of them.
                false => of(one, other).unwrap_or(0.0),
            });
            entries.collect()
        };
        Covariance {
            names: known.iter().map(|(unknown, _)| unknown.name()).collect(),
            matrix: known.iter().map(row).collect(),
        }
    }

    /// Number of parameters that the estimator estimates.
    #[must_use]
    pub fn count(&self) -> usize {
        let all = Parameter::ALL.map(|parameter| self.get(parameter));
        all.iter().filter(|estimate| estimate.is_estimated).count()
    }
}

fn verdict<S: Serializer>(verdict: &Verdict, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Keys {
        status: &'static str,
        code: u8,
    }
    let keys = Keys {
        status: verdict.status.name(),
        code: verdict.reason.code(),
    };
    keys.serialize(serializer)
}

fn code<S: Serializer>(reason: &Option<VerdictReason>, serializer: S) -> Result<S::Ok, S::Error> {
    reason.map(|reason| reason.code()).serialize(serializer)
}

fn if_estimated<S: Serializer>(estimate: &Estimate, serializer: S) -> Result<S::Ok, S::Error> {
    let known = estimate.is_estimated.then_some(estimate);
    known.serialize(serializer)
}

fn by_name<S: Serializer>(terms: &[TermSize], serializer: S) -> Result<S::Ok, S::Error> {
    let named: BTreeMap<_, _> = terms
        .iter()
        .map(|term| (term.unknown.name(), term))
        .collect();
    named.serialize(serializer)
}

fn entries<S: Serializer>(entered: &[(Term, f64)], serializer: S) -> Result<S::Ok, S::Error> {
    let named: BTreeMap<_, _> = entered
        .iter()
        .map(|(term, since)| (term.name(), since))
        .collect();
    named.serialize(serializer)
}

/// Standard deviation of the noise of the measured position, rounding included. None if there was too little motion, or
/// standstill, to measure it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct SensorNoise {
    /// In motion, encoder counts; rounding alone is 0.29 counts.
    pub moving_counts: Option<f64>,
    /// At standstill, encoder counts; zero where the count does not change.
    pub standstill_counts: Option<f64>,
    /// In motion, rad.
    pub moving: Option<f64>,
    /// At standstill, rad.
    pub standstill: Option<f64>,
}

/// Serialises a reason of the core's catalogue with its number, cause and remedy.
///
/// # Errors
/// Those of the serialiser.
pub fn serialize_reason<S: Serializer>(
    reason: &Option<Reason>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Keys {
        number: u8,
        name: &'static str,
        cause: &'static str,
        remedy: &'static str,
    }
    let keys = reason.map(|reason| Keys {
        number: reason.number(),
        name: reason.name(),
        cause: reason.cause(),
        remedy: reason.remedy(),
    });
    keys.serialize(serializer)
}
