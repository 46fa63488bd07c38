//! A recorded log: read once to be judged, and again, row by row, whenever it is needed.

use std::path::{Path, PathBuf};

use super::clock::Jitter;
use super::error::LogError;
use super::rows::Record;
use super::source::{Format, Rows};
use super::spacing::{Records, usual_step};
use crate::scenario::{LogSettings, MOST_PLAYED};

/// A recorded log with even samples, that was found sound. What it says of itself is kept, its samples
/// are not: its size does not matter.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    path: PathBuf,
    settings: LogSettings,
    format: Format,
    /// Sample time, s.
    pub sample_time: f64,
    /// Its samples, the bridged ones among them.
    pub samples: u64,
    /// What was found out about it.
    pub found: Found,
    /// Its stretches, each without a break.
    stretches: Vec<Stretch>,
    positions: (f64, f64),
    smallest_step: f64,
    references: Vec<f64>,
}

/// What was found out about a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found {
    /// What its time stamps are off an even clock by.
    pub jitter: Jitter,
    /// Samples that straight lines stand in for.
    pub bridged: u64,
    /// Gaps that they bridge.
    pub gaps: u64,
    /// Rows in ranges of time that were left out.
    pub left_out: u64,
    /// What separates the columns of a text, by name.
    pub separator: Option<&'static str>,
    /// Whether its numbers have decimal commas.
    pub decimal_commas: bool,
    /// What the row of units says that was found below the heading.
    pub units_row: Option<String>,
}

/// A part of a log without a break.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stretch {
    /// Its first sample.
    pub(super) first: Record,
    /// Whether it is the log's first.
    begins_the_log: bool,
    /// The first two steps of the position.
    beginning: Vec<f64>,
    /// Its samples.
    pub(super) samples: u64,
}

impl Log {
    /// The fewest samples of a log: the four parameters and the motion that it begins with cannot be
    /// told from fewer.
    const FEWEST: u64 = 10;

    /// Reads a `.csv`, `.csv.gz` or `.mcap` file whose samples must be `sample_time` (s) apart; if nobody states
    /// it, whatever it is on average.
    ///
    /// # Errors
    /// The line and column that is wrong.
    pub fn read(
        path: &Path,
        settings: &LogSettings,
        sample_time: Option<f64>,
    ) -> Result<Self, LogError> {
        let format = Format::of_file(path, settings)?;
        let rows = |sample_time| Rows::open(path, settings, &format, sample_time);
        let Some(stated) = sample_time else {
            if !settings.tells_sample_time() {
                let fault = "nothing says how long a sample lasts: state log.sample_time";
                return Err(LogError::of_file(path, fault.to_owned()));
            }
            let usual = usual_step(rows(f64::NAN)?, settings)?.unwrap_or(f64::NAN);
            let (mut log, mean) = Self::judge(path, settings, &format, usual)?;
            log.sample_time = mean.unwrap_or(usual);
            return Ok(log);
        };
        let log = match Self::judge(path, settings, &format, stated) {
            Ok((log, mean)) => check_rate(path, mean, stated).map(|()| log)?,
            // A rate that is not the stated one is why time seems to be wrong.
            Err(error) => {
                let usual = usual_step(rows(stated)?, settings).ok().flatten();
                return Err(check_rate(path, usual, stated).err().unwrap_or(error));
            }
        };
        Ok(log)
    }

    /// Reads all of it; with its mean time from one sample to the next, s.
    fn judge(
        path: &Path,
        settings: &LogSettings,
        format: &Format,
        sample_time: f64,
    ) -> Result<(Self, Option<f64>), LogError> {
        let rows = Rows::open(path, settings, format, sample_time)?;
        let mut records = Records::new(path, rows, settings, sample_time);
        let mut log = Self {
            path: path.to_owned(),
            settings: settings.clone(),
            format: format.clone(),
            sample_time,
            samples: 0,
            found: Found {
                separator: format.separator_name(),
                ..Found::default()
            },
            stretches: Vec::new(),
            positions: (f64::INFINITY, f64::NEG_INFINITY),
            smallest_step: f64::INFINITY,
            references: Vec::new(),
        };
        let mut last: Option<Record> = None;
        for record in records.by_ref() {
            let record = record?;
            log.take_in(last.as_ref(), &record);
            last = Some(record);
        }
        log.found.jitter = records.jitter();
        log.found.left_out = records.rows().left_out();
        log.found.decimal_commas = records.rows().has_decimal_commas();
        log.found.units_row = records.rows().units_row().cloned();
        log.check()?;
        Ok((log, records.mean_step()))
    }

    fn take_in(&mut self, last: Option<&Record>, record: &Record) {
        const BEGINNING: usize = 2;
        self.samples += 1;
        self.found.bridged += u64::from(record.bridged);
        let was_bridged = last.is_some_and(|last| last.bridged);
        self.found.gaps += u64::from(record.bridged && !was_bridged);
        let (low, high) = self.positions;
        self.positions = (low.min(record.position), high.max(record.position));
        if self.references.len() < MOST_PLAYED {
            self.references.extend(record.reference);
        }
        match (last, self.stretches.last_mut()) {
            (Some(last), Some(stretch)) if !record.begins => {
                let step = record.position - last.position;
                stretch.samples += 1;
                if stretch.beginning.len() < BEGINNING {
                    stretch.beginning.push(step);
                }
                if step.abs() > 0.0 {
                    self.smallest_step = self.smallest_step.min(step.abs());
                }
            }
            _ => self.stretches.push(Stretch {
                first: *record,
                begins_the_log: self.stretches.is_empty(),
                beginning: Vec::new(),
                samples: 1,
            }),
        }
    }

    /// Whether there is anything to be learnt from it.
    fn check(&self) -> Result<(), LogError> {
        let (samples, left_out) = (self.samples, self.found.left_out);
        if samples < Self::FEWEST {
            let cut = match left_out {
                0 => String::new(),
                rows => format!(", as log.cut leaves {rows} rows out"),
            };
            let fault = format!(
                "the log has {samples} samples{cut}: it must have {} or more",
                Self::FEWEST
            );
            return Err(LogError::of_file(&self.path, fault));
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
        Err(LogError::of_line(&self.path, line, Some(&column), fault))
    }

    /// Its samples from the first, read again.
    ///
    /// # Errors
    /// If the file can no longer be read; whatever is wrong with a row, if it is no longer what it was.
    pub fn records(&self) -> Result<impl Iterator<Item = Result<Record, LogError>> + '_, LogError> {
        let Self {
            path,
            settings,
            format,
            sample_time,
            ..
        } = self;
        let rows = Rows::open(path, settings, format, *sample_time)?;
        Ok(Records::new(path, rows, settings, *sample_time))
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
    pub fn first(&self) -> &Record {
        &self.stretches[0].first
    }

    /// Its stretches, one or more.
    pub(super) fn stretches(&self) -> &[Stretch] {
        &self.stretches
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
        const FINEST: f64 = 1.0 / 8_388_608.0;
        let (low, high) = self.positions;
        let smallest = self.smallest_step.max(FINEST * (high - low));
        smallest.clamp(1e-12, 1.0)
    }
}

/// Whether the mean time from one sample to the next, s, is the one that is stated.
fn check_rate(path: &Path, mean: Option<f64>, stated: f64) -> Result<(), LogError> {
    /// How far it may be off, relative.
    const ALIKE: f64 = 0.01;
    match mean {
        Some(mean) if (mean / stated - 1.0).abs() > ALIKE => {
            let fault = format!(
                "its samples are {mean:.6e} s apart, where controller.sample_time or log.sample_time \
                 is {stated} s: they must agree to {} %; look at log.time_unit, too",
                100.0 * ALIKE
            );
            Err(LogError::of_file(path, fault))
        }
        _ => Ok(()),
    }
}

impl AsRef<[Self]> for Log {
    /// One log, where there may be several.
    fn as_ref(&self) -> &[Self] {
        std::slice::from_ref(self)
    }
}

impl Stretch {
    /// Whether the servo stands at the first sample, to a resolution of the position.
    ///
    /// It does if the first step shows no motion, or if it is the beginning of one: under a held
    /// command, steps from rest are as 1 to 3, and steps at a velocity v are v + 1 to v + 3. So
    /// 3Δ₁ − Δ₂ is twice the velocity at the first sample; it counts as none where rounding (at most
    /// half a resolution for each of three positions) or a command that changed meanwhile explains it.
    /// Behind a break a servo is taken to be in motion, as it mostly is: slow ones cannot be told.
    pub(super) fn begins_at_rest(&self, resolution: f64) -> bool {
        const ROUNDED: f64 = 4.0;
        const CHANGED: f64 = 0.5;
        if !self.begins_the_log {
            return false;
        }
        match self.beginning[..] {
            [first, ..] if first.abs() <= 1.5 * resolution => true,
            [first, second] => {
                let twice_the_velocity = 3.0 * first - second;
                twice_the_velocity.abs() <= ROUNDED * resolution + CHANGED * second.abs()
            }
            _ => false,
        }
    }
}
