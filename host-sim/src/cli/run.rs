use std::path::PathBuf;

use super::fault::Fault;
use super::output;
use crate::experiment;
use crate::report::json::Document;
use crate::report::plot;
use crate::report::{Status, Summariser, panels, table};
use crate::scenario::{Purpose, Scenario, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The scenario, a TOML file (its keys: `host-sim run --help`).
    scenario: PathBuf,
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the trace, one row a sample, to this file.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the estimates and signals into this file, .png or .svg.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    if let Some(path) = &arguments.plot {
        plot::check_format(path)?;
    }
    let wants_trace = arguments.csv.is_some() || arguments.plot.is_some();

    let mut summariser = Summariser::new(&scenario);
    let mut trace = Vec::new();
    let outcome = experiment::run(&scenario, &mut |sample| {
        summariser.add(sample);
        if wants_trace {
            trace.push(*sample);
        }
    });
    let summary = summariser.finish(&scenario, outcome);

    if let Some(path) = &arguments.csv {
        output::csv(path, &trace)?;
    }
    if let Some(path) = &arguments.plot {
        plot::write(path, "", 2, &panels::experiment(&summary, &trace))?;
    }
    if let Some(path) = &arguments.json {
        output::json(path, &Document::new(&summary))?;
    }
    let quiet = arguments
        .json
        .as_deref()
        .is_some_and(output::is_standard_output);
    if !quiet {
        println!("{}", table::estimates(&[(summary.law, &summary)]));
        println!("{}: {}", summary.status.name(), summary.reason);
    }
    match summary.status {
        Status::Aborted => Err(Fault::Other(summary.reason)),
        Status::Converged | Status::NotConverged => Ok(()),
    }
}
