//! The table of what was identified of a servo.

use identifier_core::parameters::Unknown;

use super::number::{DASH, figure, fixed, known_to, rough, signed, with_error};
use super::{Column, Table};

/// An estimate, SI.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimated {
    pub(super) unknown: Unknown,
    pub(super) unit: &'static str,
    /// None where the data contain no information on it.
    pub(super) value: Option<f64>,
    pub(super) std_error: Option<f64>,
    pub(super) is_at_bound: bool,
    /// Standard deviation over the end of the run.
    pub(super) wander: Option<f64>,
    pub(super) truth: Option<f64>,
    /// Time from which on it was near the truth, s; the inner is none where it never was.
    pub(super) settled: Option<Option<f64>>,
    /// Time at which its term entered the model, s.
    pub(super) since: Option<f64>,
}

impl Estimated {
    /// An estimate with its standard error.
    pub(super) fn new(unknown: Unknown, value: f64, std_error: Option<f64>) -> Self {
        Self {
            unknown,
            unit: unknown.unit(),
            value: Some(value),
            std_error,
            is_at_bound: false,
            wander: None,
            truth: None,
            settled: None,
            since: None,
        }
    }

    /// True if it has a finite standard error.
    pub(super) fn is_sure(&self) -> bool {
        self.value.is_some() && self.std_error.is_some_and(f64::is_finite)
    }

    fn known_to(&self) -> String {
        match self.value {
            _ if self.is_at_bound => "at a bound".to_owned(),
            Some(value) => known_to(value, self.std_error),
            None => DASH.to_owned(),
        }
    }

    fn off_by(&self) -> String {
        match (self.value, self.truth) {
            (Some(value), Some(truth)) if !(value - truth).is_finite() => figure(value - truth),
            (Some(value), Some(0.0)) => match figure(value) {
                size if value > 0.0 => format!("+{size}"),
                size => size,
            },
            (Some(value), Some(truth)) => {
                format!("{} %", signed(100.0 * (value / truth - 1.0), 3))
            }
            _ => DASH.to_owned(),
        }
    }
}

/// The table of estimates, one row each; columns that no row has something for are left out.
pub(super) fn table(rows: &[Estimated]) -> Table {
    type Cell = fn(&Estimated) -> String;
    let columns: [(Column, bool, Cell); 10] = [
        (Column::words("quantity"), true, |row| {
            row.unknown.name().to_owned()
        }),
        (Column::figures("estimate"), true, |row| {
            with_error(row.value.unwrap_or(f64::NAN), row.std_error)
        }),
        (Column::words("unit"), true, |row| row.unit.to_owned()),
        (
            Column::figures("95 % interval").drop_order(1),
            true,
            Estimated::known_to,
        ),
        (
            Column::figures("wander").drop_order(3),
            rows.iter().any(|row| row.wander.is_some()),
            |row| row.wander.map_or_else(dash, rough),
        ),
        (
            Column::figures("true"),
            rows.iter().any(|row| row.truth.is_some()),
            |row| row.truth.map_or_else(dash, figure),
        ),
        (
            Column::figures("off by"),
            rows.iter().any(|row| row.truth.is_some()),
            Estimated::off_by,
        ),
        (
            Column::figures("settled [s]").drop_order(2),
            rows.iter().any(|row| row.settled.is_some()),
            |row| row.settled.map_or_else(dash, settled),
        ),
        (
            Column::figures("since [s]").drop_order(0),
            rows.iter().any(|row| row.since.is_some()),
            |row| row.since.map_or_else(dash, |since| fixed(since, 2)),
        ),
        (Column::words("meaning").drop_order(4), true, |row| {
            row.unknown.meaning().to_owned()
        }),
    ];
    let shown = columns.into_iter().filter(|(_, is_shown, _)| *is_shown);
    let (columns, cells): (Vec<_>, Vec<_>) = shown.map(|(column, _, cell)| (column, cell)).unzip();
    let row = |row: &Estimated| cells.iter().map(|cell| cell(row)).collect();
    Table::new("", columns, rows.iter().map(row).collect())
}

/// A settling time, s.
pub(super) fn settled(time: Option<f64>) -> String {
    time.map_or_else(|| "not".to_owned(), |time| fixed(time, 2))
}

pub(super) fn dash() -> String {
    DASH.to_owned()
}
