use std::path::PathBuf;

use host_sim::identify_run;
use host_sim::scenario::{Purpose, Scenario};
use identifier_log::provenance::{Origin, ScenarioText, Task};

use super::fault::Fault;
use super::output::Outputs;
use super::recording::{Recording, interruptible};
use super::required::Required;
use super::{call, formats};
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
    let scenario = Scenario::of_text(&text, Purpose::Run)?;
    let title = call::title("Run of", file);
    let origin = Origin::new(VERSION, Task::Run, &text, scenario.noise_seed());
    let mut results = arguments.outputs.begin(&[file], origin)?;

    let samples = scenario.samples();
    let mut recording = Recording::new(title, &scenario, samples, None, &mut results);
    let found = interruptible(|goes_on| {
        identify_run(scenario, goes_on, &mut |pass, sample| {
            recording.add(pass, sample)
        })
    });
    let found = found.map_err(|fault| Fault::of_file(file, fault))?;
    let status = recording.publish(results, &found)?;
    arguments.required.check(status)
}
