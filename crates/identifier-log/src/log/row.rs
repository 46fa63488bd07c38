//! A row of a log in SI, whatever file it is from.

use super::{LogError, Table};
use crate::scenario::{LogQuantity, LogSettings, TimeUnit};

/// One sample of a log, SI.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Row {
    /// The line of the file, from 1, the heading among them; of a bridged sample, that after the gap.
    pub line: u32,
    /// Time, s.
    pub time: f64,
    /// Reference position, where the log has one.
    pub reference: Option<f64>,
    /// Measured position.
    pub position: f64,
    /// The command that acted from here to the next sample, where the log has one.
    pub command: Option<f64>,
    /// Known torque beside the command, command units; zero where the log has none. A log has added it to its commands.
    pub known_torque: f64,
    /// Measured velocity, where the log has one.
    pub velocity: Option<f64>,
    /// True if a straight line replaces samples that were not recorded.
    pub bridged: bool,
    /// True if the motion directly before is unknown: at the first row, and at the first after a range that was left
    /// out.
    pub begins: bool,
}

impl Row {
    /// A row at a time, s, without its other quantities.
    #[must_use]
    pub fn at(line: u64, time: f64) -> Self {
        Self {
            // A table has fewer rows.
            line: line as u32,
            time,
            ..Self::default()
        }
    }

    /// Sets one quantity, SI.
    pub(super) fn set(&mut self, quantity: LogQuantity, value: f64) {
        match quantity {
            LogQuantity::Time => self.time = value,
            LogQuantity::Reference => self.reference = Some(value),
            LogQuantity::Position => self.position = value,
            LogQuantity::Command => self.command = Some(value),
            LogQuantity::KnownTorque => self.known_torque = value,
            LogQuantity::Velocity => self.velocity = Some(value),
        }
    }
}

/// The rows of a table in SI, in the order of its lines, and the number that was left out by time. Position and
/// velocity are NaN where a row has none. Without a column of time, and by a counter, rows are `sample_time` (s) apart.
///
/// # Errors
/// The column that is missing, the row whose number is not allowed.
pub(super) fn rows(
    table: &Table,
    settings: &LogSettings,
    sample_time: f64,
) -> Result<(Vec<Row>, u64), LogError> {
    let places = (settings.columns())
        .map(|(quantity, column)| {
            let place = table.place(column)?;
            let of = &table.columns[place];
            let is_stamp = quantity == LogQuantity::Time && settings.units.time == TimeUnit::Stamp;
            if is_stamp && of.stamps == 0 {
                let fault = "it must be a time such as 2026-11-22T06:25:00.125".to_owned();
                return Err(LogError::in_column(&table.path, column, fault));
            }
            Ok((
                quantity,
                column,
                of,
                settings.units.scale(quantity, sample_time),
            ))
        })
        .collect::<Result<Vec<_>, _>>()?;
    let time = places
        .iter()
        .find(|(quantity, ..)| *quantity == LogQuantity::Time);
    // Where days are counted from is no matter, and costs digits.
    let begins = time
        .and_then(|(_, _, of, scale)| Some(scale * of.values.iter().find(|time| time.is_finite())?))
        .filter(|begins| begins.abs() > FAR_TIME)
        .unwrap_or(0.0);
    let mut left_out = 0;
    let mut rows = Vec::with_capacity(table.rows());
    for (index, line) in table.lines.iter().enumerate() {
        let at = match time {
            Some((_, _, of, scale)) => scale * of.values[index] - begins,
            None => index as f64 * sample_time,
        };
        if settings.leaves_out(at) {
            left_out += 1;
            continue;
        }
        let mut row = Row::at(u64::from(*line), at);
        row.position = f64::NAN;
        if settings.known_torque.is_some() {
            row.known_torque = f64::NAN;
        }
        for (quantity, column, of, scale) in &places {
            let number = of.values[index];
            let other = || of.others.iter().find(|(row, _)| *row == index);
            let fault = match check_magnitude(scale * number) {
                Ok(()) => None,
                Err(_) if number.is_nan() => other().map(|(_, fault)| fault.clone()),
                Err(why) => Some(format!("{number} is not allowed: {why}")),
            };
            if let Some(fault) = fault {
                let fault = format!("{fault}; correct it, or leave out its time with log.cut");
                let column = column.to_string();
                return Err(LogError::at_line(
                    &table.path,
                    u64::from(row.line),
                    Some(&column),
                    fault,
                ));
            }
            if *quantity != LogQuantity::Time && !number.is_nan() {
                row.set(*quantity, scale * number);
            }
        }
        // Without a time a row stands nowhere.
        if at.is_finite() {
            rows.push(row);
        }
    }
    Ok((rows, left_out))
}

/// Times from here on are not those of a log that begins at zero, s.
const FAR_TIME: f64 = 1e6;

/// Checks that a number can be a measurement, s, rad or command units.
///
/// # Errors
/// The allowed range.
pub(super) fn check_magnitude(number: f64) -> Result<(), String> {
    const MAX: f64 = 1e12;
    if number.abs() <= MAX {
        return Ok(());
    }
    Err(format!(
        "in s, rad and command units a number is from -{MAX:e} to {MAX:e}"
    ))
}
