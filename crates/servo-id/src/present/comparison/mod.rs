//! A comparison of methods.

mod heat_maps;

pub use heat_maps::heat_maps;

use host_sim::result::{CaseResult, ComparisonResult, MethodErrors};
use identifier_log::verdict::Status;

use super::estimates::{dash, settled};
use super::number::{figure, fixed, per_cent, signed};
use super::{Block, Column, Page, Section, Table, Tone, Verdict};

/// The page of a comparison.
#[must_use]
pub fn comparison(title: &str, command: &str, result: &ComparisonResult, duration: f64) -> Page {
    let ranked = ranked(result);
    let most = ranked.first().map_or(0, |best| best.converged);
    let best: Vec<&str> = ranked
        .iter()
        .filter(|standing| standing.converged == most)
        .map(|standing| standing.name)
        .collect();
    let cases = result.cases.len();
    let sections = [
        Section::full("Result", vec![Block::Table(standings(&ranked, cases))]),
        Section::full("Every method in every case", every(result)),
        Section::brief("The methods", vec![Block::Table(methods(result))]),
        Section::brief("The cases", each_case(result, duration)),
        Section::full("Uncertainty", vec![how_sure()]),
        Section::full("Next steps", next()),
    ];
    let verdict = Verdict {
        tone: Tone::Good,
        status: format!("{} methods, {cases} cases", ranked.len()),
        headline: if most == cases {
            format!("Converged in every case: {}.", best.join(", "))
        } else {
            format!(
                "Converged in {most} of {cases} cases, the most: {}.",
                best.join(", ")
            )
        },
        detail: "All methods have the same servo and the same verdict.".to_owned(),
    };
    Page::new(title, command, verdict, sections)
}

/// Performance of a method over all cases.
#[derive(Debug)]
struct Standing<'a> {
    name: &'a str,
    converged: usize,
    /// Largest relative error of b, and error of a, 1/s, over the cases that it has an estimate in.
    worst_b: f64,
    worst_a: f64,
    /// Cases without an estimate.
    without: usize,
    operations: Option<f64>,
}

/// The methods, the best first.
fn ranked(result: &ComparisonResult) -> Vec<Standing<'_>> {
    let mut ranked: Vec<Standing<'_>> = result
        .methods
        .iter()
        .enumerate()
        .map(|(place, method)| {
            let found = || cells(result, place);
            let worst = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
            Standing {
                name: method.name,
                converged: found()
                    .filter(|found| found.status == Some(Status::Converged))
                    .count(),
                worst_b: worst(&mut found().filter_map(|of| Some(of.error_b?.abs() / of.true_b))),
                worst_a: worst(&mut found().filter_map(|of| Some(of.error_a?.abs()))),
                without: found().filter(|of| of.error_b.is_none()).count(),
                operations: method.operations,
            }
        })
        .collect();
    ranked.sort_by(|one, other| {
        let by_count = other.converged.cmp(&one.converged);
        let by_lack = one.without.cmp(&other.without);
        by_count
            .then(by_lack)
            .then(one.worst_b.total_cmp(&other.worst_b))
    });
    ranked
}

/// The errors of a method in each case.
fn cells(result: &ComparisonResult, method: usize) -> impl Iterator<Item = &MethodErrors> {
    let cases = result.cases.iter();
    cases.filter_map(move |case| case.methods.get(method))
}

fn standings(ranked: &[Standing<'_>], cases: usize) -> Table {
    let rows = ranked.iter().map(|standing| {
        let unless_none = |text: String| match standing.without == cases {
            true => dash(),
            false => text,
        };
        vec![
            standing.name.to_owned(),
            format!("{} of {cases}", standing.converged),
            unless_none(per_cent(standing.worst_b)),
            unless_none(figure(standing.worst_a)),
            standing.without.to_string(),
            standing.operations.map_or_else(dash, |mean| fixed(mean, 0)),
        ]
    });
    Table::new(
        "The methods, the one that converged most often first",
        vec![
            Column::words("method"),
            Column::figures("converged"),
            Column::figures("largest error of b"),
            Column::figures("of a [1/s]"),
            Column::figures("cases without estimate"),
            Column::figures("operations per sample"),
        ],
        rows.collect(),
    )
}

fn every(result: &ComparisonResult) -> Vec<Block> {
    let of_b = |found: &MethodErrors| {
        let error = found.error_b? / found.true_b;
        Some((format!("{}\u{a0}%", signed(100.0 * error, 3)), error.abs()))
    };
    let of_a = |found: &MethodErrors| {
        let error = found.error_a?;
        Some((signed(error, 4), error.abs()))
    };
    vec![
        Block::text(
            "Errors against the true values, over the last quarter of the run. The redder a cell, the larger the \
             error, one shade per power of ten. A status is shown where it is not “converged”.",
        ),
        Block::Table(grid("Relative error of b", result, &of_b)),
        Block::Table(grid("Error of a [1/s]", result, &of_a)),
    ]
}

/// The text of a cell, and the size of its error.
type Told<'a> = dyn Fn(&MethodErrors) -> Option<(String, f64)> + 'a;

fn grid(caption: &str, result: &ComparisonResult, told: &Told<'_>) -> Table {
    /// The size of an error that is worth a shade.
    const MIN_ERROR: f64 = 1e-4;
    let columns = result.cases.iter().map(|case| Column::figures(case.case));
    let mut table = Table::new(
        caption,
        std::iter::once(Column::words("method"))
            .chain(columns)
            .collect(),
        Vec::new(),
    );
    for (place, method) in result.methods.iter().enumerate() {
        let mut row = vec![method.name.to_owned()];
        let mut levels = vec![0];
        for found in cells(result, place) {
            let told = told(found);
            let size = told.as_ref().map_or(f64::INFINITY, |(_, size)| *size);
            let text = match (told, found.status_name()) {
                (Some((text, _)), "converged") => text,
                (Some((text, _)), status) => format!("{text} {status}"),
                (None, status) => status.to_owned(),
            };
            let level = (size / MIN_ERROR).max(1.0).log10().ceil();
            row.push(text);
            levels.push(level.min(f64::from(Table::WORST)) as u8);
        }
        table.rows.push(row);
        table.levels.push(levels);
    }
    table
}

fn how_sure() -> Block {
    Block::text(
        "Each cell is one run of one servo with one seed, so a factor of two between methods may be chance. A sweep \
         shows a method on many servos. No method was adjusted by hand for a case.",
    )
}

fn methods(result: &ComparisonResult) -> Table {
    let rows = result.methods.iter().map(|method| {
        vec![
            method.name.to_owned(),
            method.source.to_owned(),
            method.closing.to_owned(),
            method.prior.to_owned(),
            method.operations.map_or_else(dash, |mean| fixed(mean, 0)),
        ]
    });
    let columns = vec![
        Column::words("method"),
        Column::words("from").drop_order(0),
        Column::words("loop").drop_order(1),
        Column::words("known beforehand").drop_order(2),
        Column::figures("operations per sample"),
    ];
    Table::new("", columns, rows.collect())
}

fn each_case(result: &ComparisonResult, duration: f64) -> Vec<Block> {
    let mut blocks = Vec::new();
    blocks.extend(result.assumed_range.map(|within| {
        let [[a_min, a_max], [b_min, b_max]] = [within.a, within.b].map(|ends| ends.map(figure));
        Block::Text(format!(
            "The scenario states no plant_box. Methods that need a parameter range get a from {a_min} to {a_max} 1/s \
             and b from {b_min}, their initial value, to {b_max} rad/s² per command unit."
        ))
    }));
    for case in &result.cases {
        blocks.push(Block::Table(errors(case)));
        let refused = case.methods.iter().filter(|found| found.status.is_none());
        blocks.extend(refused.map(|of| Block::Text(format!("{}: {}", of.law, of.reason))));
    }
    blocks.push(Block::Text(format!(
        "Errors: mean over the last quarter of {duration} s minus the true value. Settled: time from which on â \
         stays within ±0.1 1/s and b̂ within 2 %.\nOperations: additions, multiplications and comparisons of the \
         estimator only, in single precision with compensated sums."
    )));
    blocks
}

/// The errors of every method in one case.
fn errors(case: &CaseResult) -> Table {
    let columns = vec![
        Column::words("method"),
        Column::figures("â − a [1/s]"),
        Column::figures("b̂/b − 1"),
        Column::figures("ĉ − c [rad/s²]").drop_order(0),
        Column::figures("d̂ − d [rad/s²]").drop_order(1),
        Column::figures("settled a, b [s]").drop_order(2),
        Column::words("status"),
    ];
    let error = |error: Option<f64>, places| error.map_or_else(dash, |error| signed(error, places));
    let rows = case.methods.iter().map(|of| {
        let settling = |time: Option<f64>, error: Option<f64>| match error {
            Some(_) => settled(time),
            None => dash(),
        };
        let b = of
            .error_b
            .map(|error| signed(100.0 * error / of.true_b, 3) + " %");
        vec![
            of.law.to_owned(),
            error(of.error_a, 4),
            b.unwrap_or_else(dash),
            error(of.error_coulomb, 2),
            error(of.error_load, 2),
            match of.status {
                None => dash(),
                Some(_) => format!(
                    "{}, {}",
                    settling(of.settling_a, of.error_a),
                    settling(of.settling_b, of.error_b)
                ),
            },
            of.status_name().to_owned(),
        ]
    });
    let caption = format!("{}: {}", case.case, case.detail);
    Table::new(&caption, columns, rows.collect())
}

fn next() -> Vec<Block> {
    vec![Block::List(vec![
        "Find the case closest to your servo, and choose a method that converged there: identifier.law.".to_owned(),
        "Note what must be known beforehand, and on a chip the operations per sample.".to_owned(),
    ])]
}
