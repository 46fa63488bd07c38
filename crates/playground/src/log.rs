//! The servo of a log.

use std::io::Cursor;
use std::path::Path;

use host_sim::scenario::{Estimator, Fault, Purpose, Scenario};
use identifier_log::log::{Log, Table};
use identifier_log::recognise::{LogOptions, Recognised, Unrecognised, recognise};
use identifier_log::result::Summary;
use identifier_log::tune::Tuned;

/// Why a log was not identified, and the columns of which others may be chosen; none of a log that cannot be read.
#[derive(Debug, Clone)]
pub struct Refusal {
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

/// The scenario of a log, as [`Recognised::scenario`] writes it.
///
/// # Errors
/// The key that is not allowed.
pub fn scenario(recognised: &Recognised) -> Result<Scenario, Fault> {
    /// That of a scenario that states none, s; a log has its own.
    const DURATION: f64 = 60.0;
    let mut scenario = Scenario::blank();
    scenario.duration = DURATION;
    scenario.counts_per_rev = recognised.counts_per_rev;
    scenario.inner = recognised.inner;
    scenario.identifier.set_estimator(Estimator::Fit);
    let mut settings = recognised.settings.clone();
    // The encoder's, which the scenario has.
    settings.units.counts_per_rev = None;
    scenario.log = Some(settings);
    scenario.checked(Purpose::Replay)
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
pub fn identify(bytes: Vec<u8>, stated: &LogOptions) -> Result<Identified, Refusal> {
    let table = Table::of_text(Path::new("the log"), Cursor::new(bytes));
    let table = table.map_err(|error| Refusal {
        text: error.to_string(),
        columns: Vec::new(),
    })?;
    let columns = columns(&table);
    let refused = |text| Refusal {
        text,
        columns: columns.clone(),
    };
    let (recognised, log, found) = read(&table, stated).map_err(refused)?;
    let mut rows = Vec::new();
    let found = host_sim::identify(found, std::slice::from_ref(&log), &mut |sample| {
        rows.push([sample.time, sample.position, f64::NAN]);
    });
    let host_sim::Identified {
        scenario,
        summary,
        seen,
        ..
    } = found.map_err(|error| refused(error.to_string()))?;
    for (row, error) in rows
        .iter_mut()
        .zip(seen.iter().flat_map(|seen| &seen.errors))
    {
        row[2] = *error;
    }
    let tuned = Tuned::stiffest(&scenario, &summary).map(|(tuned, _)| tuned);
    Ok(Identified {
        columns,
        recognised,
        sample_time: log.sample_time,
        samples: log.samples,
        rows,
        window: seen.map(|seen| seen.window),
        summary,
        tuned,
    })
}

/// How a log is taken, its samples and the scenario of its identification.
fn read(table: &Table, stated: &LogOptions) -> Result<(Recognised, Log, Scenario), String> {
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
    let scenario = scenario(&recognised).map_err(|fault| fault.to_string())?;
    let log = Log::new(table, &scenario.log_columns(), scenario.log_sample_time());
    let log = log.map_err(|error| error.to_string())?;
    Ok((recognised, log, scenario))
}
