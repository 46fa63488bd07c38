//! A sweep over random servos.

use host_sim::result::{Distribution, Spread, SweepResult};
use host_sim::scenario::Scenario;

use super::number::{figure, fixed, plain};
use super::{Block, Column, Envelope, Figure, Page, Section, Table, Tone, Verdict};
use crate::SIDES;

/// The page of a sweep around a scenario.
#[must_use]
pub fn sweep(title: &str, command: &str, scenario: &Scenario, result: &SweepResult) -> Page {
    let distribution = &result.distribution;
    let figures = distribution.spreads.iter().map(shares).collect();
    let sections = [
        Section::brief("Result", found(distribution)),
        Section::full("How it is distributed", vec![Block::Figures(figures)]),
        Section::full("Uncertainty", how_sure(distribution)),
        Section::full("Data and method", rests_on(scenario, result)),
        Section::full("Next steps", next(distribution)),
    ];
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
        "Errors are against the true values of the simulation. With {} servos a share of 50 % is uncertain by ± {} \
         points, and one of 95 % by ± {} (two standard errors).",
        distribution.runs,
        fixed(chance(0.5), 1),
        fixed(chance(0.95), 1)
    ))]
}

fn rests_on(scenario: &Scenario, result: &SweepResult) -> Vec<Block> {
    let drawn = match scenario.stated.identifier.parameter_range {
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
            "Look at those that did not converge: --csv writes every servo with its status. To run one servo, state \
             its a, b, load and coulomb in [plant]."
                .to_owned(),
        );
    }
    if distribution.moving > 0 {
        steps.push("If estimates had not settled, a longer run.duration helps.".to_owned());
    }
    if distribution.no_information > 0 {
        steps.push(
            "If the motion contained too little information, use a larger reference or one that changes more often.".to_owned(),
        );
    }
    steps.push("More --runs show rarer cases; another --seed draws other servos.".to_owned());
    vec![Block::List(steps)]
}

/// The share of the servos that are no worse than a value. It is zero below the smallest value and one above the
/// largest.
fn shares(spread: &Spread) -> Figure {
    /// Factor by which the axis reaches beyond the values.
    const ROOM: f64 = 1.25;
    let count = spread.sorted.len();
    let share = |place: usize| 100.0 * place as f64 / count as f64;
    // An error of exactly zero has no place on a logarithmic axis: it counts from the beginning.
    let zeros = spread.sorted.partition_point(|value| *value <= 0.0);
    let (first, last) = match &spread.sorted[zeros..] {
        [first, .., last] => (*first, *last),
        [only] => (*only, *only),
        [] => (1.0, 1.0),
    };
    let steps = spread.sorted.iter().enumerate().skip(zeros);
    let steps =
        steps.flat_map(|(place, &value)| [(value, share(place)), (value, share(place + 1))]);
    let begin = [(first / ROOM, share(zeros))].into_iter();
    let points = begin.chain(steps).chain([(last * ROOM, share(count))]);
    let trace = points.collect::<Envelope>().trace("share");
    let mut figure = Figure::new(
        spread.name,
        &format!("{} [{}]", spread.name, spread.unit),
        &format!(
            "share of {} servos with at most this error [%]",
            spread.count
        ),
        vec![trace],
    );
    figure.horizontal.is_logarithmic = true;
    figure.within(Some([0.0, 100.0]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use host_sim::result::Quantiles;

    #[test]
    fn shares_of_equal_values_are_a_step_inside_the_axis() {
        for (sorted, ends) in [
            (vec![0.5, 0.5, 0.5], (0.4, 0.625)),
            (vec![0.0, 0.5], (0.4, 0.625)),
            (vec![0.0, 0.0], (0.8, 1.25)),
        ] {
            let spread = Spread {
                name: "",
                unit: "s",
                count: sorted.len(),
                quantiles: Quantiles {
                    q05: 0.0,
                    q25: 0.0,
                    q50: 0.0,
                    q75: 0.0,
                    q95: 0.0,
                    max: 0.0,
                },
                sorted,
            };
            let figure = shares(&spread);
            let (first, last) = figure.extent();
            assert!((first - ends.0).abs() < 1e-12 && (last - ends.1).abs() < 1e-12);
            let points = &figure.traces[0].points;
            let at_ends = [points.first(), points.last()].map(|point| point.map(|point| point.1));
            let zeros = spread.sorted.iter().filter(|value| **value <= 0.0).count();
            let begin = 100.0 * zeros as f64 / spread.sorted.len() as f64;
            assert_eq!(at_ends, [Some(begin), Some(100.0)]);
        }
    }
}
