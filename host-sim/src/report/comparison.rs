//! A comparison as tables, as JSON and as a picture.

use identifier_core::parameters::{Parameter, ServoParameters};
use serde::Serialize;

use crate::analysis::Status;
use crate::compare::{Compared, Comparison, MethodResult};
use crate::present::{HeatCell, HeatMap, HeatMaps, Tint};
use crate::render::chart::power_of_ten;
use crate::render::terminal::table::Rows;
use crate::result::Summary;

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
            settled(summary.settling_time.a, Parameter::A),
            settled(summary.settling_time.b, Parameter::B)
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
                        settling_a: summary.and_then(|summary| summary.settling_time.a),
                        settling_b: summary.and_then(|summary| summary.settling_time.b),
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

/// What is shown of a parameter's error: its name and unit, what it is taken times, and the powers of ten
/// between which it is coloured.
struct Shown {
    parameter: Parameter,
    title: &'static str,
    per_truth: Option<f64>,
    decades: (f64, f64),
}

const SHOWN: [Shown; 4] = [
    Shown {
        parameter: Parameter::A,
        title: "|â − a| [1/s]",
        per_truth: None,
        decades: (-4.0, 0.0),
    },
    Shown {
        parameter: Parameter::B,
        title: "|b̂/b − 1| [%]",
        per_truth: Some(100.0),
        decades: (-3.0, 1.0),
    },
    Shown {
        parameter: Parameter::Coulomb,
        title: "|ĉ − c| [rad/s²]",
        per_truth: None,
        decades: (-3.0, 1.0),
    },
    Shown {
        parameter: Parameter::Load,
        title: "|d̂ − d| [rad/s²]",
        per_truth: None,
        decades: (-3.0, 1.0),
    },
];

/// The errors and the status of every method (rows) in every case (columns).
#[must_use]
pub fn heat_maps(comparison: &Comparison) -> HeatMaps {
    let map = |title: &str, cell: &dyn Fn(&MethodResult) -> HeatCell| HeatMap {
        title: title.to_owned(),
        cells: (0..comparison.methods.len())
            .map(|row| {
                let cases = comparison.cases.iter();
                cases.map(|case| cell(&case.results[row])).collect()
            })
            .collect(),
    };
    let mut maps: Vec<HeatMap> = SHOWN
        .iter()
        .map(|shown| map(shown.title, &|found| shown.cell(found)))
        .collect();
    maps.push(map("status", &status_cell));
    HeatMaps {
        rows: comparison.methods.iter().map(|method| method.name.to_owned()).collect(),
        columns: comparison.cases.iter().map(|case| case.case.name.to_owned()).collect(),
        maps,
        key: "C converged; U unexplained; N no information; M moving; A aborted; R refused; – no estimate"
            .to_owned(),
    }
}

const NO_ESTIMATE: &str = "–";

impl Shown {
    fn cell(&self, found: &MethodResult) -> HeatCell {
        let error = match found {
            MethodResult::Ran(summary) => error(summary, self.parameter).and_then(|error| {
                let truth = summary.truth.map(|truth| self.parameter.of(&truth))?;
                Some(error.abs() * self.per_truth.map_or(1.0, |times| times / truth.abs()))
            }),
            MethodResult::Refused(_) => None,
        };
        let (least, most) = self.decades;
        match error {
            Some(error) => HeatCell {
                text: short(error),
                tint: Tint::Graded((error.log10() - least) / (most - least)),
            },
            None => HeatCell {
                text: NO_ESTIMATE.to_owned(),
                tint: Tint::Bare,
            },
        }
    }
}

fn status_cell(found: &MethodResult) -> HeatCell {
    let (letter, tint) = match found {
        MethodResult::Ran(summary) => match summary.status() {
            Status::Converged => ("C", Tint::Good),
            Status::Unexplained => ("U", Tint::Doubtful),
            Status::NoInformation => ("N", Tint::Doubtful),
            Status::Moving => ("M", Tint::Doubtful),
            Status::Aborted => ("A", Tint::Bare),
        },
        MethodResult::Refused(_) => ("R", Tint::Bare),
    };
    HeatCell {
        text: letter.to_owned(),
        tint,
    }
}

/// Two digits, or a power of ten.
fn short(error: f64) -> String {
    let power = error.log10();
    if !power.is_finite() {
        return "0".to_owned();
    }
    match power.floor() as i32 {
        1..=3 => format!("{error:.0}"),
        0 => format!("{error:.1}"),
        -1 => format!("{error:.2}"),
        -2 => format!("{error:.3}"),
        _ => power_of_ten(power.round() as i32),
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn errors_are_written_with_two_digits_or_as_powers_of_ten() {
        let written = [
            (123.4, "123"),
            (0.02134, "0.021"),
            (3e-4, "10⁻⁴"),
            (0.0, "0"),
        ];
        for (error, text) in [(4e-4, "10⁻³")].into_iter().chain(written) {
            assert_eq!(short(error), text, "{error}");
        }
    }
}
