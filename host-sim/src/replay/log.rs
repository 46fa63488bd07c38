//! A recorded log: read once to be judged, and again, row by row, whenever it is needed.

use std::path::{Path, PathBuf};

use super::rows::{LogError, Record, Rows};
use super::spacing::{Records, usual_step};
use crate::scenario::{LogSettings, MOST_PLAYED};

/// A recorded log with uniform time, that was found sound. What it says of itself is kept, its samples
/// are not: its size does not matter.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    path: PathBuf,
    settings: LogSettings,
    /// Sample time, s.
    pub sample_time: f64,
    /// Its samples, the bridged ones among them.
    pub samples: u64,
    /// Samples that straight lines stand in for.
    pub bridged: u64,
    first: Record,
    /// The first two steps of the position.
    beginning: Vec<f64>,
    positions: (f64, f64),
    smallest_step: f64,
    references: Vec<f64>,
}

impl Log {
    /// Reads a `.csv` or `.csv.gz` file whose time must advance by `sample_time` (s); if nobody states
    /// it, evenly.
    ///
    /// # Errors
    /// The line and column that is wrong.
    pub fn read(
        path: &Path,
        settings: &LogSettings,
        sample_time: Option<f64>,
    ) -> Result<Self, LogError> {
        let rows = || Rows::open(path, settings);
        let too_short = |samples: u64| {
            let fault = format!("the log has {samples} samples: it must have two or more");
            LogError::of_file(path, fault)
        };
        let sample_time = match sample_time {
            Some(sample_time) => sample_time,
            None => usual_step(rows()?)?.unwrap_or(f64::NAN),
        };
        let mut records = records(path, settings, sample_time)?;
        let first = records.next().ok_or_else(|| too_short(0))??;
        let mut log = Self {
            path: path.to_owned(),
            settings: settings.clone(),
            sample_time,
            samples: 1,
            bridged: 0,
            first,
            beginning: Vec::new(),
            positions: (first.position, first.position),
            smallest_step: f64::INFINITY,
            references: first.reference.into_iter().collect(),
        };
        let mut last = first;
        for record in records {
            let record = record?;
            log.take_in(&last, &record);
            last = record;
        }
        if log.samples < 2 {
            return Err(too_short(log.samples));
        }
        Ok(log)
    }

    fn take_in(&mut self, last: &Record, record: &Record) {
        const BEGINNING: usize = 2;
        self.samples += 1;
        self.bridged += u64::from(record.bridged);
        let step = record.position - last.position;
        if self.beginning.len() < BEGINNING {
            self.beginning.push(step);
        }
        let (low, high) = self.positions;
        self.positions = (low.min(record.position), high.max(record.position));
        if step.abs() > 0.0 {
            self.smallest_step = self.smallest_step.min(step.abs());
        }
        if self.references.len() < MOST_PLAYED {
            self.references.extend(record.reference);
        }
    }

    /// Its samples from the first, read again.
    ///
    /// # Errors
    /// If the file can no longer be read; whatever is wrong with a row, if it is no longer what it was.
    pub fn records(&self) -> Result<impl Iterator<Item = Result<Record, LogError>> + '_, LogError> {
        records(&self.path, &self.settings, self.sample_time)
    }

    /// The first sample.
    #[must_use]
    pub fn first(&self) -> &Record {
        &self.first
    }

    /// Its length, s.
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

    /// Whether the servo stands at the first sample, to a resolution of the position.
    ///
    /// It does if the first step shows no motion, or if it is the beginning of one: under a held
    /// command, steps from rest are as 1 to 3, and steps at a velocity v are v + 1 to v + 3. So
    /// 3Δ₁ − Δ₂ is twice the velocity at the first sample; it counts as none where rounding (at most
    /// half a resolution for each of three positions) or a command that changed meanwhile explains it.
    #[must_use]
    pub fn begins_at_rest(&self, resolution: f64) -> bool {
        const ROUNDED: f64 = 4.0;
        const CHANGED: f64 = 0.5;
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

fn records<'a>(
    path: &'a Path,
    settings: &'a LogSettings,
    sample_time: f64,
) -> Result<Records<'a>, LogError> {
    let rows = Rows::open(path, settings)?;
    Ok(Records::new(
        path,
        rows,
        &settings.time,
        sample_time,
        settings.bridge,
    ))
}
