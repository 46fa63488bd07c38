//! A recorded log: its samples, in SI and in even time.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::clock::usual_steps;
use super::even::{Clock, EvenRows};
use super::inner::Inner;
use super::row::{Row, rows};
use super::wrap::{Jumps, Period, Unwrap};
use super::{Jitter, LogError, Table};
use crate::motion_unit::{AxisKind, MotionUnit};
use crate::scenario::{LogQuantity, LogSettings, PositionUnit};

/// A recorded log.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    path: PathBuf,
    settings: LogSettings,
    /// Sample time, s.
    pub sample_time: f64,
    /// Its samples, the bridged ones among them.
    pub samples: u64,
    /// Findings about it.
    pub found: Found,
    rows: Vec<Row>,
    /// Its segments, each without a break.
    segments: Vec<Segment>,
    smallest_step: f64,
    references: Vec<f64>,
}

/// Findings about a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found {
    /// Which clock its rows have.
    pub clock: Clock,
    /// Deviation of its time stamps from an even clock, where that is its clock.
    pub jitter: Jitter,
    /// Samples that straight lines stand in for.
    pub bridged: u64,
    /// Gaps that they bridge.
    pub gaps: u64,
    /// Rows in ranges of time that were left out.
    pub left_out: u64,
    /// Positions that were left out: single ones far from those before and after.
    pub spikes: u64,
    /// Lines that were left out: [damaged](Table::damaged).
    pub damaged: u64,
    /// The separator of the columns of a text, by name.
    pub separator: Option<&'static str>,
    /// True for numbers with decimal commas.
    pub decimal_commas: bool,
    /// How the text was read, where that is not plain.
    pub notes: Vec<String>,
    /// The period after which its positions begin again, where they do.
    pub wrapped: Option<f64>,
}

/// A part of a log without a break.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// The first two steps of the position.
    beginning: Vec<f64>,
    /// Its samples.
    pub samples: u64,
}

impl Log {
    /// The most samples of a reference that are kept: those that a Γ is chosen from.
    pub const MAX_REFERENCES: usize = 200_000;

    /// The fewest samples of a log: fewer do not separate the four parameters from the motion at its
    /// beginning.
    const MIN_SAMPLES: usize = 10;

    /// Reads a `.csv` or `.csv.gz` file whose samples must be `sample_time` (s) apart. Without it, the mean of the log
    /// is used.
    ///
    /// # Errors
    /// The line and column that is wrong.
    #[cfg(feature = "files")]
    pub fn read(
        path: &Path,
        settings: &LogSettings,
        sample_time: Option<f64>,
    ) -> Result<Self, LogError> {
        Self::new(&Table::read(path)?, settings, sample_time)
    }

    /// Reads columns in memory, whose samples must be `sample_time` (s) apart. Without it, the mean of the log is used.
    ///
    /// # Errors
    /// The line and column that is wrong.
    pub fn new(
        table: &Table,
        settings: &LogSettings,
        sample_time: Option<f64>,
    ) -> Result<Self, LogError> {
        let path = &table.path;
        let in_file = |fault: String| LogError::in_file(path, fault);
        let column = |fault: &str| LogError::in_column(path, &settings.position, fault.to_owned());
        if sample_time.is_none() && !settings.has_sample_time() {
            let fault = "the sample time is unknown: state log.sample_time";
            return Err(in_file(fault.to_owned()));
        }
        let (mut rows, left_out) = rows(table, settings, sample_time.unwrap_or(f64::NAN))?;
        let usual = usual_steps(rows.iter().map(|row| row.time));
        if let (Some(stated), Some(usual)) =
            (sample_time, usual.filter(|_| settings.has_sample_time()))
        {
            check_rate(path, settings, usual, stated)?;
        }
        let measured = rows.iter().filter(|row| row.position.is_finite()).count();
        if measured < Self::MIN_SAMPLES {
            let cut = match left_out {
                0 => String::new(),
                rows => format!(", because log.cut leaves out {rows} rows"),
            };
            let least = Self::MIN_SAMPLES;
            return Err(in_file(format!(
                "the log has {measured} samples{cut}: it must have {least} or more"
            )));
        }
        if is_backwards(&rows) {
            let fault = "time decreases from row to row: sort the rows by time";
            return Err(in_file(fault.to_owned()));
        }
        hold(&mut rows);
        let Some(steps) = usual.or(sample_time.map(|stated| [stated; 2])) else {
            let fault = match &settings.time {
                Some(time) => format!(
                    "the time is the same in all rows of column {time}: state another column as log.time, or no log.time \
                     and log.sample_time"
                ),
                None => "the sample time is unknown: state log.sample_time".to_owned(),
            };
            return Err(in_file(fault));
        };
        let mut spikes = 0;
        if settings.is_velocity {
            spikes = leave_out_spikes(&mut rows).map_err(|fault| column(&fault))?;
            integrate(&mut rows);
        }
        let wrapped = unwrap(&mut rows, settings).map_err(|fault| column(&fault))?;
        if !settings.is_velocity {
            spikes = leave_out_spikes(&mut rows).map_err(|fault| column(&fault))?;
        }
        let smallest_step = smallest_step(&rows);
        let even = EvenRows::new(rows, settings, &steps, sample_time, smallest_step);
        let mut log = Self {
            path: path.clone(),
            settings: settings.clone(),
            sample_time: even.sample_time,
            samples: even.rows.len() as u64,
            found: Found {
                clock: even.clock,
                jitter: even.jitter,
                left_out,
                spikes,
                damaged: table.damaged,
                separator: table.separator,
                decimal_commas: table.decimal_commas,
                notes: table.notes.clone(),
                wrapped,
                ..Found::default()
            },
            rows: even.rows,
            segments: Vec::new(),
            smallest_step,
            references: Vec::new(),
        };
        log.divide().map_err(in_file)?;
        let (low, high) = extremes(log.rows.iter().map(|row| row.position));
        if low >= high {
            return Err(column(&format!(
                "the position is the same in all {measured} samples: state another column as log.position, or record \
                 a servo that moves"
            )));
        }
        log.check_speed().map_err(in_file)?;
        Ok(log)
    }

    /// Checks by its mean speed that the units of position and time can be.
    fn check_speed(&self) -> Result<(), String> {
        let (most, unit) = match self.settings.motion_unit() {
            MotionUnit::Stated(AxisKind::Rotary) => (1e6, "rad/s"),
            MotionUnit::Stated(AxisKind::Linear) => (1e5, "m/s"),
            _ => return Ok(()),
        };
        let steps = self.rows.windows(2);
        let way = steps.map(|pair| (pair[1].position - pair[0].position).abs());
        let speed = way.sum::<f64>() / self.duration();
        if speed <= most {
            return Ok(());
        }
        let units = &self.settings.units;
        Err(format!(
            "its mean speed is {speed:.1e} {unit}, which nothing reaches: state another log.position_unit than \"{}\" or \
             another log.time_unit than \"{}\"",
            units.position.name(),
            units.time.name()
        ))
    }

    /// Finds its segments, computes the commands of an inner loop in each, and adds known torques.
    fn divide(&mut self) -> Result<(), String> {
        const BEGINNING: usize = 3;
        let mut firsts: Vec<usize> = (0..self.rows.len())
            .filter(|row| self.rows[*row].begins)
            .collect();
        firsts.push(self.rows.len());
        let segments: Vec<Range<usize>> = firsts.windows(2).map(|pair| pair[0]..pair[1]).collect();
        for segment in segments {
            let rows = &self.rows[segment.clone()];
            let beginning = rows[..rows.len().min(BEGINNING)].windows(2);
            self.segments.push(Segment {
                beginning: beginning
                    .map(|pair| pair[1].position - pair[0].position)
                    .collect(),
                samples: rows.len() as u64,
            });
            if let Some(inner) = self.settings.inner {
                let commands = Inner::commands(inner, rows, self.sample_time)?;
                for (row, command) in self.rows[segment].iter_mut().zip(commands) {
                    row.command = Some(command);
                }
            }
        }
        if self.settings.known_torque.is_some() {
            for row in &mut self.rows {
                row.command = row.command.map(|command| command + row.known_torque);
            }
        }
        let mut was_bridged = false;
        for row in &self.rows {
            self.found.bridged += u64::from(row.bridged);
            self.found.gaps += u64::from(row.bridged && !was_bridged);
            was_bridged = row.bridged;
        }
        let references = self.rows.iter().filter_map(|row| row.reference);
        self.references = references.take(Self::MAX_REFERENCES).collect();
        Ok(())
    }

    /// Its samples.
    #[must_use]
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The largest command, either way; none where the log has no command.
    #[must_use]
    pub fn largest_command(&self) -> Option<f64> {
        let sizes = self.rows.iter().filter_map(|row| row.command.map(f64::abs));
        sizes.reduce(f64::max)
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// True if another log is of the same file.
    #[must_use]
    pub fn is_same_file(&self, other: &Self) -> bool {
        match (self.path.canonicalize(), other.path.canonicalize()) {
            (Ok(one), Ok(other)) => one == other,
            _ => self.path == other.path,
        }
    }

    /// Its columns and units.
    #[must_use]
    pub fn settings(&self) -> &LogSettings {
        &self.settings
    }

    /// The first sample.
    #[must_use]
    pub fn first(&self) -> &Row {
        &self.rows[0]
    }

    /// Its segments, one or more.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Its length, s, without what was left out.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.samples as f64 * self.sample_time
    }

    /// The reference at the beginning, at most [`Log::MAX_REFERENCES`] samples. Empty if the log has none.
    #[must_use]
    pub fn references(&self) -> &[f64] {
        &self.references
    }

    /// The resolution of the positions in logs of one encoder: their smallest change, and no finer than 2⁻²³ of the range
    /// they cover.
    #[must_use]
    pub fn resolution(logs: &[Self]) -> f64 {
        const MIN_RELATIVE: f64 = 1.0 / 8_388_608.0;
        let rows = logs.iter().flat_map(Self::rows);
        let (low, high) = extremes(rows.map(|row| row.position));
        let (smallest, _) = extremes(logs.iter().map(|log| log.smallest_step));
        smallest.max(MIN_RELATIVE * (high - low)).clamp(1e-12, 1.0)
    }
}

/// Lowest and highest of some numbers.
pub(crate) fn extremes(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let nothing = (f64::INFINITY, f64::NEG_INFINITY);
    numbers.fold(nothing, |(low, high), x| (low.min(x), high.max(x)))
}

/// True if most rows are earlier than the one before.
fn is_backwards(rows: &[Row]) -> bool {
    let back = rows
        .windows(2)
        .filter(|pair| pair[1].time < pair[0].time)
        .count();
    2 * back > rows.len()
}

/// Holds commands, references and known torques over rows without one. Before the first number the command is zero.
fn hold(rows: &mut [Row]) {
    let commanded = rows.iter().any(|row| row.command.is_some());
    let (mut command, mut reference, mut torque) = (commanded.then_some(0.0), None, 0.0);
    for row in rows {
        command = row.command.or(command);
        reference = row.reference.or(reference);
        (row.command, row.reference) = (command, reference);
        if row.known_torque.is_nan() {
            row.known_torque = torque;
        }
        torque = row.known_torque;
    }
}

/// The smallest change of a position from one row to the next.
fn smallest_step(rows: &[Row]) -> f64 {
    let measured = rows
        .iter()
        .map(|row| row.position)
        .filter(|position| position.is_finite());
    let mut last = f64::NAN;
    let steps = measured.map(|position| (position - std::mem::replace(&mut last, position)).abs());
    steps
        .filter(|step| *step > 0.0)
        .fold(f64::INFINITY, f64::min)
}

/// Leaves out the positions of single rows that are far from those before and after, and counts them.
///
/// # Errors
/// More than an occasional one.
fn leave_out_spikes(rows: &mut [Row]) -> Result<u64, String> {
    /// Size of a spike, steps of the quicker motion, and the part of them that is quicker.
    const SIZE: f64 = 10.0;
    const QUICKER: usize = 10;
    /// The most, part of the rows.
    const MAX_SHARE: f64 = 0.005;
    let measured = || (0..rows.len()).filter(|row| rows[*row].position.is_finite());
    let steps = || {
        let step = |(from, to): (usize, usize)| rows[to].position - rows[from].position;
        measured().zip(measured().skip(1)).map(step)
    };
    let mut sizes: Vec<f64> = steps().map(f64::abs).collect();
    let count = sizes.len();
    let (_, usual, _) = sizes.select_nth_unstable_by(count - 1 - count / QUICKER, f64::total_cmp);
    let usual = *usual;
    let is_spike =
        |back: f64, ahead: f64| back * ahead < 0.0 && back.abs().min(ahead.abs()) > SIZE * usual;
    let spikes: Vec<usize> = (steps().zip(steps().skip(1)).zip(measured().skip(1)))
        .filter(|((back, ahead), _)| usual > 0.0 && is_spike(*back, *ahead))
        .map(|(_, row)| row)
        .collect();
    if spikes.len() as f64 > MAX_SHARE * count as f64 {
        return Err(format!(
            "it has {} spikes in {} samples, the first in line {}, far from the samples before and after: this is no \
             motion; check the encoder's wires, or leave out its time with log.cut",
            spikes.len(),
            count + 1,
            rows[spikes[0]].line
        ));
    }
    for row in &spikes {
        rows[*row].position = f64::NAN;
    }
    Ok(spikes.len() as u64)
}

/// Makes positions of rates: their integral, by trapezoids.
fn integrate(rows: &mut [Row]) {
    let (mut position, mut last): (f64, Option<(f64, f64)>) = (0.0, None);
    for row in rows.iter_mut().filter(|row| row.position.is_finite()) {
        let rate = row.position;
        if let Some((time, before)) = last.filter(|(time, _)| row.time > *time) {
            position += 0.5 * (rate + before) * (row.time - time);
        }
        last = Some((row.time, rate));
        row.position = position;
    }
}

/// Continues positions, and the reference beside them, where they begin again after a period, which is returned.
fn unwrap(rows: &mut [Row], settings: &LogSettings) -> Result<Option<f64>, String> {
    let column = settings.units.scale(LogQuantity::Position, 1.0).abs();
    let (low, high) = extremes(
        rows.iter()
            .map(|row| row.position)
            .filter(|at| at.is_finite()),
    );
    let period = match settings.wrap {
        Some(stated) => (stated > 0.0).then_some(Period::Known(stated * column)),
        None => {
            let mut jumps = Jumps::default();
            let mut last = f64::INFINITY;
            for row in rows.iter().filter(|row| row.position.is_finite()) {
                jumps.add(row.position, row.time < last);
                last = row.time;
            }
            jumps.period(high - low, &settings.units)
        }
    };
    let period = match period {
        None => return Ok(None),
        Some(Period::Known(period)) => period,
        Some(Period::OfUnit(unit, _)) => {
            let (own, name) = (settings.units.position.name(), unit.name());
            let counts = match unit {
                PositionUnit::Count => " and encoder.counts_per_rev",
                _ => "",
            };
            return Err(format!(
                "the position wraps as one in {name} does, but log.position_unit is \"{own}\": state \
                 log.position_unit = \"{name}\"{counts}, or log.wrap, the period of the wrap in {own} (0: it does \
                 not wrap)"
            ));
        }
        Some(Period::Unknown(period)) => {
            return Err(format!(
                "the position jumps by about {period:.4} again and again, as if it wrapped: if it counts an encoder that \
                 begins again after a revolution, state encoder.counts_per_rev, otherwise log.wrap, the exact period in \
                 log.position_unit (0: it does not wrap)"
            ));
        }
    };
    let (lowest, highest) = extremes(rows.iter().filter_map(|row| row.reference));
    let wraps_too = highest - lowest <= 1.001 * period;
    let mut unwrap = Unwrap::new(period);
    for row in rows.iter_mut().filter(|row| row.position.is_finite()) {
        row.position = unwrap.position(row.position);
        if wraps_too {
            row.reference =
                (row.reference).map(|reference| unwrap.reference(reference, row.position));
        }
    }
    Ok(Some(period))
}

/// Checks the usual times from one row to the next, s, against the stated one.
fn check_rate(
    path: &Path,
    settings: &LogSettings,
    usual: [f64; 2],
    stated: f64,
) -> Result<(), LogError> {
    /// Largest relative difference.
    const TOLERANCE: f64 = 0.03;
    let is_stated = |step: f64| (step / stated - 1.0).abs() <= TOLERANCE;
    if usual.iter().any(|step| is_stated(*step)) {
        return Ok(());
    }
    let usual = usual[1];
    let advice = match settings.other_time_unit(usual, is_stated) {
        Some(unit) => format!("; state log.time_unit = \"{}\"", unit.name()),
        None => "; check log.time_unit, too".to_owned(),
    };
    let fault = format!(
        "its samples are {usual:.6e} s apart, but controller.sample_time or log.sample_time is {stated} s: they must \
         agree to {} %{advice}",
        100.0 * TOLERANCE
    );
    Err(LogError::in_file(path, fault))
}

impl AsRef<[Self]> for Log {
    /// One log, where there may be several.
    fn as_ref(&self) -> &[Self] {
        std::slice::from_ref(self)
    }
}

impl Segment {
    /// True if the servo is at standstill at the first sample, to a resolution of the position.
    ///
    /// It does if the first step shows no motion, or the beginning of one. Under a held command, steps from standstill
    /// are 1 and 3 units, and steps at a velocity v are v + 1 and v + 3. So 3Δ₁ − Δ₂ is twice the velocity at the first
    /// sample. It counts as zero if quantisation (at most half a resolution for each of three positions) or a changed
    /// command explains it.
    #[must_use]
    pub fn begins_at_rest(&self, resolution: f64) -> bool {
        const REST_TOLERANCE: f64 = 4.0;
        const COMMAND_CHANGE: f64 = 0.5;
        match self.beginning[..] {
            [first, ..] if first.abs() <= 1.5 * resolution => true,
            [first, second] => {
                let twice_the_velocity = 3.0 * first - second;
                twice_the_velocity.abs()
                    <= REST_TOLERANCE * resolution + COMMAND_CHANGE * second.abs()
            }
            _ => false,
        }
    }
}
