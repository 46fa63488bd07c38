use std::path::PathBuf;

use super::call;
use super::fault::Fault;
use super::output::Outputs;
use crate::pil::{self, PilError};
use crate::port::Port;
use crate::rerun::{Origin, ScenarioText, Task};
use crate::result::ReplayNotes;
use crate::scenario::{Purpose, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The scenario, a TOML file (its keys are at the end of `run --help`).
    scenario: PathBuf,
    /// Where the chip is: a serial device, or tcp:HOST:PORT for an emulator.
    #[arg(long, value_name = "PORT")]
    port: String,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let text = ScenarioText::read(&arguments.scenario)?;
    let scenario = text.scenario(Purpose::Run)?;
    let title = call::title("Run on the chip of", &arguments.scenario);
    let origin = Origin::of(Task::Pil, &text, &scenario);
    let mut results = (arguments.outputs).begin(title, &[&arguments.scenario], origin, None)?;
    let fault = |error| match error {
        PilError::Scenario(fault) => Fault::of_scenario(&arguments.scenario, fault),
        other => Fault::Other(other.to_string()),
    };
    pil::loop_settings(&scenario).map_err(fault)?;
    let mut port = Port::open(&arguments.port).map_err(|error| Fault::Input(error.to_string()))?;

    let mut recording = results.record(&scenario, scenario.duration, 1);
    let outcome =
        pil::run(&scenario, &mut port, &mut |sample| recording.add(sample)).map_err(fault)?;
    results.conclude(&scenario, recording, outcome, ReplayNotes::default())
}
