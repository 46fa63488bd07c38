//! Reading a log and judging it: columns, numbers, time.

use std::fmt;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use crate::scenario::LogSettings;

/// How far a step of time may be from the sample time and count as one, relative.
const JITTER: f64 = 0.01;

/// A recorded log with uniform time.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// The samples.
    pub records: Vec<Record>,
    /// Sample time, s.
    pub sample_time: f64,
    /// Samples that straight lines stand in for.
    pub bridged: u64,
}

/// One sample of a log, in the log's units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// The line of the file, from 1, the heading among them; of a bridged sample, the line after
    /// the gap.
    pub line: u64,
    /// Time, s.
    pub time: f64,
    /// Reference position, where the log has one.
    pub reference: Option<f64>,
    /// Measured position.
    pub position: f64,
    /// The command that acted from here to the next sample, where the log has one.
    pub command: Option<f64>,
    /// Known signal behind the controller; zero where the log has none.
    pub injection: f64,
    /// Whether a straight line stands in for what was not recorded.
    pub bridged: bool,
}

/// What is wrong with a log, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct LogError {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: Option<u64>,
    /// The column.
    pub column: Option<String>,
    /// What is wrong, what is allowed, what to do.
    pub fault: String,
}

impl fmt::Display for LogError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ": column {column}")?;
        }
        write!(f, ": {}", self.fault)
    }
}

impl std::error::Error for LogError {}

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
        let name = path.display().to_string();
        let unreadable = |error: std::io::Error| LogError {
            file: name.clone(),
            line: None,
            column: None,
            fault: format!("the log cannot be read: {error}"),
        };
        let file = BufReader::new(File::open(path).map_err(unreadable)?);
        let packed = path.extension().is_some_and(|end| end == "gz");
        if packed {
            Self::parse(&name, MultiGzDecoder::new(file), settings, sample_time)
        } else {
            Self::parse(&name, file, settings, sample_time)
        }
    }

    /// Reads a log from text; `name` stands for the file in errors.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn parse(
        name: &str,
        text: impl Read,
        settings: &LogSettings,
        sample_time: Option<f64>,
    ) -> Result<Self, LogError> {
        let fault = |line: Option<u64>, column: Option<&str>, fault: String| LogError {
            file: name.to_owned(),
            line,
            column: column.map(str::to_owned),
            fault,
        };
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(text);
        let heading = reader
            .headers()
            .map_err(|error| fault(Some(1), None, format!("no heading can be read: {error}")))?
            .clone();
        let place = |column: &str| {
            heading
                .iter()
                .position(|name| name == column)
                .ok_or_else(|| {
                    let known = heading.iter().collect::<Vec<_>>().join(", ");
                    fault(
                        Some(1),
                        Some(column),
                        format!("the log has no such column, but {known}"),
                    )
                })
        };
        let columns = Columns {
            time: (place(&settings.time)?, &settings.time),
            reference: optional(&settings.reference, place)?,
            position: (place(&settings.position)?, &settings.position),
            command: optional(&settings.command, place)?,
            injection: optional(&settings.injection, place)?,
        };

        let mut records = Vec::new();
        for row in reader.records() {
            let row = row.map_err(|error| {
                let line = error.position().map(csv::Position::line);
                fault(line, None, format!("the row cannot be read: {error}"))
            })?;
            let line = row.position().map_or(0, csv::Position::line);
            let number = |(index, column): (usize, &str)| {
                let text = row.get(index).unwrap_or("");
                match text.parse::<f64>() {
                    Ok(value) if value.is_finite() => Ok(value),
                    _ => Err(fault(
                        Some(line),
                        Some(column),
                        format!("\"{text}\" is not allowed: it must be any finite number"),
                    )),
                }
            };
            records.push(Record {
                line,
                time: number(columns.time)?,
                reference: columns.reference.map(number).transpose()?,
                position: number(columns.position)?,
                command: columns.command.map(number).transpose()?,
                injection: columns.injection.map_or(Ok(0.0), number)?,
                bridged: false,
            });
        }
        if records.len() < 2 {
            return Err(fault(
                None,
                None,
                format!(
                    "the log has {} samples: it must have two or more",
                    records.len()
                ),
            ));
        }
        let mut log = Self {
            sample_time: sample_time.unwrap_or_else(|| usual_step(&records)),
            records: Vec::with_capacity(records.len()),
            bridged: 0,
        };
        for record in records {
            log.append(record, settings.bridge)
                .map_err(|text| fault(Some(record.line), Some(&settings.time), text))?;
        }
        Ok(log)
    }

    /// Adds a record if its time is the next, bridging a short gap where that is allowed.
    fn append(&mut self, record: Record, bridge: u32) -> Result<(), String> {
        let sample_time = self.sample_time;
        let Some(last) = self.records.last().copied() else {
            self.records.push(record);
            return Ok(());
        };
        let step = record.time - last.time;
        let steps = step / sample_time;
        let whole = steps.round();
        if step <= 0.0 {
            return Err(format!(
                "time goes from {} to {} s: it must advance by the sample time, {sample_time} s",
                last.time, record.time
            ));
        }
        if (steps - whole).abs() > JITTER * whole.max(1.0) || whole < 1.0 {
            return Err(format!(
                "time advances by {step:.9} s: it must advance by the sample time, {sample_time} s, \
                 to {} %",
                100.0 * JITTER
            ));
        }
        let missing = whole - 1.0;
        if missing > f64::from(bridge) {
            return Err(format!(
                "{missing} samples are missing before {} s: at most {bridge} may be bridged (set \
                 log.bridge_gaps to allow more)",
                record.time
            ));
        }
        let missing = missing as u32;
        for k in 1..=missing {
            let part = f64::from(k) / f64::from(missing + 1);
            let between = |from: f64, to: f64| from + part * (to - from);
            let both = |from: Option<f64>, to: Option<f64>| Some(between(from?, to?));
            self.records.push(Record {
                line: record.line,
                time: between(last.time, record.time),
                reference: both(last.reference, record.reference),
                position: between(last.position, record.position),
                command: both(last.command, record.command),
                injection: between(last.injection, record.injection),
                bridged: true,
            });
        }
        self.bridged += u64::from(missing);
        self.records.push(record);
        Ok(())
    }

    /// The resolution of the recorded positions: their smallest change, and no finer than 2⁻²³ of
    /// the range they cover.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        const FINEST: f64 = 1.0 / 8_388_608.0;
        let positions = || self.records.iter().map(|record| record.position);
        let (low, high) = positions().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| {
            (low.min(q), high.max(q))
        });
        let smallest = positions()
            .zip(positions().skip(1))
            .map(|(before, after)| (after - before).abs())
            .filter(|step| *step > 0.0)
            .fold(f64::INFINITY, f64::min);
        smallest.max(FINEST * (high - low)).clamp(1e-12, 1.0)
    }
}

/// The middle one of the steps of time, s, made exact over the whole length.
fn usual_step(records: &[Record]) -> f64 {
    let mut steps: Vec<f64> = records
        .windows(2)
        .map(|pair| pair[1].time - pair[0].time)
        .collect();
    steps.sort_by(f64::total_cmp);
    let middle = steps[steps.len() / 2];
    let whole = records[records.len() - 1].time - records[0].time;
    let count = (whole / middle).round();
    if count >= 1.0 { whole / count } else { middle }
}

/// Where the columns stand, with their names.
struct Columns<'a> {
    time: (usize, &'a str),
    reference: Option<(usize, &'a str)>,
    position: (usize, &'a str),
    command: Option<(usize, &'a str)>,
    injection: Option<(usize, &'a str)>,
}

fn optional(
    name: &Option<String>,
    place: impl Fn(&str) -> Result<usize, LogError>,
) -> Result<Option<(usize, &str)>, LogError> {
    name.as_deref()
        .map(|name| Ok((place(name)?, name)))
        .transpose()
}
