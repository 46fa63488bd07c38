//! The picture of a comparison.

use identifier_core::parameters::Parameter;

use crate::analysis::Status;
use crate::compare::{Comparison, MethodResult};
use crate::present::{HeatCell, HeatMap, HeatMaps, Tint};
use crate::render::chart::power_of_ten;
use crate::result::error;

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
