//! The pictures of a comparison.

use host_sim::result::{ComparisonResult, MethodErrors};
use identifier_log::verdict::Status;

use crate::present::number::{DASH, power_of_ten};
use crate::present::{HeatCell, HeatMap, HeatMaps, Tint};

/// A parameter's error as a map.
struct Shown {
    title: &'static str,
    error: fn(&MethodErrors) -> Option<f64>,
    /// Powers of ten between which it is coloured.
    decades: (f64, f64),
}

const SHOWN: [Shown; 4] = [
    Shown {
        title: "|â − a| [1/s]",
        error: |found| found.error_a,
        decades: (-4.0, 0.0),
    },
    Shown {
        title: "|b̂/b − 1| [%]",
        error: |found| Some(100.0 * found.error_b? / found.true_b),
        decades: (-3.0, 1.0),
    },
    Shown {
        title: "|ĉ − c| [rad/s²]",
        error: |found| found.error_coulomb,
        decades: (-3.0, 1.0),
    },
    Shown {
        title: "|d̂ − d| [rad/s²]",
        error: |found| found.error_load,
        decades: (-3.0, 1.0),
    },
];

/// The errors and the status of every method (rows) in every case (columns).
#[must_use]
pub fn heat_maps(result: &ComparisonResult) -> HeatMaps {
    let map = |title: &str, cell: &dyn Fn(&MethodErrors) -> HeatCell| HeatMap {
        title: title.to_owned(),
        cells: (0..result.methods.len())
            .map(|row| {
                let cases = result.cases.iter();
                cases.map(|case| cell(&case.methods[row])).collect()
            })
            .collect(),
    };
    let errors = SHOWN.iter();
    let errors = errors.map(|shown| map(shown.title, &|found| shown.cell(found)));
    HeatMaps {
        rows: result
            .methods
            .iter()
            .map(|method| method.name.to_owned())
            .collect(),
        columns: result
            .cases
            .iter()
            .map(|case| case.case.to_owned())
            .collect(),
        maps: errors.chain([map("status", &status_cell)]).collect(),
        key: key(result),
    }
}

impl Shown {
    fn cell(&self, found: &MethodErrors) -> HeatCell {
        let (low, high) = self.decades;
        let (text, tint) = match (self.error)(found).map(f64::abs) {
            Some(error) => (
                short(error),
                Tint::Graded((error.log10() - low) / (high - low)),
            ),
            None => (DASH.to_owned(), Tint::Bare),
        };
        HeatCell { text, tint }
    }
}

fn status_cell(found: &MethodErrors) -> HeatCell {
    STATUSES
        .iter()
        .find(|(status, ..)| *status == found.status)
        .map_or_else(
            || cell(DASH, Tint::Bare),
            |(_, letter, tint, _)| cell(letter, *tint),
        )
}

fn cell(text: &str, tint: Tint) -> HeatCell {
    let text = text.to_owned();
    HeatCell { text, tint }
}

/// Letter, colour and meaning of each status. The last is for a case that a method rejected.
const STATUSES: [(Option<Status>, &str, Tint, &str); 7] = [
    (Some(Status::Converged), "C", Tint::Good, "converged"),
    (
        Some(Status::Partial),
        "P",
        Tint::Doubtful,
        "b within tolerance",
    ),
    (
        Some(Status::Unexplained),
        "U",
        Tint::Doubtful,
        "unexplained",
    ),
    (
        Some(Status::NoInformation),
        "N",
        Tint::Doubtful,
        "no information",
    ),
    (Some(Status::Moving), "M", Tint::Doubtful, "moving"),
    (Some(Status::Aborted), "A", Tint::Bare, "aborted"),
    (None, "R", Tint::Bare, "refused"),
];

/// Meaning of the letters that occur.
fn key(result: &ComparisonResult) -> Vec<(HeatCell, &'static str)> {
    let all = || result.cases.iter().flat_map(|case| &case.methods);
    let statuses = STATUSES
        .iter()
        .filter(|(status, ..)| all().any(|found| found.status == *status));
    let statuses = statuses.map(|(_, letter, tint, meaning)| (cell(letter, *tint), *meaning));
    let has_gaps = SHOWN
        .iter()
        .any(|shown| all().any(|found| (shown.error)(found).is_none()));
    let gap = has_gaps.then(|| (cell(DASH, Tint::Bare), "no estimate"));
    statuses.chain(gap).collect()
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
