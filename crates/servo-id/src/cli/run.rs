use std::path::PathBuf;

use host_sim::analysis::Summariser;
use host_sim::scenario::{Purpose, Scenario};
use host_sim::simulate;
use identifier_log::provenance::{Origin, ScenarioText, Task};
use identifier_log::{Recorded, identify_run};

use super::call;
use super::fault::Fault;
use super::formats;
use super::output::Outputs;
use super::recording::{Recording, interruptible};
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
    let scenario = Scenario::of_text(&text, Purpose::Run)?;
    let title = call::title("Run of", file);
    let origin = Origin::new(VERSION, Task::Run, &text, scenario.noise_seed());
    let mut results = arguments.outputs.begin(&[file], origin)?;

    let mut recording = Recording::new(title, scenario.samples(), 1, &mut results);
    let refused = |fault| Fault::of_file(file, fault);
    let status = if scenario.identifier.law.takes_whole_record() {
        let mut recorded = Recorded::default();
        let outcome = simulate::run(&scenario, &mut |sample| recorded.add(sample));
        let outcome = outcome.map_err(refused)?;
        let unstable = scenario.unstable_loop();
        let mut identified =
            interruptible(|goes_on| identify_run(&scenario, recorded, outcome, unstable, goes_on));
        identified.summary.truth = scenario.plant;
        recording.publish_fit(results, &scenario, &identified)?
    } else {
        let mut summariser = Summariser::new(&scenario);
        let outcome = simulate::run(&scenario, &mut |sample| {
            summariser.add(sample);
            recording.add(0, sample);
        });
        let summary = summariser.finish(&scenario, outcome.map_err(refused)?);
        recording.publish(results, &scenario, &summary, None)?
    };
    arguments.required.check(status)
}
