//! The result of a comparison of methods.

use identifier_core::parameters::Parameter;
use serde::Serialize;

use super::Summary;
use crate::analysis::Status;
use crate::compare::{Comparison, MethodResult};

/// The errors of every method in every case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparisonResult {
    /// The cases, in order.
    pub cases: Vec<CaseResult>,
}

/// One case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseResult {
    /// Its name.
    pub case: &'static str,
    /// Its conditions.
    pub detail: String,
    /// The methods, in the order of the comparison.
    pub methods: Vec<MethodErrors>,
}

/// Errors of a method in a case, estimate less truth, SI; none where it has no estimate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodErrors {
    /// The method's name.
    pub law: &'static str,
    /// Its status, or `refused`.
    pub status: &'static str,
    /// The reason of the status.
    pub reason: String,
    /// Of a, 1/s.
    pub error_a: Option<f64>,
    /// Of b, rad/s² per command unit.
    pub error_b: Option<f64>,
    /// Of the Coulomb friction, rad/s².
    pub error_coulomb: Option<f64>,
    /// Of the load, rad/s².
    pub error_load: Option<f64>,
    /// When a settled, s.
    pub settling_a: Option<f64>,
    /// When b settled, s.
    pub settling_b: Option<f64>,
    /// Arithmetic operations per sample.
    pub operations: Option<f64>,
    /// The true b, rad/s² per command unit.
    #[serde(skip)]
    pub true_b: f64,
}

impl ComparisonResult {
    /// Of a comparison.
    #[must_use]
    pub fn new(comparison: &Comparison) -> Self {
        let cases = comparison.cases.iter().map(|compared| CaseResult {
            case: compared.case.name,
            detail: compared.case.detail.clone(),
            methods: comparison
                .methods
                .iter()
                .zip(&compared.results)
                .map(|(method, found)| {
                    let (summary, reason) = match found {
                        MethodResult::Ran(summary) => (Some(summary.as_ref()), &summary.reason),
                        MethodResult::Refused(why) => (None, why),
                    };
                    let error = |parameter| error(summary?, parameter);
                    MethodErrors {
                        law: method.name,
                        status: summary.map_or("refused", |summary| summary.status().name()),
                        reason: reason.clone(),
                        error_a: error(Parameter::A),
                        error_b: error(Parameter::B),
                        error_coulomb: error(Parameter::Coulomb),
                        error_load: error(Parameter::Load),
                        settling_a: summary.and_then(|summary| summary.settling_time.a),
                        settling_b: summary.and_then(|summary| summary.settling_time.b),
                        operations: method.operations,
                        true_b: compared.case.scenario.plant.map_or(1.0, |plant| plant.b),
                    }
                })
                .collect(),
        });
        Self {
            cases: cases.collect(),
        }
    }
}

/// Mean over the last quarter less the truth; none where the method has no estimate.
pub(crate) fn error(summary: &Summary, parameter: Parameter) -> Option<f64> {
    let truth = summary.truth.as_ref()?;
    let estimate = summary.estimate(parameter)?;
    let error = estimate.tail_mean - parameter.of(truth);
    (summary.status() != Status::Aborted && error.is_finite()).then_some(error)
}
