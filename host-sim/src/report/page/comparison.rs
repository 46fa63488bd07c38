//! The page of a comparison.

use super::{Block, Column, Page, Section, Table, Tone, Verdict};
use crate::compare::Comparison;
use crate::present::number::{figure, fixed, per_cent, signed};
use crate::report::comparison::{Document, MethodDocument};

/// The page of a comparison; `document` is the same for a program.
#[must_use]
pub fn comparison(title: &str, command: &str, of: &Comparison, document: &Document) -> Page {
    let ranked = ranked(of, document);
    let most = ranked.first().map_or(0, |best| best.converged);
    let best: Vec<&str> = ranked
        .iter()
        .filter(|standing| standing.converged == most)
        .map(|standing| standing.name)
        .collect();
    let cases = document.cases.len();
    let sections = [
        Section::full(
            "What was found",
            vec![Block::Table(standings(&ranked, cases))],
        ),
        Section::full("Every method in every case", every(of, document)),
        Section::full("How sure it is", vec![how_sure()]),
        Section::full("What it rests on", rests_on(of)),
        Section::full("What to do next", next()),
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
        detail: "All listen to, or control, the same servo, and are judged by the same verdict."
            .to_owned(),
    };
    Page::new(title, command, verdict, sections)
}

/// How a method did over all cases.
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
fn ranked<'a>(of: &'a Comparison, document: &Document) -> Vec<Standing<'a>> {
    let mut ranked: Vec<Standing<'_>> = of
        .methods
        .iter()
        .enumerate()
        .map(|(place, method)| {
            let found = || cells(of, document, place);
            let worst = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
            Standing {
                name: method.name,
                converged: found().filter(|(of, _)| of.status == "converged").count(),
                worst_b: worst(&mut found().filter_map(|(of, b)| Some(of.error_b?.abs() / b))),
                worst_a: worst(&mut found().filter_map(|(of, _)| Some(of.error_a?.abs()))),
                without: found().filter(|(of, _)| of.error_b.is_none()).count(),
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

/// What a method found in each case, with the true b of the case.
fn cells<'a>(
    of: &'a Comparison,
    document: &'a Document,
    method: usize,
) -> impl Iterator<Item = (&'a MethodDocument, f64)> {
    let cases = document.cases.iter().zip(&of.cases);
    cases.filter_map(move |(told, compared)| {
        let servo = compared.case.scenario.plant?;
        Some((told.methods.get(method)?, servo.b))
    })
}

fn standings(ranked: &[Standing<'_>], cases: usize) -> Table {
    let rows = ranked.iter().map(|standing| {
        let unless_none = |text: String| {
            if standing.without == cases {
                "–".to_owned()
            } else {
                text
            }
        };
        vec![
            standing.name.to_owned(),
            format!("{} of {cases}", standing.converged),
            unless_none(per_cent(standing.worst_b)),
            unless_none(figure(standing.worst_a)),
            standing.without.to_string(),
            standing
                .operations
                .map_or_else(|| "–".to_owned(), |mean| fixed(mean, 0)),
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
            Column::figures("operations a sample"),
        ],
        rows.collect(),
    )
}

fn every(of: &Comparison, document: &Document) -> Vec<Block> {
    let of_b = |found: &MethodDocument, b: f64| {
        let error = found.error_b? / b;
        Some((format!("{}\u{a0}%", signed(100.0 * error, 3)), error.abs()))
    };
    let of_a = |found: &MethodDocument, _: f64| {
        let error = found.error_a?;
        Some((signed(error, 4), error.abs()))
    };
    vec![
        Block::Text(
            "Errors against the truth, over the last quarter of the run. The redder a cell, the larger the error, a \
             shade for each power of ten; a status stands where it is not “converged”."
                .to_owned(),
        ),
        Block::Table(grid("Relative error of b", of, document, &of_b)),
        Block::Table(grid("Error of a [1/s]", of, document, &of_a)),
    ]
}

/// What a cell says of an error, and its size.
type Told<'a> = dyn Fn(&MethodDocument, f64) -> Option<(String, f64)> + 'a;

fn grid(caption: &str, of: &Comparison, document: &Document, told: &Told<'_>) -> Table {
    /// The size of an error that is worth a shade.
    const LEAST: f64 = 1e-4;
    let columns = document.cases.iter().map(|case| Column::figures(case.case));
    let mut table = Table::new(
        caption,
        std::iter::once(Column::words("method"))
            .chain(columns)
            .collect(),
        Vec::new(),
    );
    for (place, method) in of.methods.iter().enumerate() {
        let mut row = vec![method.name.to_owned()];
        let mut levels = vec![0];
        for (found, b) in cells(of, document, place) {
            let told = told(found, b);
            let size = told.as_ref().map_or(f64::INFINITY, |(_, size)| *size);
            let text = match (told, found.status) {
                (Some((text, _)), "converged") => text,
                (Some((text, _)), status) => format!("{text} {status}"),
                (None, status) => status.to_owned(),
            };
            let level = (size / LEAST).max(1.0).log10().ceil();
            row.push(text);
            levels.push(level.min(f64::from(Table::WORST)) as u8);
        }
        table.rows.push(row);
        table.levels.push(levels);
    }
    table
}

fn how_sure() -> Block {
    Block::Text(
        "Each cell is one run of one servo with one seed, so a factor of two between methods may be chance; a sweep tells \
         how a method does on many servos. No method was set by hand for any case."
            .to_owned(),
    )
}

fn rests_on(of: &Comparison) -> Vec<Block> {
    let cases = of.cases.iter().map(|compared| {
        let case = &compared.case;
        (case.name.to_owned(), case.detail.clone())
    });
    let methods = of.methods.iter().map(|method| {
        vec![
            method.name.to_owned(),
            method.source.to_owned(),
            method.closing.to_owned(),
            method.prior.to_owned(),
        ]
    });
    vec![
        Block::Facts(cases.collect()),
        Block::Table(Table::new(
            "The methods",
            ["method", "from", "loop", "known beforehand"]
                .map(Column::words)
                .into(),
            methods.collect(),
        )),
    ]
}

fn next() -> Vec<Block> {
    vec![Block::List(vec![
        "Look for the case that is most like your servo, and take a method that converged there: identifier.law.".to_owned(),
        "Mind what must be known beforehand, and the operations a sample where it runs on a chip.".to_owned(),
    ])]
}
