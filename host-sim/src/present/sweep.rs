//! A sweep over random servos.

use super::number::{SIDES, figure, fixed, plain};
use super::{Block, Column, Envelope, Figure, Page, Section, Table, Tone, Verdict};
use crate::result::{Distribution, Spread, SweepResult};
use crate::scenario::Scenario;

/// The page of a sweep around a scenario.
#[must_use]
pub fn sweep(title: &str, command: &str, scenario: &Scenario, result: &SweepResult) -> Page {
    let distribution = &result.distribution;
    let figures = distribution.spreads.iter().map(shares).collect();
    let sections = [
        Section::brief("What was found", found(distribution)),
        Section::full("How it is distributed", vec![Block::Figures(figures)]),
        Section::full("How sure it is", how_sure(distribution)),
        Section::full("What it rests on", rests_on(scenario, result)),
        Section::full("What to do next", next(distribution)),
    ];
    Page::new(title, command, verdict(distribution), sections)
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
    let columns = vec![
        Column::words("quantity"),
        Column::figures("servos"),
        Column::figures("5 %").dispensable(2),
        Column::figures("25 %").dispensable(1),
        Column::figures("50 %").dispensable(0),
        Column::figures("75 %").dispensable(1),
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

fn rests_on(scenario: &Scenario, result: &SweepResult) -> Vec<Block> {
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
            format!("{}, from seed {}", result.distribution.runs, result.seed),
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
        ("Method", result.law.to_owned()),
    ];
    vec![Block::facts(facts)]
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
            "Where the motion contained too little information, a larger or livelier reference helps.".to_owned(),
        );
    }
    steps.push("More --runs show rarer cases; another --seed draws other servos.".to_owned());
    vec![Block::List(steps)]
}

/// The share of the servos that are no worse than a value.
fn shares(spread: &Spread) -> Figure {
    let share = |place: usize| 100.0 * (place + 1) as f64 / spread.sorted.len() as f64;
    let values = spread.sorted.iter().enumerate();
    let points = values.filter(|(_, value)| **value > 0.0);
    let trace = points
        .map(|(place, &value)| (value, share(place)))
        .collect::<Envelope>()
        .trace("share");
    let mut figure = Figure::new(
        spread.name,
        &format!("{} [{}]", spread.name, spread.unit),
        &format!("share of {} servos that are no worse [%]", spread.count),
        vec![trace],
    );
    figure.horizontal.is_logarithmic = true;
    figure.within(Some([0.0, 100.0]))
}
