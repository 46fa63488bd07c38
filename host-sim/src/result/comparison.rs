//! The result of a comparison of methods.

use identifier_core::settings::ParameterRangeSettings;
use serde::{Serialize, Serializer};

use identifier_log::verdict::Status;

/// The errors of every method in every case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparisonResult {
    /// The methods, in their order.
    #[serde(skip)]
    pub methods: Vec<Method>,
    /// The cases, in order.
    pub cases: Vec<CaseResult>,
    /// The parameter range for methods that need one, if the scenario states none.
    pub assumed_range: Option<ParameterRangeSettings>,
}

/// Properties of a method that no case changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Method {
    /// Its name.
    pub name: &'static str,
    /// Its source.
    pub source: &'static str,
    /// Knowledge that it needs beforehand.
    pub prior: &'static str,
    /// The controller that closes its loop.
    pub closing: &'static str,
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
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct MethodErrors {
    /// The method's name.
    pub law: &'static str,
    /// Its status; none if the method cannot be built for this case.
    #[serde(serialize_with = "status")]
    pub status: Option<Status>,
    /// The reason of the status.
    pub reason: String,
    /// For a, 1/s.
    pub error_a: Option<f64>,
    /// Error of b, rad/s² per command unit.
    pub error_b: Option<f64>,
    /// Error of the Coulomb friction, rad/s².
    pub error_coulomb: Option<f64>,
    /// Error of the load, rad/s².
    pub error_load: Option<f64>,
    /// Settling time of a, s.
    pub settling_a: Option<f64>,
    /// Settling time of b, s.
    pub settling_b: Option<f64>,
    /// The true b, rad/s² per command unit.
    #[serde(skip)]
    pub true_b: f64,
}

impl MethodErrors {
    /// The status's name, or `refused`.
    #[must_use]
    pub fn status_name(&self) -> &'static str {
        self.status.map_or("refused", Status::name)
    }
}

fn status<S: Serializer>(status: &Option<Status>, serializer: S) -> Result<S::Ok, S::Error> {
    status.map_or("refused", Status::name).serialize(serializer)
}
