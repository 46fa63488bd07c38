use std::path::{Path, PathBuf};

use host_sim::identify_logs;
use host_sim::scenario::Scenario;
use identifier_log::log::{Log, Table};
use identifier_log::provenance::{LogFile, Origin, ScenarioText, Task};
use identifier_log::verdict::Status;

use super::call;
use super::fault::Fault;
use super::output::Outputs;
use super::recording::{Recording, interruptible};
use super::standard_output::show;
use crate::VERSION;

/// A replay.
#[derive(Debug)]
pub(super) struct Replay<'a> {
    pub(super) scenario: Scenario,
    /// Its text.
    pub(super) text: &'a ScenarioText,
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
        let text = self.text;
        let of_replay = |error| Fault::of_file(Path::new(&text.file), error);
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
        let origin = Origin::new(VERSION, task, text, self.scenario.noise_seed());
        let (scenario, passes) = (self.scenario, self.passes);
        let mut results = outputs.begin(&inputs, origin)?;
        if let Some(introduction) = self.introduction {
            results.save_scenario(introduction.save_scenario, &text.text)?;
            if !results.own_standard_output() {
                show!("{}", introduction.text)?;
            }
        }
        let count = self.logs.len();
        let all = read_all(self.logs.into_iter().chain(self.predict), &scenario)?;
        let (learnt, predicted) = all.split_at(count);
        let samples = u64::from(passes) * learnt.iter().map(|log| log.samples).sum::<u64>();
        let mut recording = Recording::new(title, &scenario, samples, Some(passes), &mut results);
        let found = interruptible(|goes_on| {
            let mut observe = |pass, sample: &_| recording.add(pass, sample);
            identify_logs(scenario, learnt, predicted, passes, goes_on, &mut observe)
        });
        recording.publish(results, &found.map_err(of_replay)?)
    }
}

/// Reads files of logs.
pub(super) fn tables(paths: &[PathBuf]) -> Result<Vec<Table>, Fault> {
    let read = paths.iter().map(|path| Table::read(path));
    read.collect::<Result<_, _>>()
        .and_then(Table::of_signals)
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
