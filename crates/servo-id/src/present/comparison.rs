//! A comparison of methods.

use host_sim::result::{CaseResult, ComparisonResult};
use identifier_log::verdict::Status;

use super::estimates::{dash, settled};
use super::number::{figure, signed};
use super::{Block, Column, Page, Section, Table, Tone, Verdict};

/// The page of a comparison.
#[must_use]
pub fn comparison(title: &str, command: &str, result: &ComparisonResult, duration: f64) -> Page {
    let converged: Vec<usize> = (0..result.methods.len())
        .map(|place| converged(result, place))
        .collect();
    let most = converged.iter().copied().max().unwrap_or(0);
    let best = result.methods.iter().zip(&converged);
    let best = best.filter(|(_, count)| **count == most);
    let best: Vec<&str> = best.map(|(method, _)| method.name).collect();
    let best = best.join(", ");
    let cases = result.cases.len();
    let sections = [
        Section::brief(
            "The methods",
            vec![Block::Table(methods(result, &converged))],
        ),
        Section::brief("The cases", each_case(result, duration)),
    ];
    let verdict = Verdict {
        tone: Tone::Good,
        status: format!("{} methods, {cases} cases", result.methods.len()),
        headline: if most == cases {
            format!("Converged in every case: {best}.")
        } else {
            format!("Converged in {most} of {cases} cases, the most: {best}.")
        },
        detail: "All methods have the same servo and the same verdict.".to_owned(),
    };
    Page::new(title, command, verdict, sections)
}

/// Number of cases in which the method at a place converged.
fn converged(result: &ComparisonResult, place: usize) -> usize {
    let cases = result.cases.iter();
    let found = cases.filter_map(|case| case.methods.get(place));
    found
        .filter(|found| found.status == Some(Status::Converged))
        .count()
}

fn methods(result: &ComparisonResult, converged: &[usize]) -> Table {
    let rows = result
        .methods
        .iter()
        .zip(converged)
        .map(|(method, converged)| {
            vec![
                method.name.to_owned(),
                method.source.to_owned(),
                method.closing.to_owned(),
                method.prior.to_owned(),
                format!("{converged} of {}", result.cases.len()),
            ]
        });
    let columns = vec![
        Column::words("method"),
        Column::words("from").drop_order(0),
        Column::words("loop").drop_order(1),
        Column::words("known beforehand").drop_order(2),
        Column::figures("converged"),
    ];
    Table::new("", columns, rows.collect())
}

fn each_case(result: &ComparisonResult, duration: f64) -> Vec<Block> {
    let mut blocks = Vec::new();
    blocks.extend(result.assumed_range.map(|within| {
        let [[a_min, a_max], [b_min, b_max]] = [within.a, within.b].map(|ends| ends.map(figure));
        Block::Text(format!(
            "The scenario states no servo_range. Methods that need a parameter range get a from {a_min} to {a_max} 1/s \
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
         stays within ±0.1 1/s and b̂ within 2 %."
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
