//! Tables for a terminal.

use comfy_table::{CellAlignment, Table, presets};

use super::{Estimate, Summary};

/// One row for each experiment, named in the first column.
#[must_use]
pub fn estimates(rows: &[(&str, &Summary)]) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY);
    table.set_header([
        "experiment",
        "â [1/s]",
        "â − a",
        "b̂ [rad/s²/u]",
        "b̂/b − 1",
        "d̂ [rad/s²]",
        "settled a, b [s]",
        "status",
    ]);
    for (name, summary) in rows {
        let truth = &summary.truth;
        let (a, b) = (&summary.a, &summary.b);
        table.add_row([
            (*name).to_owned(),
            with_spread(a, 4),
            format!("{:+.4}", a.tail_mean - truth.a),
            with_spread(b, 2),
            format!("{:+.3} %", 100.0 * (b.tail_mean / truth.b - 1.0)),
            summary
                .load
                .as_ref()
                .map_or_else(|| "–".to_owned(), |load| with_spread(load, 2)),
            format!(
                "{}, {}",
                seconds(summary.settling_a),
                seconds(summary.settling_b)
            ),
            summary.status.name().to_owned(),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}

fn with_spread(estimate: &Estimate, digits: usize) -> String {
    format!(
        "{:.digits$} ± {:.digits$}",
        estimate.tail_mean, estimate.tail_std
    )
}

fn seconds(time: Option<f64>) -> String {
    time.map_or_else(|| "not".to_owned(), |time| format!("{time:.2}"))
}
