//! Identification from logs, of files and of columns in memory.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use host_sim::log::{Log, Table};
use host_sim::provenance::{LogFile, Task};
use host_sim::recognise::{Recognised, Stated, Unrecognised, recognise};
use host_sim::scenario::Purpose;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::columns::{self, Buffers, Trace};
use crate::fault::value_error;
use crate::origin::Read;

/// The scenario of a log that has none: columns, units, sample time and encoder as they are found or `stated`, and the
/// findings, each with its evidence.
///
/// # Errors
/// `ValueError`: a log that cannot be read, or what it does not show, with the keyword that states it.
#[pyfunction]
pub(crate) fn recognise_log(
    py: Python<'_>,
    log: PathBuf,
    stated: BTreeMap<String, String>,
) -> PyResult<(String, Vec<(&'static str, String)>)> {
    py.detach(|| {
        let recognised = recognised(&log, &stated)?;
        let text = recognised.scenario(&log.display().to_string());
        let findings = recognised.findings.into_iter();
        Ok((text, findings.map(|one| (one.about, one.text)).collect()))
    })
}

/// Identifies from a file with the scenario of a `text`; the result as JSON, and its trace.
///
/// # Errors
/// `ValueError`: the key of the scenario, or the line and column of the log.
#[pyfunction]
#[pyo3(signature = (file, text, log, *, trace))]
pub(crate) fn identify_file<'py>(
    py: Python<'py>,
    file: &str,
    text: &str,
    log: PathBuf,
    trace: bool,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let (json, trace) = py.detach(|| {
        let read = Read::new(file, text, Purpose::Replay)?;
        let opened = opened(&read, &log)?;
        let of_file = LogFile::read(&log).map_err(value_error)?;
        identified(read, &opened, vec![of_file], trace)
    })?;
    Ok((json, trace.into_python(py)?))
}

/// As [`identify_file`], from columns in memory, which `[log]` of the scenario names.
///
/// # Errors
/// `ValueError`: the key of the scenario, or the column.
#[pyfunction]
#[pyo3(signature = (file, text, log, *, trace))]
pub(crate) fn identify_columns<'py>(
    py: Python<'py>,
    file: &str,
    text: &str,
    log: Buffers,
    trace: bool,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let columns = columns::read(py, log)?;
    let (json, trace) = py.detach(|| {
        let read = Read::new(file, text, Purpose::Replay)?;
        let (settings, sample_time) =
            (read.scenario.log_columns(), read.scenario.log_sample_time());
        let log = Log::new(&columns, &settings, sample_time);
        identified(read, &log.map_err(value_error)?, Vec::new(), trace)
    })?;
    Ok((json, trace.into_python(py)?))
}

/// The samples of a log in SI, as they are identified from: time, position, and command and reference where it has them.
///
/// # Errors
/// As [`recognise_log`] and [`identify_file`].
#[pyfunction]
pub(crate) fn read_log<'py>(
    py: Python<'py>,
    file: &str,
    text: &str,
    log: PathBuf,
) -> PyResult<Bound<'py, PyDict>> {
    let (time, position, command, reference) = py.detach(|| {
        let read = Read::new(file, text, Purpose::Replay)?;
        let log = opened(&read, &log)?;
        let (mut time, mut position) = (Vec::new(), Vec::new());
        let (mut command, mut reference) = (Vec::new(), Vec::new());
        for row in log.rows() {
            time.push(row.time);
            position.push(row.position);
            command.extend(row.command);
            reference.extend(row.reference);
        }
        PyResult::Ok((time, position, command, reference))
    })?;
    let all = [
        ("time", time),
        ("position", position),
        ("command", command),
        ("reference", reference),
    ];
    columns::by_name(py, all.into_iter().filter(|(_, column)| !column.is_empty()))
}

/// The log of a file, read as a scenario has it.
fn opened(read: &Read, log: &Path) -> PyResult<Log> {
    let scenario = &read.scenario;
    let opened = Log::read(log, &scenario.log_columns(), scenario.log_sample_time());
    opened.map_err(value_error)
}

/// Identifies from a log; the result as JSON, and its trace if it `is_wanted`.
fn identified(
    read: Read,
    log: &Log,
    files: Vec<LogFile>,
    is_wanted: bool,
) -> PyResult<(String, Trace)> {
    let mut trace = Trace::new(is_wanted);
    let found = host_sim::identify(
        read.scenario.clone(),
        std::slice::from_ref(log),
        &mut |sample| {
            trace.add(sample);
        },
    );
    let host_sim::Identified { summary, seen, .. } = found.map_err(|fault| read.fault(fault))?;
    if let Some(seen) = seen {
        trace.leaves(seen.errors);
    }
    let task = Task::Replay {
        passes: 1,
        logs: files,
        predict: Vec::new(),
    };
    Ok((read.json(task, &summary)?, trace))
}

fn recognised(log: &Path, options: &BTreeMap<String, String>) -> PyResult<Recognised> {
    let mut stated = Stated::default();
    for (keyword, value) in options {
        let answered = stated.answer(&keyword.replace('_', "-"), value);
        answered.map_err(|allowed| value_error(format!("{keyword} = {value}: {allowed}")))?;
    }
    let table = Table::read(log).map_err(value_error)?;
    recognise(&table, &stated).map_err(|error| match error {
        Unrecognised::Log(error) => value_error(error),
        Unrecognised::Unknown(questions) => {
            let missing =
                |flag: &str, text: &str| format!("{}: --{flag} is missing: {text}", log.display());
            let all: Vec<_> = (questions.iter())
                .map(|question| missing(question.flag, &question.text))
                .collect();
            value_error(all.join("\n"))
        }
    })
}
