//! The page of a sweep.

use super::{Block, Column, Page, Section, Table, Tone, Verdict};
use crate::present::number::{SIDES, figure, fixed, plain};
use crate::report::distribution;
use crate::scenario::Scenario;
use crate::sweep::Distribution;

/// What there is to be said of a sweep.
#[derive(Debug, Clone, Copy)]
pub struct Swept<'a> {
    /// What was done, to what.
    pub title: &'a str,
    /// The call.
    pub command: &'a str,
    /// The scenario that servos were drawn for.
    pub scenario: &'a Scenario,
    /// What they were drawn from.
    pub seed: u32,
    /// How it came out.
    pub distribution: &'a Distribution,
}

/// The page of a sweep.
#[must_use]
pub fn sweep(of: &Swept<'_>) -> Page {
    let figures = distribution::figures(of.distribution);
    let sections = [
        Section::full("What was found", found(of.distribution)),
        Section::full("How it is distributed", vec![Block::Figures(figures)]),
        Section::full("How sure it is", how_sure(of.distribution)),
        Section::full("What it rests on", rests_on(of)),
        Section::full("What to do next", next(of.distribution)),
    ];
    Page::new(of.title, of.command, verdict(of.distribution), sections)
}

fn verdict(distribution: &Distribution) -> Verdict {
    /// The part that must have converged for a law to be relied on.
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
            "Of {} random servos {} converged.",
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
    let columns = ["5 %", "25 %", "50 %", "75 %", "95 %", "largest"];
    let columns = [Column::words("quantity"), Column::figures("servos")]
        .into_iter()
        .chain(columns.map(Column::figures));
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
            "No more than this in so many of the servos",
            columns.collect(),
            rows.collect(),
        )),
        Block::Table(Table::new(
            "How the runs ended",
            vec![
                Column::words("status"),
                Column::figures("servos"),
                Column::figures("share [%]"),
            ],
            statuses.into(),
        )),
    ]
}

fn how_sure(distribution: &Distribution) -> Vec<Block> {
    let runs = distribution.runs as f64;
    let chance = |share: f64| 100.0 * SIDES * (share * (1.0 - share) / runs).sqrt();
    vec![Block::Text(format!(
        "Errors are against the truth, which a simulation knows. With {} servos chance leaves a share of 50 % unsure \
         by ± {} points and one of 95 % by ± {} (two standard errors).",
        distribution.runs,
        fixed(chance(0.5), 1),
        fixed(chance(0.95), 1)
    ))]
}

fn rests_on(of: &Swept<'_>) -> Vec<Block> {
    let scenario = of.scenario;
    let drawn = match scenario.stated.identifier.plant_box {
        Some(within) => format!(
            "a from {} to {} 1/s, b from {} to {} rad/s² per command unit, the plant_box",
            plain(within.a[0]),
            plain(within.a[1]),
            plain(within.b[0]),
            plain(within.b[1])
        ),
        None => "a and b within a factor of three of the scenario's servo".to_owned(),
    };
    let facts = [
        (
            "Servos",
            format!("{}, from seed {}", of.distribution.runs, of.seed),
        ),
        ("Drawn", drawn),
        (
            "Each run",
            format!(
                "{} s at {} Hz",
                plain(scenario.duration),
                plain(1.0 / scenario.sample_time())
            ),
        ),
        ("Method", scenario.identifier.law.name().to_owned()),
    ];
    vec![Block::Facts(
        facts.map(|(name, text)| (name.to_owned(), text)).into(),
    )]
}

fn next(distribution: &Distribution) -> Vec<Block> {
    let mut steps = Vec::new();
    if distribution.converged < distribution.runs {
        steps.push(
            "Look at those that did not converge: --csv writes every servo with its status, and one servo is run alone \
             with its a, b, load and coulomb as [plant]."
                .to_owned(),
        );
    }
    if distribution.moving > 0 {
        steps.push("Where estimates still moved, a longer run.duration helps.".to_owned());
    }
    if distribution.no_information > 0 {
        steps.push(
            "Where the motion said too little, a larger or livelier reference helps.".to_owned(),
        );
    }
    steps.push("More --runs tell rare cases; another --seed draws other servos.".to_owned());
    vec![Block::List(steps)]
}
