//! A comparison as tables, as JSON and as a picture.

use identifier_core::model::ServoParameters;
use identifier_core::parameters::Parameter;
use serde::Serialize;

use super::rows::Rows;
use crate::analysis::{Status, Summary};
use crate::compare::{Compared, Comparison, MethodResult};

/// What is said of the methods whatever the case.
#[must_use]
pub fn methods(comparison: &Comparison, width: u16) -> String {
    let mut table = Rows::default()
        .words("method")
        .words("from")
        .dispensable(0)
        .words("loop")
        .dispensable(1)
        .words("known beforehand")
        .dispensable(2)
        .figures("operations a sample");
    for method in &comparison.methods {
        table.row(vec![
            method.name.to_owned(),
            method.source.to_owned(),
            method.closing.to_owned(),
            method.prior.to_owned(),
            method
                .operations
                .map_or_else(|| "–".to_owned(), |mean| format!("{mean:.0}")),
        ]);
    }
    table.within(width)
}

/// The errors of every method in one case.
#[must_use]
pub fn case(compared: &Compared, comparison: &Comparison, width: u16) -> String {
    let mut table = Rows::default()
        .words("method")
        .figures("â − a [1/s]")
        .figures("b̂/b − 1")
        .figures("ĉ − c [rad/s²]")
        .dispensable(0)
        .figures("d̂ − d [rad/s²]")
        .dispensable(1)
        .figures("settled a, b [s]")
        .dispensable(2)
        .words("status");
    let mut refusals = String::new();
    for (method, found) in comparison.methods.iter().zip(&compared.results) {
        match found {
            MethodResult::Refused(why) => {
                let mut row = vec![method.name.to_owned()];
                row.extend(std::iter::repeat_n("–".to_owned(), 5));
                row.push("refused".to_owned());
                table.row(row);
                refusals += &format!("\n {}: {why}", method.name);
            }
            MethodResult::Ran(summary) => {
                table.row(row(method.name, summary));
            }
        }
    }
    table.within(width) + &refusals
}

fn row(name: &str, summary: &Summary) -> Vec<String> {
    let seconds =
        |time: Option<f64>| time.map_or_else(|| "not".to_owned(), |time| format!("{time:.2}"));
    let settled = |time: Option<f64>, of: Parameter| match error(summary, of) {
        Some(_) => seconds(time),
        None => "–".to_owned(),
    };
    let cell = |parameter, digits: usize| {
        error(summary, parameter).map_or_else(
            || "–".to_owned(),
            |error| {
                // + 0.0 turns a negative zero into zero.
                let scale = 10_f64.powi(digits as i32);
                let error = (error * scale).round() / scale + 0.0;
                format!("{error:+.digits$}")
            },
        )
    };
    let b = error(summary, Parameter::B).map_or_else(
        || "–".to_owned(),
        |error| {
            let relative = 100.0 * error / summary.truth.map_or(1.0, |truth| truth.b);
            format!("{:+.3} %", (relative * 1e3).round() / 1e3 + 0.0)
        },
    );
    vec![
        name.to_owned(),
        cell(Parameter::A, 4),
        b,
        cell(Parameter::Coulomb, 2),
        cell(Parameter::Load, 2),
        format!(
            "{}, {}",
            settled(summary.settling_a, Parameter::A),
            settled(summary.settling_b, Parameter::B)
        ),
        summary.status().name().to_owned(),
    ]
}

/// Tail mean less truth; none where the method has no estimate.
fn error(summary: &Summary, parameter: Parameter) -> Option<f64> {
    let truth: &ServoParameters = summary.truth.as_ref()?;
    let estimate = summary.estimate(parameter)?;
    let error = estimate.tail_mean - parameter.of(truth);
    (summary.status() != Status::Aborted && error.is_finite()).then_some(error)
}

/// The comparison for a program.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct Document {
    pub cases: Vec<CaseDocument>,
}

/// One case.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct CaseDocument {
    pub case: &'static str,
    pub detail: String,
    pub methods: Vec<MethodDocument>,
}

/// What a method found in a case: errors against the truth, SI; null where it has none.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct MethodDocument {
    pub law: &'static str,
    pub status: &'static str,
    pub reason: String,
    pub error_a: Option<f64>,
    pub error_b: Option<f64>,
    pub error_coulomb: Option<f64>,
    pub error_load: Option<f64>,
    pub settling_a: Option<f64>,
    pub settling_b: Option<f64>,
    pub operations: Option<f64>,
}

impl Document {
    /// The document of a comparison.
    #[must_use]
    pub fn new(comparison: &Comparison) -> Self {
        let cases = comparison.cases.iter().map(|compared| CaseDocument {
            case: compared.case.name,
            detail: compared.case.detail.clone(),
            methods: comparison
                .methods
                .iter()
                .zip(&compared.results)
                .map(|(method, found)| {
                    let summary = match found {
                        MethodResult::Ran(summary) => Some(summary.as_ref()),
                        MethodResult::Refused(_) => None,
                    };
                    let error = |parameter| error(summary?, parameter);
                    MethodDocument {
                        law: method.name,
                        status: summary.map_or("refused", |summary| summary.status().name()),
                        reason: match found {
                            MethodResult::Ran(summary) => summary.reason.clone(),
                            MethodResult::Refused(why) => why.clone(),
                        },
                        error_a: error(Parameter::A),
                        error_b: error(Parameter::B),
                        error_coulomb: error(Parameter::Coulomb),
                        error_load: error(Parameter::Load),
                        settling_a: summary.and_then(|summary| summary.settling_a),
                        settling_b: summary.and_then(|summary| summary.settling_b),
                        operations: method.operations,
                    }
                })
                .collect(),
        });
        Self {
            cases: cases.collect(),
        }
    }
}

/// The relative error of a parameter per method (rows) and case (columns), as powers of ten; a
/// method without an estimate counts as off by a factor of ten.
#[must_use]
pub fn grid(comparison: &Comparison, parameter: Parameter) -> Vec<Vec<f64>> {
    const NONE: f64 = 1.0;
    const LEAST: f64 = 1e-5;
    let scale = |summary: &Summary| {
        summary.truth.map_or(1.0, |truth| match parameter {
            // The damping that the loop itself adds is what a stands beside.
            Parameter::A => 1.0,
            _ => parameter.of(&truth),
        })
    };
    (0..comparison.methods.len())
        .map(|row| {
            comparison
                .cases
                .iter()
                .map(|compared| match &compared.results[row] {
                    MethodResult::Ran(summary) => error(summary, parameter).map_or(NONE, |error| {
                        (error.abs() / scale(summary)).max(LEAST).log10().min(NONE)
                    }),
                    MethodResult::Refused(_) => NONE,
                })
                .collect()
        })
        .collect()
}
