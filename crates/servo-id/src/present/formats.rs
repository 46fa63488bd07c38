//! A comparison of number formats.

use host_sim::drift::{Difference, DriftResult};

use super::estimates::dash;
use super::number::{figure, fixed, rough};
use super::{Block, Column, Table};

/// The table of a comparison of number formats.
#[must_use]
pub fn formats(result: &DriftResult) -> [Block; 2] {
    [
        Block::Table(differences(result)),
        Block::Text(format!(
            "Differences from f64 on the same {} measurements: mean and root mean square over the last quarter, the \
             largest\nover the whole run.",
            result.samples
        )),
    ]
}

/// A row for each format and signal.
fn differences(result: &DriftResult) -> Table {
    let columns = vec![
        Column::words("signal"),
        Column::words("format"),
        Column::figures("rms in f64").drop_order(2),
        Column::figures("mean off by").drop_order(1),
        Column::figures("rms off by"),
        Column::figures("at most"),
        Column::figures("signal to noise").drop_order(0),
    ];
    let row = |format: &str, difference: &Difference| {
        let ratio = difference.signal_to_noise();
        vec![
            format!("{} [{}]", difference.name, difference.unit),
            format.to_owned(),
            figure(difference.size),
            rough(difference.mean),
            rough(difference.rms),
            rough(difference.max),
            ratio.map_or_else(dash, |decibel| format!("{} dB", fixed(decibel, 0))),
        ]
    };
    let single = result.f32.iter().map(|difference| row("f32", difference));
    let fixed = result
        .fixed
        .iter()
        .map(|difference| row("fixed", difference));
    Table::new("", columns, single.chain(fixed).collect())
}
