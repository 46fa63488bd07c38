//! A sweep as a table, as JSON, as CSV and as a picture.

use std::io::Write;

use serde::Serialize;

use crate::present::{Envelope, Figure};
use crate::render::terminal::table::Rows;
use crate::sweep::{Distribution, Run, Spread};

/// The quantiles, as many as `width` characters have room for.
#[must_use]
pub fn table(distribution: &Distribution, width: u16) -> String {
    let mut table = Rows::default().words("quantity").figures("servos");
    for (quantile, rank) in [("5 %", 2), ("25 %", 1), ("50 %", 0), ("75 %", 1)] {
        table = table.figures(quantile).dispensable(rank);
    }
    table = table.figures("95 %").figures("largest");
    for spread in &distribution.spreads {
        let mut row = vec![
            format!("{} [{}]", spread.name, spread.unit),
            spread.count.to_string(),
        ];
        let quantiles = spread.quantiles.named();
        row.extend(quantiles.map(|(_, value)| format!("{value:.4}")));
        table.row(row);
    }
    table.within(width)
}

/// The share of servos that are no worse, a figure for each quantity.
#[must_use]
pub fn figures(distribution: &Distribution) -> Vec<Figure> {
    distribution.spreads.iter().map(figure).collect()
}

fn figure(spread: &Spread) -> Figure {
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

/// Writes the runs, one row a servo, SI; what a run does not have is left empty.
///
/// # Errors
/// Whatever the writer answers.
pub fn csv(out: impl Write, runs: &[Run]) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record([
        "run",
        "status",
        "a",
        "b",
        "coulomb",
        "load",
        "a_found",
        "b_found",
        "coulomb_found",
        "load_found",
        "a_settled_s",
        "b_settled_s",
    ])?;
    for run in runs {
        let known = |value: Option<f64>| {
            value
                .filter(|value| value.is_finite())
                .map_or_else(String::new, |value| value.to_string())
        };
        writer.write_record([
            run.index.to_string(),
            run.status.name().to_owned(),
            run.truth.a.to_string(),
            run.truth.b.to_string(),
            run.truth.coulomb.to_string(),
            run.truth.load.to_string(),
            known(Some(run.found.a)),
            known(Some(run.found.b)),
            known(Some(run.found.coulomb)),
            known(Some(run.found.load)),
            known(run.settling_a),
            known(run.settling_b),
        ])?;
    }
    writer.flush()?;
    Ok(())
}

/// The distribution for a program.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct Document {
    pub law: &'static str,
    pub seed: u32,
    pub wanted: u32,
    pub runs: usize,
    pub converged: usize,
    pub unexplained: usize,
    pub no_information: usize,
    pub moving: usize,
    pub aborted: usize,
    pub spreads: Vec<SpreadDocument>,
}

/// The quantiles of one quantity.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct SpreadDocument {
    pub quantity: &'static str,
    pub unit: &'static str,
    pub count: usize,
    pub q05: f64,
    pub q25: f64,
    pub q50: f64,
    pub q75: f64,
    pub q95: f64,
    pub max: f64,
}

impl Document {
    /// The document of a sweep.
    #[must_use]
    pub fn new(law: &'static str, seed: u32, wanted: u32, distribution: &Distribution) -> Self {
        Self {
            law,
            seed,
            wanted,
            runs: distribution.runs,
            converged: distribution.converged,
            unexplained: distribution.unexplained,
            no_information: distribution.no_information,
            moving: distribution.moving,
            aborted: distribution.aborted,
            spreads: distribution
                .spreads
                .iter()
                .map(|spread| SpreadDocument {
                    quantity: spread.name,
                    unit: spread.unit,
                    count: spread.count,
                    q05: spread.quantiles.q05,
                    q25: spread.quantiles.q25,
                    q50: spread.quantiles.q50,
                    q75: spread.quantiles.q75,
                    q95: spread.quantiles.q95,
                    max: spread.quantiles.max,
                })
                .collect(),
        }
    }
}
