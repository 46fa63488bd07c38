use std::io;
use std::path::PathBuf;

use super::drawing::Drawing;
use super::fault::Fault;
use super::files::{self, Files, Output, io_error};
use super::standard_output::say;
use crate::commission::{Commissioning, Sample, StepResponse};
use crate::pil;
use crate::port::Port;
use crate::report::commission::{self as report, Document, RowWriter};
use crate::scenario::{Purpose, Scenario, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The scenario, a TOML file with [commission]; a [controller] is one that runs already.
    scenario: PathBuf,
    /// Have the machine on the chip there, the servo simulated here: a serial device, or tcp:HOST:PORT
    /// for an emulator.
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the samples, a row each, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    drawing: Drawing,
    /// Replace files that are there already.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Commission)?;
    let of_scenario = |fault| Fault::of_scenario(&arguments.scenario, fault);
    let commissioning = match &arguments.port {
        Some(_) => pil::commissioning(&scenario),
        None => Commissioning::of(&scenario),
    };
    let commissioning = commissioning.map_err(of_scenario)?;
    let port = arguments.port.as_deref().map(Port::open).transpose();
    let port = port.map_err(|error| Fault::Input(error.to_string()))?;
    let mut files = Files::reading(&[&arguments.scenario], arguments.force);
    let json = files.output(arguments.json.as_deref())?;
    let mut rows = files.output(arguments.csv.as_deref())?.map(Rows::begin);
    let plot = files.picture(&arguments.drawing)?;
    let mut traces = plot.is_some().then(report::Traces::default);
    let silent = files.own_standard_output();

    let largest = commissioning.largest_motion();
    if !silent {
        say!("{}", report::largest_motion(&largest))?;
    }
    let limits = commissioning.settings().limits;
    let before = commissioning.gains_before().copied();
    let mut observe = |sample: &Sample| {
        if let Some(rows) = &mut rows {
            rows.add(sample);
        }
        if let Some(traces) = &mut traces {
            traces.add(sample);
        }
    };
    let outcome = match port {
        Some(mut port) => pil::commission(commissioning, &mut port, &mut observe)
            .map_err(|error| Fault::Other(error.to_string()))?,
        None => commissioning.run(&mut observe).map_err(of_scenario)?,
    };

    let document = Document::new(&scenario, &limits, &largest, before.as_ref(), &outcome);
    files::commit([
        rows.map(Rows::finish),
        plot.zip(traces).map(|(plot, traces)| {
            let promised = StepResponse::promised(&scenario, &outcome);
            plot.timeline(&report::picture(
                &limits,
                &outcome,
                &traces,
                promised.as_ref(),
            ))
        }),
        json.map(|json| json.document(&document)),
    ])?;
    let verdict = report::verdict(before.is_some(), &outcome);
    if !silent {
        say!("{}", report::phases(&outcome))?;
        if let Some(servo) = outcome.servo() {
            say!("{}", report::servo(&scenario, servo))?;
        }
        if let Some(tuning) = &outcome.tuning {
            say!("{}", report::gains(before.as_ref(), tuning))?;
        }
        if let (Some(servo), Some(tuning)) = (outcome.servo(), &outcome.tuning) {
            say!("{}", report::promise(servo, tuning, outcome.trial.as_ref()))?;
        }
    }
    if !outcome.is_applied() {
        return Err(Fault::Other(verdict));
    }
    if !silent {
        say!("{verdict}")?;
    }
    Ok(())
}

/// The samples on their way into a file; the first failure ends the writing, and is told at the end.
struct Rows {
    name: String,
    writer: Result<RowWriter<Output>, io::Error>,
}

impl Rows {
    fn begin(output: Output) -> Self {
        Self {
            name: output.name().display().to_string(),
            writer: RowWriter::new(output).map_err(io_error),
        }
    }

    fn add(&mut self, sample: &Sample) {
        if let Ok(writer) = &mut self.writer
            && let Err(error) = writer.add(sample)
        {
            self.writer = Err(io_error(error));
        }
    }

    fn finish(self) -> Result<Output, Fault> {
        self.writer
            .and_then(RowWriter::finish)
            .map_err(|error| Fault::unwritable(&self.name, &error))
    }
}
