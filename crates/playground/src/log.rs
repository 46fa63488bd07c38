//! The servo of a log.

use std::io::Cursor;
use std::path::Path;

use identifier_log::experiment::Sample;
use identifier_log::log::{Log, Table};
use identifier_log::recognise::{LogOptions, Recognised, Unrecognised, recognise};
use identifier_log::result::Summary;
use identifier_log::scenario::Options;
use identifier_log::tune::Tuned;

/// Why a log was not identified, and the columns of which others may be chosen; none of a log that cannot be read.
#[derive(Debug, Clone)]
pub struct LogRefusal {
    /// A line each; questions begin with a question mark.
    pub text: String,
    /// The names of its columns.
    pub columns: Vec<String>,
}

/// A log that was identified.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The names of its columns.
    pub columns: Vec<String>,
    /// How it was taken.
    pub recognised: Recognised,
    /// Its samples' time, s, and how many there are.
    pub sample_time: f64,
    /// Samples.
    pub samples: u64,
    /// For every sample: time, s, position, rad, and residual of an open-loop simulation in windows, rad. NaN if
    /// unknown.
    pub rows: Vec<[f64; 3]>,
    /// Length of a window, s.
    pub window: Option<f64>,
    /// The result.
    pub summary: Summary,
    /// Gains for it under the largest command of the log, or why there are none.
    pub tuned: Result<Tuned, String>,
}

/// The columns as an option takes them: by name where it is one column's, or by number.
fn columns(table: &Table) -> Vec<String> {
    let all = &table.columns;
    let name = |(place, name): (usize, &String)| {
        let is_own = table.has_heading && all.iter().filter(|of| of.name == *name).count() == 1;
        if is_own && !name.is_empty() {
            name.clone()
        } else {
            (place + 1).to_string()
        }
    };
    all.iter()
        .map(|column| &column.name)
        .enumerate()
        .map(name)
        .collect()
}

/// Identifies a log of some bytes.
///
/// # Errors
/// Why it cannot be, with the columns that may be chosen.
pub fn identify(bytes: Vec<u8>, stated: &LogOptions) -> Result<Identified, LogRefusal> {
    let table = Table::of_text(Path::new("the log"), Cursor::new(bytes));
    let table = table.map_err(|error| LogRefusal {
        text: error.to_string(),
        columns: Vec::new(),
    })?;
    let columns = columns(&table);
    let refused = |text| LogRefusal {
        text,
        columns: columns.clone(),
    };
    let (recognised, log, options) = read(&table, stated).map_err(refused)?;
    let found = identifier_log::identify(std::slice::from_ref(&log), &[], &options, &|| true);
    let found = found.map_err(|error| refused(error.to_string()))?;
    let residual = |sample: Sample| sample.output_error.unwrap_or(f64::NAN);
    let rows = found
        .samples()
        .map(|sample| [sample.time, sample.position, residual(sample)])
        .collect();
    let tuned = Tuned::stiffest(&found.options, &found.summary).map(|(tuned, _)| tuned);
    Ok(Identified {
        columns,
        recognised,
        sample_time: log.sample_time,
        samples: log.samples,
        rows,
        window: (found.seen.and_then(|seen| seen.free_run)).map(|ran| ran.window),
        summary: found.summary,
        tuned,
    })
}

/// How a log is taken, its samples and the options of its identification.
fn read(table: &Table, stated: &LogOptions) -> Result<(Recognised, Log, Options), String> {
    let recognised = recognise(table, stated).map_err(|error| match error {
        Unrecognised::Log(error) => error.to_string(),
        Unrecognised::Unknown(questions) => {
            let lines = questions.iter();
            let lines: Vec<_> = lines
                .map(|one| format!("?{}\t{}", one.flag, one.text))
                .collect();
            lines.join("\n")
        }
    })?;
    let options = recognised.options().map_err(|fault| fault.to_string())?;
    let log = Log::new(table, &options.log_columns(), options.log_sample_time());
    let log = log.map_err(|error| error.to_string())?;
    Ok((recognised, log, options))
}
