use std::path::{Path, PathBuf};

use host_sim::analysis::Status;
use host_sim::provenance::{Kept, Origin, ScenarioText, Task};
use host_sim::result::ReplayNotes;
use host_sim::scenario::Purpose;
use host_sim::simulate;

use super::call;
use super::fault::Fault;
use super::formats;
use super::output::Outputs;
use super::recording::Recording;
use super::required::Required;
use crate::VERSION;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario, a TOML file; `--help` ends with its keys.
    scenario: PathBuf,
    /// Print one table instead: the same measurements in every number format, for a gradient estimator.
    #[arg(long, conflicts_with_all = ["json", "csv", "plot", "report", "require"])]
    formats: bool,
    #[command(flatten)]
    required: Required,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    if arguments.formats {
        return formats::run(&arguments.scenario);
    }
    let text = ScenarioText::read(&arguments.scenario)?;
    let status = experiment(&text, &arguments.outputs, &[&arguments.scenario], None)?;
    arguments.required.check(status)
}

/// Runs a scenario and returns its verdict; the result is to be the one that was `kept`, if one was. Outputs may be no
/// `inputs`.
pub(super) fn experiment(
    text: &ScenarioText,
    outputs: &Outputs,
    inputs: &[&Path],
    kept: Option<&Kept>,
) -> Result<Status, Fault> {
    let scenario = text.scenario(Purpose::Run)?;
    let title = call::title("Run of", Path::new(&text.file));
    let origin = Origin::new(VERSION, Task::Run, text, &scenario);
    let mut results = outputs.begin(inputs, origin, kept)?;

    let mut recording = Recording::new(title, &scenario, scenario.duration, 1, &mut results);
    let outcome = simulate::run(&scenario, &mut |sample| recording.add(sample))
        .map_err(|fault| Fault::of_file(Path::new(&text.file), fault))?;
    recording.conclude(results, outcome, ReplayNotes::default())
}
