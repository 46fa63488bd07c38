use std::path::PathBuf;

use super::fault::Fault;
use super::output::{Notes, Outputs};
use crate::replay::{self, Log, ReplayError};
use crate::scenario::{Purpose, Scenario, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The log, a file, .csv or .csv.gz: what `run --csv` wrote, or what a drive recorded.
    log: PathBuf,
    /// The scenario of the run that wrote the log; for any other log one with [log]: identifier, the
    /// log's columns, and the controller that ran where the log has no command.
    #[arg(long, value_name = "SCENARIO.toml")]
    scenario: PathBuf,
    /// Passes over the log, each from the estimates of the one before.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    passes: u32,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Replay)?;
    let mut results = arguments
        .outputs
        .begin(&[&arguments.scenario, &arguments.log])?;
    let declared = scenario.stated.controller.is_some();
    let log = Log::read(
        &arguments.log,
        &scenario.log_columns(),
        declared.then_some(scenario.sample_time()),
    )
    .map_err(|error| Fault::Input(error.to_string()))?;
    let scenario = replay::fitted(scenario, &log);

    let duration = f64::from(arguments.passes) * log.duration();
    let mut recording = results.record(&scenario, duration, arguments.passes);
    let mut pass_shown = 0;
    let replayed = replay::replay(&scenario, &log, arguments.passes, &mut |pass, sample| {
        if pass != pass_shown {
            recording.begin_pass();
            pass_shown = pass;
        }
        recording.add(sample);
    })
    .map_err(|error| match error {
        ReplayError::Scenario { .. } => Fault::of_scenario(&arguments.scenario, error),
        ReplayError::Log(error) => Fault::Input(error.to_string()),
    })?;
    let bridged = (log.bridged > 0).then(|| {
        format!(
            "{} missing samples were bridged by straight lines",
            log.bridged
        )
    });
    let notes = Notes {
        agreement: replayed.agreement,
        bridged,
    };
    results.conclude(&scenario, recording, replayed.outcome, &notes)
}
