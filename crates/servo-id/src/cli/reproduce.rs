use std::path::PathBuf;

use host_sim::provenance::{Kept, KeptError, LogFile, Task};

use super::fault::Fault;
use super::output::Outputs;
use super::{commission, replay, run, terminal};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// A result that `run`, `identify` or `commission` wrote with --json, or the -metadata.json of a CSV trace.
    result: PathBuf,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let file = &arguments.result;
    let refused = |error: KeptError| Fault::of_file(file, error);
    let kept = Kept::read(file).map_err(refused)?;
    if kept.origin.version != crate::VERSION {
        terminal::notify(&format!(
            "warning: {} was written by version {}, and this is {}: the result may differ",
            file.display(),
            kept.origin.version,
            crate::VERSION
        ));
    }
    let found = |logs: &[LogFile]| -> Result<Vec<PathBuf>, Fault> {
        let logs = logs.iter().map(|log| kept.log(log));
        logs.collect::<Result<_, _>>().map_err(refused)
    };
    let outputs = &arguments.outputs;
    let scenario = &kept.origin.scenario;
    match &kept.origin.task {
        Task::Run => run::experiment(scenario, outputs, &[file], Some(&kept)).map(drop),
        Task::Replay {
            passes,
            logs,
            predict,
        } => replay::Replay {
            scenario,
            logs: replay::tables(&found(logs)?)?,
            predict: replay::tables(&found(predict)?)?,
            passes: *passes,
            introduction: None,
        }
        .experiment(outputs, file, Some(&kept))
        .map(drop),
        Task::Commission => commission::experiment(scenario, outputs, file, Some(&kept)),
    }
}
