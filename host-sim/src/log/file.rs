//! A recorded log: read once to be judged, and again, row by row, whenever it is needed.

use std::path::{Path, PathBuf};
#[cfg(feature = "experiments")]
use std::sync::Arc;

#[cfg(feature = "experiments")]
use super::columns::{ColumnRows, Columns};
use super::csv::{Dialect, TextRows};
use super::excerpt::{Excerpt, Segment};
use super::inner::DrivenRows;
use super::row::{Row, Rows};
use super::spacing::{EvenRows, Wrapped, usual_step};
use super::wrap::{Jumps, Period};
use super::{Jitter, LogError};
use crate::scenario::{LogQuantity, LogSettings, MAX_PLAYED, PositionUnit};

/// A recorded log with even samples that was judged sound. Its findings are kept, its samples are not: its
/// size does not matter.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    path: PathBuf,
    settings: LogSettings,
    format: Format,
    /// Sample time, s.
    pub sample_time: f64,
    /// Its samples, the bridged ones among them.
    pub samples: u64,
    /// Findings about it.
    pub found: Found,
    /// Its stretches, each without a break.
    stretches: Vec<Stretch>,
    /// Lowest and highest position, and reference.
    positions: (f64, f64),
    reference_extremes: (f64, f64),
    smallest_step: f64,
    references: Vec<f64>,
    largest_command: Option<f64>,
    /// The part of it that a scan looks at.
    segments: Vec<Segment>,
}

/// The format of a log, detected once.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Format {
    /// No file, but columns in memory.
    #[cfg(feature = "experiments")]
    Columns(Arc<Columns>),
    /// `.csv`, `.csv.gz`.
    Text(Dialect),
}

impl Format {
    /// # Errors
    /// The file that cannot be read.
    pub(super) fn detect(path: &Path) -> Result<Self, LogError> {
        Dialect::detect(path).map(Self::Text)
    }

    /// Opens a file of this format; without stamps, its rows are `sample_time` (s) apart.
    ///
    /// # Errors
    /// The file, or the column that is missing.
    pub(super) fn open<'a>(
        &'a self,
        path: &'a Path,
        settings: &'a LogSettings,
        sample_time: f64,
    ) -> Result<Box<dyn Rows + 'a>, LogError> {
        Ok(match self {
            #[cfg(feature = "experiments")]
            Self::Columns(columns) => {
                Box::new(ColumnRows::open(path, settings, columns, sample_time)?)
            }
            Self::Text(dialect) => Box::new(TextRows::open(path, settings, *dialect, sample_time)?),
        })
    }
}

/// Findings about a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found {
    /// Deviation of its time stamps from an even clock.
    pub jitter: Jitter,
    /// Samples that straight lines stand in for.
    pub bridged: u64,
    /// Gaps that they bridge.
    pub gaps: u64,
    /// Rows in ranges of time that were left out.
    pub left_out: u64,
    /// The separator of the columns of a text, by name.
    pub separator: Option<&'static str>,
    /// True for numbers with decimal commas.
    pub decimal_commas: bool,
    /// The row of units below the heading.
    pub units_row: Option<String>,
    /// The period after which its positions begin again, where they do.
    pub wrapped: Option<Wrapped>,
}

/// A part of a log without a break.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stretch {
    /// Its first sample.
    pub(crate) first: Row,
    /// True for the log's first.
    begins_the_log: bool,
    /// The first two steps of the position.
    beginning: Vec<f64>,
    /// Its samples.
    pub(crate) samples: u64,
}

impl Log {
    /// The fewest samples of a log: fewer do not separate the four parameters from the motion at its
    /// beginning.
    const MIN_SAMPLES: u64 = 10;

    /// Reads a `.csv` or `.csv.gz` file whose samples must be `sample_time` (s) apart; without it,
    /// the mean of the log holds.
    ///
    /// # Errors
    /// The line and column that is wrong.
    pub fn read(
        path: &Path,
        settings: &LogSettings,
        sample_time: Option<f64>,
    ) -> Result<Self, LogError> {
        let format = Format::detect(path)?;
        Self::of_format(path, settings, &format, sample_time)
    }

    /// Reads columns in memory, as [`read`](Self::read) reads those of a file. They have a `name` in messages.
    ///
    /// # Errors
    /// The row, counted from 1, and the column that is wrong.
    #[cfg(feature = "experiments")]
    pub fn of_columns(
        name: &str,
        columns: Columns,
        settings: &LogSettings,
        sample_time: Option<f64>,
    ) -> Result<Self, LogError> {
        let format = Format::Columns(Arc::new(columns));
        Self::of_format(Path::new(name), settings, &format, sample_time)
    }

    fn of_format(
        path: &Path,
        settings: &LogSettings,
        format: &Format,
        sample_time: Option<f64>,
    ) -> Result<Self, LogError> {
        let rows = |sample_time| format.open(path, settings, sample_time);
        let Some(stated) = sample_time else {
            if !settings.has_sample_time() {
                let fault = "nothing says how long a sample lasts: state log.sample_time";
                return Err(LogError::in_file(path, fault.to_owned()));
            }
            let usual = usual_step(rows(f64::NAN)?, settings)?.unwrap_or(f64::NAN);
            check_step(path, settings, usual)?;
            let (mut log, mean) = Self::unwrapped(path, settings, format, usual)?;
            log.sample_time = mean.unwrap_or(usual);
            return Ok(log);
        };
        let log = match Self::unwrapped(path, settings, format, stated) {
            Ok((log, mean)) => check_rate(path, settings, mean, stated).map(|()| log)?,
            // A rate that is not the stated one is why time seems to be wrong.
            Err(error) => {
                let usual = usual_step(rows(stated)?, settings).ok().flatten();
                let rate = check_rate(path, settings, usual, stated);
                return Err(rate.err().unwrap_or(error));
            }
        };
        Ok(log)
    }

    /// Reads all of it, its positions continued where they begin again after a period; with its mean time from one
    /// sample to the next, s.
    fn unwrapped(
        path: &Path,
        settings: &LogSettings,
        format: &Format,
        sample_time: f64,
    ) -> Result<(Self, Option<f64>), LogError> {
        let judge = |wrapped| Self::judge(path, settings, format, sample_time, wrapped);
        let column = settings
            .units
            .scale(LogQuantity::Position, sample_time)
            .abs();
        let wrapped = |log: &Self, period| Wrapped {
            period,
            reference_too: log.reference_range() <= 1.001 * period,
        };
        let (log, jumps, mean) = judge(None)?;
        let period = match settings.wrap {
            Some(stated) => (stated > 0.0).then_some(Period::Known(stated * column)),
            None => jumps.period(log.range(), &settings.units),
        };
        let stated = &settings.position;
        match period {
            None => Ok((log, mean)),
            Some(Period::Known(period)) => {
                let (log, _, mean) = judge(Some(wrapped(&log, period)))?;
                Ok((log, mean))
            }
            Some(Period::OfUnit(unit)) => {
                let (own, name) = (settings.units.position.name(), unit.name());
                let counts = match unit {
                    PositionUnit::Count => " and encoder.counts_per_rev",
                    _ => "",
                };
                let fault = format!(
                    "the position begins again as one in {name} does, and log.position_unit is \"{own}\": state \
                     log.position_unit = \"{name}\"{counts}, or log.wrap, after how many {own} it begins again (0: it \
                     does not)"
                );
                Err(LogError::in_column(path, stated, fault))
            }
            Some(Period::Unknown(period)) => {
                let fault = format!(
                    "the position jumps by about {period:.4} again and again, as one that begins again: state log.wrap, \
                     the exact period in log.position_unit (0: it does not begin again)"
                );
                Err(LogError::in_column(path, stated, fault))
            }
        }
    }

    /// Reads all of it once; with its jumps, and its mean time from one sample to the next, s.
    fn judge(
        path: &Path,
        settings: &LogSettings,
        format: &Format,
        sample_time: f64,
        wrapped: Option<Wrapped>,
    ) -> Result<(Self, Jumps, Option<f64>), LogError> {
        let rows = format.open(path, settings, sample_time)?;
        let rows = EvenRows::new(path, rows, settings, sample_time);
        let mut rows = DrivenRows::new(path, rows, settings, sample_time, wrapped.as_ref())?;
        let mut log = Self {
            path: path.to_owned(),
            settings: settings.clone(),
            format: format.clone(),
            sample_time,
            samples: 0,
            found: Found::default(),
            stretches: Vec::new(),
            positions: NOTHING,
            reference_extremes: NOTHING,
            smallest_step: f64::INFINITY,
            references: Vec::new(),
            largest_command: None,
            segments: Vec::new(),
        };
        let mut last: Option<Row> = None;
        let mut jumps = Jumps::default();
        let mut excerpt = Excerpt::default();
        for row in rows.by_ref() {
            let row = row?;
            log.add(last.as_ref(), &row);
            jumps.add(row.position, row.begins);
            excerpt.add(&row);
            last = Some(row);
        }
        log.segments = excerpt.finish();
        log.found.wrapped = wrapped;
        log.found.jitter = rows.even().jitter();
        rows.even().source().describe(&mut log.found);
        log.check()?;
        Ok((log, jumps, rows.even().mean_step()))
    }

    fn add(&mut self, last: Option<&Row>, row: &Row) {
        const BEGINNING_STEPS: usize = 2;
        self.samples += 1;
        self.found.bridged += u64::from(row.bridged);
        let was_bridged = last.is_some_and(|last| last.bridged);
        self.found.gaps += u64::from(row.bridged && !was_bridged);
        let widened = |(low, high): (f64, f64), x: f64| (low.min(x), high.max(x));
        self.positions = widened(self.positions, row.position);
        if let Some(reference) = row.reference {
            self.reference_extremes = widened(self.reference_extremes, reference);
        }
        let size = row.command.map(f64::abs);
        self.largest_command = size
            .map(|size| size.max(self.largest_command.unwrap_or(0.0)))
            .or(self.largest_command);
        if self.references.len() < MAX_PLAYED {
            self.references.extend(row.reference);
        }
        match (last, self.stretches.last_mut()) {
            (Some(last), Some(stretch)) if !row.begins => {
                let step = row.position - last.position;
                stretch.samples += 1;
                if stretch.beginning.len() < BEGINNING_STEPS {
                    stretch.beginning.push(step);
                }
                if step.abs() > 0.0 && !row.bridged && !was_bridged {
                    self.smallest_step = self.smallest_step.min(step.abs());
                }
            }
            _ => self.stretches.push(Stretch {
                first: *row,
                begins_the_log: self.stretches.is_empty(),
                beginning: Vec::new(),
                samples: 1,
            }),
        }
    }

    /// Checks that anything can be learnt from it.
    fn check(&self) -> Result<(), LogError> {
        let (samples, left_out) = (self.samples, self.found.left_out);
        if samples < Self::MIN_SAMPLES {
            let cut = match left_out {
                0 => String::new(),
                rows => format!(", as log.cut leaves {rows} rows out"),
            };
            let fault = format!(
                "the log has {samples} samples{cut}: it must have {} or more",
                Self::MIN_SAMPLES
            );
            return Err(LogError::in_file(&self.path, fault));
        }
        let (low, high) = self.positions;
        if low < high {
            return Ok(());
        }
        let fault = format!(
            "the position is the same in all {samples} samples: a servo that does not move shows \
             nothing; state the column of the measured position as log.position, or let it move"
        );
        let (line, column) = (self.first().line, self.settings.position.to_string());
        Err(LogError::at_line(&self.path, line, Some(&column), fault))
    }

    /// Its samples from the first, read again.
    ///
    /// # Errors
    /// If the file can no longer be read; whatever is wrong with a row, if it is no longer what it was.
    pub fn rows(&self) -> Result<impl Iterator<Item = Result<Row, LogError>> + '_, LogError> {
        let Self {
            path,
            settings,
            format,
            sample_time,
            ..
        } = self;
        let rows = format.open(path, settings, *sample_time)?;
        let rows = EvenRows::new(path, rows, settings, *sample_time);
        DrivenRows::new(
            path,
            rows,
            settings,
            *sample_time,
            self.found.wrapped.as_ref(),
        )
    }

    /// The largest command, either way; none where the log has no command.
    #[must_use]
    pub fn largest_command(&self) -> Option<f64> {
        self.largest_command
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its columns and units.
    #[must_use]
    pub fn settings(&self) -> &LogSettings {
        &self.settings
    }

    /// The first sample.
    #[must_use]
    pub fn first(&self) -> &Row {
        &self.stretches[0].first
    }

    /// Its stretches, one or more.
    pub(crate) fn stretches(&self) -> &[Stretch] {
        &self.stretches
    }

    /// The part of it that a scan looks at, a segment for each range without a break: all of a log of 131 072 samples
    /// or fewer, of a longer one the parts of the largest motion.
    pub(crate) fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Distance between the lowest and the highest position.
    pub(crate) fn range(&self) -> f64 {
        let (low, high) = self.positions;
        high - low
    }

    fn reference_range(&self) -> f64 {
        let (low, high) = self.reference_extremes;
        high - low
    }

    /// Its length, s, without what was left out.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.samples as f64 * self.sample_time
    }

    /// The reference at the beginning, at most as many samples as a choice of Γ plays; nothing where the log has none.
    #[must_use]
    pub fn references(&self) -> &[f64] {
        &self.references
    }

    /// The resolution of the recorded positions: their smallest change, and no finer than 2⁻²³ of
    /// the range they cover.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        const MIN_RELATIVE: f64 = 1.0 / 8_388_608.0;
        let smallest = self.smallest_step.max(MIN_RELATIVE * self.range());
        smallest.clamp(1e-12, 1.0)
    }
}

/// Extremes of no number.
const NOTHING: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// Checks that the mean time from one sample to the next, s, is the stated one.
fn check_rate(
    path: &Path,
    settings: &LogSettings,
    mean: Option<f64>,
    stated: f64,
) -> Result<(), LogError> {
    /// Largest relative difference.
    const TOLERANCE: f64 = 0.01;
    match mean {
        Some(mean) if (mean / stated - 1.0).abs() > TOLERANCE => {
            let is_stated = |step: f64| (step / stated - 1.0).abs() < TOLERANCE;
            let advice = match settings.other_time_unit(mean, is_stated) {
                Some(unit) => format!("; state log.time_unit = \"{}\"", unit.name()),
                None => "; look at log.time_unit, too".to_owned(),
            };
            let fault = format!(
                "its samples are {mean:.6e} s apart, where controller.sample_time or log.sample_time \
                 is {stated} s: they must agree to {} %{advice}",
                100.0 * TOLERANCE
            );
            Err(LogError::in_file(path, fault))
        }
        _ => Ok(()),
    }
}

/// Checks that the usual time from one sample to the next, s, which nothing states, is that of a servo's loop.
fn check_step(path: &Path, settings: &LogSettings, usual: f64) -> Result<(), LogError> {
    /// Sample times of servo loops, s: slower ones do not control a servo, and no bus or drive logs faster.
    const USUAL: std::ops::RangeInclusive<f64> = 1e-5..=0.04;
    if usual.is_nan() || USUAL.contains(&usual) {
        return Ok(());
    }
    let is_usual = |step: f64| USUAL.contains(&step);
    let Some(unit) = settings.other_time_unit(usual, is_usual) else {
        return Ok(());
    };
    let fault = format!(
        "its samples are {usual:.6e} s apart if log.time is in {}, which no servo's loop is: state log.time_unit = \
         \"{}\", or log.sample_time if it is right",
        settings.units.time.name(),
        unit.name()
    );
    Err(LogError::in_file(path, fault))
}

impl AsRef<[Self]> for Log {
    /// One log, where there may be several.
    fn as_ref(&self) -> &[Self] {
        std::slice::from_ref(self)
    }
}

impl Stretch {
    /// True if the servo stands at the first sample, to a resolution of the position.
    ///
    /// It does if the first step shows no motion, or if it is the beginning of one: under a held
    /// command, steps from rest are as 1 to 3, and steps at a velocity v are v + 1 to v + 3. So
    /// 3Δ₁ − Δ₂ is twice the velocity at the first sample; it counts as none where rounding (at most
    /// half a resolution for each of three positions) or a command that changed meanwhile explains it.
    /// Behind a break a servo is taken to be in motion, as it mostly is: slow ones cannot be detected.
    pub(crate) fn begins_at_rest(&self, resolution: f64) -> bool {
        const ROUNDING: f64 = 4.0;
        const COMMAND_CHANGE: f64 = 0.5;
        if !self.begins_the_log {
            return false;
        }
        match self.beginning[..] {
            [first, ..] if first.abs() <= 1.5 * resolution => true,
            [first, second] => {
                let twice_the_velocity = 3.0 * first - second;
                twice_the_velocity.abs() <= ROUNDING * resolution + COMMAND_CHANGE * second.abs()
            }
            _ => false,
        }
    }
}
