use std::path::PathBuf;

use super::call;
use super::fault::Fault;
use super::output::{Notes, Outputs};
use crate::scenario::{Purpose, Scenario, keys};
use crate::simulate;

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The scenario, a TOML file (its keys: `host-sim run --help`).
    scenario: PathBuf,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    let title = call::title("Run of", &arguments.scenario);
    let mut results = arguments.outputs.begin(title, &[&arguments.scenario])?;

    let mut recording = results.record(&scenario, scenario.duration, 1);
    let outcome = simulate::run(&scenario, &mut |sample| recording.add(sample))
        .map_err(|fault| Fault::of_scenario(&arguments.scenario, fault))?;
    results.conclude(&scenario, recording, outcome, Notes::default())
}
