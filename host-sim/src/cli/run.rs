use std::path::PathBuf;

use super::fault::Fault;
use super::output;
use crate::experiment::{self, Sample};
use crate::report::json::Document;
use crate::report::plot::{self, Curve, Panel};
use crate::report::{Status, Summariser, Summary, table};
use crate::scenario::{Scenario, keys};

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
    let scenario = Scenario::load(&arguments.scenario)?;
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
        plot::write(path, "", 2, &panels(&summary, &trace))?;
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

fn panels(summary: &Summary, trace: &[Sample]) -> Vec<Panel> {
    let curve = |name: Option<&str>, value: &dyn Fn(&Sample) -> Option<f64>| Curve {
        name: name.map(str::to_owned),
        points: trace
            .iter()
            .filter_map(|sample| Some((sample.time, value(sample)?)))
            .collect(),
    };
    let panel = |title: &str, axis: &str, curves, nominal: Option<f64>| Panel {
        title: title.to_owned(),
        axis: axis.to_owned(),
        curves,
        nominal: nominal.map(|value| ("true".to_owned(), value)),
        range: None,
    };
    let truth = &summary.truth;
    let mut panels = vec![
        panel(
            "Viscous friction over inertia",
            "a [1/s]",
            vec![curve(None, &|s| Some(s.a))],
            Some(truth.a),
        ),
        panel(
            "Gain over inertia",
            "b [rad/s² per unit]",
            vec![curve(None, &|s| Some(s.b))],
            Some(truth.b),
        ),
    ];
    if summary.load.is_some() {
        panels.push(panel(
            "Load over inertia",
            "d [rad/s²]",
            vec![curve(None, &|s| s.load)],
            Some(truth.load),
        ));
    }
    panels.push(panel(
        "Position",
        "q [rad]",
        vec![
            curve(Some("measured"), &|s| Some(s.position)),
            curve(Some("reference"), &|s| Some(s.reference)),
        ],
        None,
    ));
    if summary.output_error.is_some() {
        panels.push(panel(
            "Output error",
            "ε [rad]",
            vec![curve(None, &|s| s.output_error)],
            None,
        ));
    }
    panels.push(panel(
        "Command",
        "u [command units]",
        vec![curve(None, &|s| Some(s.command))],
        None,
    ));
    panels
}
