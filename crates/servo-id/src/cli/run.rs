use std::path::PathBuf;

use host_sim::provenance::{Origin, ScenarioText, Task};
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
    /// The scenario, a TOML file; the verb `keys` lists its keys.
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
    let file = arguments.scenario.as_path();
    let text = ScenarioText::read(file)?;
    let scenario = text.scenario(Purpose::Run)?;
    let title = call::title("Run of", file);
    let origin = Origin::new(VERSION, Task::Run, &text, &scenario);
    let mut results = arguments.outputs.begin(&[file], origin)?;

    let mut recording = Recording::new(title, &scenario, scenario.duration, 1, &mut results);
    let outcome = simulate::run(&scenario, &mut |sample| recording.add(sample))
        .map_err(|fault| Fault::of_file(file, fault))?;
    let status = recording.conclude(results, outcome, ReplayNotes::default())?;
    arguments.required.check(status)
}
