//! A sweep over random servos.

use host_sim::result::{Distribution, SweepResult};

use super::number::{figure, fixed};
use super::{Block, Column, Page, Section, Table, Tone, Verdict};

/// The page of a sweep around a scenario.
#[must_use]
pub fn sweep(title: &str, command: &str, result: &SweepResult) -> Page {
    let distribution = &result.distribution;
    let sections = [Section::brief("Result", found(distribution))];
    Page::new(title, command, verdict(distribution), sections)
}

fn verdict(distribution: &Distribution) -> Verdict {
    /// The part that must have converged for an estimator to be reliable.
    const RELIABLE: f64 = 0.95;
    let share = distribution.converged as f64 / distribution.runs as f64;
    let within: Vec<String> = distribution
        .spreads
        .iter()
        .take(2)
        .map(|spread| {
            let q95 = figure(spread.quantiles.q95);
            format!("{} at most {q95} {}", spread.name, spread.unit)
        })
        .collect();
    Verdict {
        tone: if share >= RELIABLE {
            Tone::Good
        } else {
            Tone::Doubtful
        },
        status: format!(
            "{} of {} converged",
            distribution.converged, distribution.runs
        ),
        headline: format!(
            "{1} of {0} random servos converged.",
            distribution.runs, distribution.converged
        ),
        detail: if within.is_empty() {
            "None has an estimate.".to_owned()
        } else {
            format!("In 95 % of the servos: {}.", within.join(", "))
        },
    }
}

fn found(distribution: &Distribution) -> Vec<Block> {
    let columns = vec![
        Column::words("quantity"),
        Column::figures("servos"),
        Column::figures("5 %").drop_order(2),
        Column::figures("25 %").drop_order(1),
        Column::figures("50 %").drop_order(0),
        Column::figures("75 %").drop_order(1),
        Column::figures("95 %"),
        Column::figures("largest"),
    ];
    let rows = distribution.spreads.iter().map(|spread| {
        let mut row = vec![
            format!("{} [{}]", spread.name, spread.unit),
            spread.count.to_string(),
        ];
        row.extend(spread.quantiles.named().map(|(_, value)| figure(value)));
        row
    });
    let statuses = [
        ("converged", distribution.converged),
        ("partial", distribution.partial),
        ("unexplained", distribution.unexplained),
        ("no-information", distribution.no_information),
        ("moving", distribution.moving),
        ("aborted", distribution.aborted),
    ];
    let statuses = statuses.map(|(name, count)| {
        let share = 100.0 * count as f64 / distribution.runs as f64;
        vec![name.to_owned(), count.to_string(), fixed(share, 2)]
    });
    vec![
        Block::Table(Table::new(
            "Largest value in the best 5, 25, 50, 75, 95 and 100 % of the servos",
            columns,
            rows.collect(),
        )),
        Block::Table(Table::new(
            "Ends of the runs",
            Column::all(&["status"], &["servos", "share [%]"], &[]),
            statuses.into(),
        )),
    ]
}
