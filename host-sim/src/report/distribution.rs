//! A sweep as CSV and as a picture.

use std::io::Write;

use crate::present::{Envelope, Figure};
use crate::sweep::{Distribution, Run, Spread};

/// Which share of the servos is no worse, one panel for each quantity.
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
