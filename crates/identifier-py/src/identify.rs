//! Identification from logs, of files and of columns in memory.

use std::collections::BTreeMap;

use host_sim::identify_logs;
use host_sim::scenario::{Options, Purpose, Scenario};
use identifier_log::log::{Log, Table};
use identifier_log::provenance::{LogFile, Task};
use identifier_log::recognise::{LogOptions, Recognised, Unrecognised, recognise};
use identifier_log::result::{KeptResult, Reading};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use servo_id::present::{self, Experiment};
use servo_id::render::terminal;

use crate::columns::{self, Source};
use crate::fault::value_error;
use crate::origin::Read;
use crate::picture::picture;

/// The scenario of logs that have none: found or `stated` columns, units, sample time and encoder. Then how the columns
/// are read, as JSON, and the findings, each with its evidence.
///
/// # Errors
/// `ValueError`: a log that cannot be read, or what it does not show, with the keyword that states it.
#[pyfunction]
pub(crate) fn recognise_log(
    py: Python<'_>,
    logs: Vec<Source>,
    stated: BTreeMap<String, String>,
) -> PyResult<(String, String, Vec<(&'static str, String)>)> {
    let tables = Source::tables(logs, py)?;
    py.detach(|| {
        let table = Table::joined(&tables).map_err(value_error)?;
        let recognised = recognised(&table, &stated)?;
        let text = recognised.scenario(&table.path.display().to_string());
        let reading = serde_json::to_string(&recognised.reading).map_err(value_error)?;
        let findings = recognised.findings.into_iter();
        let findings = findings.map(|one| (one.about, one.text));
        let findings = findings.chain(unchanging(&table).map(|text| ("unchanging", text)));
        Ok((text, reading, findings.collect()))
    })
}

/// A result as JSON, its trace, its picture and the numbers of its servo.
type Identified<'py> = (
    String,
    Bound<'py, PyDict>,
    String,
    Option<Bound<'py, PyBytes>>,
);

/// Identifies from logs with the scenario of a `text`, whose columns were found as `reading` has it, if they were found.
///
/// # Errors
/// `ValueError`: the key of the scenario, or the line and column of the log.
#[pyfunction]
#[pyo3(signature = (file, text, logs, reading, *, trace))]
pub(crate) fn identify_log<'py>(
    py: Python<'py>,
    file: &str,
    text: &str,
    logs: Vec<Source>,
    reading: Option<&str>,
    trace: bool,
) -> PyResult<Identified<'py>> {
    let tables = Source::tables(logs, py)?;
    let (json, samples, picture, servo) = py.detach(|| {
        let mut read = Read::new(file, text, Purpose::Replay)?;
        let reading = reading.map(serde_json::from_str).transpose();
        read.scenario.reading = reading.map_err(value_error)?;
        let logs = all_opened(&read.scenario, &tables)?;
        let mut samples = Vec::new();
        let observe = &mut |_, sample: &_| samples.extend(trace.then_some(*sample));
        let found = identify_logs(read.scenario.clone(), &logs, &[], 1, &|| true, observe);
        let found = found.map_err(|fault| read.fault(fault))?;
        let picture = picture(&found, &samples);
        let task = Task::Replay {
            passes: 1,
            logs: LogFile::of_tables(&tables),
            predict: Vec::new(),
        };
        PyResult::Ok((
            read.json(task, &found.summary)?,
            samples,
            picture,
            found.servo,
        ))
    })?;
    let servo = servo.map(|servo| columns::bytes(py, &servo.numbers()));
    Ok((json, columns::of_samples(py, &samples)?, picture, servo))
}

/// The page that the program `servo-id` prints of a log without a scenario, in at most `width` characters a line of a table.
///
/// # Errors
/// As [`recognise_log`] and [`identify_log`].
#[pyfunction]
pub(crate) fn page(
    py: Python<'_>,
    logs: Vec<Source>,
    stated: BTreeMap<String, String>,
    width: u16,
) -> PyResult<String> {
    let tables = Source::tables(logs, py)?;
    py.detach(|| {
        let table = Table::joined(&tables).map_err(value_error)?;
        let recognised = recognised(&table, &stated)?;
        let name = table.path.display().to_string();
        let options = recognised.options().and_then(Options::in_range);
        let scenario = Scenario::from(options.map_err(value_error)?);
        let logs = all_opened(&scenario, &tables)?;
        let found = identify_logs(scenario, &logs, &[], 1, &|| true, &mut |_, _| {});
        let found = found.map_err(value_error)?;
        let page = present::experiment(&Experiment {
            title: &name,
            command: "",
            scenario: &found.scenario,
            summary: &found.summary,
            traces: None,
            seen: found.seen.as_ref(),
        });
        let introduction = present::introduction(&table.path, &recognised.findings);
        let [brief, verdict] = [terminal::brief(&page, width), terminal::verdict(&page)];
        Ok([introduction, brief, verdict].join("\n"))
    })
}

/// The samples of logs in SI, as used for identification: time, position, and command and reference if present.
///
/// # Errors
/// As [`recognise_log`] and [`identify_log`].
#[pyfunction]
pub(crate) fn read_log<'py>(
    py: Python<'py>,
    file: &str,
    text: &str,
    logs: Vec<Source>,
) -> PyResult<Bound<'py, PyDict>> {
    let tables = Source::tables(logs, py)?;
    let (time, position, command, reference) = py.detach(|| {
        let read = Read::new(file, text, Purpose::Replay)?;
        let logs = all_opened(&read.scenario, &tables)?;
        let (mut time, mut position) = (Vec::new(), Vec::new());
        let (mut command, mut reference) = (Vec::new(), Vec::new());
        for row in logs.iter().flat_map(Log::rows) {
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

/// The log of a table, read as a scenario has it.
pub(crate) fn opened(scenario: &Scenario, table: &Table) -> PyResult<Log> {
    let opened = Log::new(table, &scenario.log_columns(), scenario.log_sample_time());
    opened.map_err(value_error)
}

fn all_opened(scenario: &Scenario, tables: &[Table]) -> PyResult<Vec<Log>> {
    let opened = |table| opened(scenario, table);
    tables.iter().map(opened).collect()
}

/// How the columns were read that a result's JSON is of, in lines; none without a log.
///
/// # Errors
/// `ValueError`: a text that is no result.
#[pyfunction]
pub(crate) fn reading(result: &str) -> PyResult<Vec<String>> {
    let kept = KeptResult::read(result).map_err(value_error)?;
    Ok(kept.reading.as_ref().map_or_else(Vec::new, Reading::lines))
}

fn recognised(table: &Table, options: &BTreeMap<String, String>) -> PyResult<Recognised> {
    let mut stated = LogOptions::default();
    for (keyword, value) in options {
        let answered = stated.answer(&keyword.replace('_', "-"), value);
        answered.map_err(|allowed| value_error(format!("{keyword} = {value}: {allowed}")))?;
    }
    recognise(table, &stated).map_err(|error| match error {
        Unrecognised::Log(error) => value_error(error),
        Unrecognised::Unknown(questions) => {
            let refusals = questions.iter().map(|open| open.refusal(&stated, table));
            let said = unchanging(table).map_or_else(String::new, |text| format!(" ({text})"));
            value_error(refusals.collect::<Vec<_>>().join("\n") + &said)
        }
    })
}

/// The columns without a number, or with one number alone. None if there are no such columns.
fn unchanging(table: &Table) -> Option<String> {
    let columns = table
        .columns
        .iter()
        .zip(1..)
        .filter_map(|(column, number)| {
            let mut numbers = column.values.iter().filter(|value| value.is_finite());
            let what = match numbers.next() {
                None => "is empty",
                Some(first) if numbers.all(|value| value == first) => "is constant",
                Some(_) => return None,
            };
            let name = match column.name.as_str() {
                "" => number.to_string(),
                name => name.to_owned(),
            };
            Some(format!("column {name} {what}"))
        });
    let columns: Vec<_> = columns.take(8).collect();
    (!columns.is_empty()).then(|| columns.join(", "))
}
