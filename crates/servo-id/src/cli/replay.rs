use std::path::{Path, PathBuf};

use host_sim::FoundServo;
use host_sim::analysis::Status;
use host_sim::predict;
use host_sim::provenance::{LogFile, Origin, ScenarioText, Task};
use host_sim::replay;
use host_sim::result::{LogReading, Prediction, ReplayNotes};
use host_sim::scenario::{Purpose, Scenario};
use identifier_log::log::{Log, Table};

use super::call;
use super::fault::Fault;
use super::output::Outputs;
use super::recording::Recording;
use super::standard_output::show;
use crate::VERSION;

/// A replay.
#[derive(Debug)]
pub(super) struct Replay<'a> {
    pub(super) scenario: &'a ScenarioText,
    pub(super) logs: Vec<Table>,
    pub(super) predict: Vec<Table>,
    pub(super) passes: u32,
    /// The text that is shown before, and where the scenario is saved.
    pub(super) introduction: Option<&'a Introduction<'a>>,
}

/// The introduction to a replay whose scenario is not the user's.
#[derive(Debug)]
pub(super) struct Introduction<'a> {
    /// How the log is taken.
    pub(super) text: String,
    /// The file of the scenario.
    pub(super) save_scenario: Option<&'a Path>,
}

impl Replay<'_> {
    /// Replays it and returns the verdict. Besides the logs this reads `input`.
    pub(super) fn experiment(self, outputs: &Outputs, input: &Path) -> Result<Status, Fault> {
        let text = self.scenario;
        let of_replay = |error| Fault::of_file(Path::new(&text.file), error);
        let scenario = text.scenario(Purpose::Replay)?;
        let read = self.logs.iter().chain(&self.predict);
        let read: Vec<PathBuf> = read.map(|table| table.path.clone()).collect();
        let inputs: Vec<&Path> = read.iter().map(PathBuf::as_path).chain([input]).collect();
        let title = call::title(
            "Identification of",
            inputs.first().copied().unwrap_or(input),
        );
        let task = Task::Replay {
            passes: self.passes,
            logs: LogFile::of_tables(&self.logs),
            predict: LogFile::of_tables(&self.predict),
        };
        let origin = Origin::new(VERSION, task, text, &scenario);
        let Self {
            logs,
            predict,
            passes,
            introduction,
            ..
        } = self;
        let mut results = outputs.begin(&inputs, origin)?;
        if let Some(introduction) = introduction {
            results.save_scenario(introduction.save_scenario, &text.text)?;
            if !results.own_standard_output() {
                show!("{}", introduction.text)?;
            }
        }
        let count = logs.len();
        let all = read_all(logs.into_iter().chain(predict), &scenario)?;
        let (learnt, predicted) = all.split_at(count);
        let scenario = replay::fitted(scenario, learnt);
        let mut readings: Vec<LogReading> = learnt.iter().map(LogReading::new).collect();
        let predicted_only = predicted.iter().filter(|log| !is_among(learnt, log));
        readings.extend(predicted_only.map(LogReading::new));

        let length: f64 = learnt.iter().map(Log::duration).sum();
        let duration = f64::from(passes) * length;
        let mut recording = Recording::new(title, &scenario, duration, passes, &mut results);
        let mut pass_shown = 0;
        let replayed = replay::replay(&scenario, learnt, passes, &mut |pass, sample| {
            if pass != pass_shown {
                recording.begin_pass();
                pass_shown = pass;
            }
            recording.add(sample);
        })
        .map_err(of_replay)?;
        let mut predictions = Vec::new();
        let is_known = replayed.outcome.abort.is_none() && !predicted.is_empty();
        let found = if !is_known {
            None
        } else if scenario.identifier.law.takes_whole_record() {
            recording.fit_record()
        } else {
            let terms = &replayed.outcome.terms;
            Some(FoundServo::of_estimates(
                &scenario,
                &replayed.estimates,
                terms,
            ))
        };
        if let Some(found) = found {
            for log in predicted {
                let seen = is_among(learnt, log);
                let predicted = predict::predict(&scenario, &found, log).map_err(of_replay)?;
                if let Some(open_loop) = predicted.open_loop.as_ref().filter(|_| !seen) {
                    recording.predicted(open_loop.relative);
                }
                predictions.push(Prediction::new(log, seen, &predicted));
            }
        }
        let notes = ReplayNotes {
            agreement: replayed.agreement,
            logs: readings,
            predictions,
        };
        recording.conclude(results, replayed.outcome, notes)
    }
}

/// Reads files of logs.
pub(super) fn tables(paths: &[PathBuf]) -> Result<Vec<Table>, Fault> {
    let read = paths.iter().map(|path| Table::read(path));
    read.collect::<Result<_, _>>()
        .map_err(|error| Fault::Input(error.to_string()))
}

/// Logs that must have one sample time, of tables that are not needed any more.
fn read_all(tables: impl Iterator<Item = Table>, scenario: &Scenario) -> Result<Vec<Log>, Fault> {
    /// Largest relative difference of sample times.
    const TOLERANCE: f64 = 0.01;
    let mut logs: Vec<Log> = Vec::new();
    for table in tables {
        let log = Log::new(&table, &scenario.log_columns(), scenario.log_sample_time())
            .map_err(|error| Fault::Input(error.to_string()))?;
        if let Some(first) = logs.first()
            && (log.sample_time / first.sample_time - 1.0).abs() > TOLERANCE
        {
            return Err(Fault::Input(format!(
                "{}: its sample time is {} s, that of {} is {} s: logs that are replayed together must have the same \
                 sample time; replay them one by one",
                log.path().display(),
                log.sample_time,
                first.path().display(),
                first.sample_time
            )));
        }
        logs.push(log);
    }
    Ok(logs)
}

fn is_among(logs: &[Log], log: &Log) -> bool {
    let mut others = logs.iter().map(Log::path);
    others.any(|other| is_same(other, log.path()))
}

fn is_same(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => one == other,
    }
}
