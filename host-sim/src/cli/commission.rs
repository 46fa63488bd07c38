use std::io;
use std::path::PathBuf;

use super::call;
use super::fault::Fault;
use super::files::{self, Files, Output, io_error};
use super::live::LiveOptions;
use super::live_commission::LiveCommission;
use super::standard_output::say;
use crate::commission::{Commissioning, Sample, StepResponse};
use crate::pil;
use crate::port::Port;
use crate::report::commission::{self as report, Document, RowWriter};
use crate::report::page::{Commissioned, commissioning};
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
    /// Draw phases, limits and signals into this file, .png or .svg; `-` is standard output, as SVG.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Write a report, one HTML page with everything in it, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    #[command(flatten)]
    live: LiveOptions,
    /// Replace files that are there already.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Commission)?;
    let of_scenario = |fault| Fault::of_scenario(&arguments.scenario, fault);
    let machine = match &arguments.port {
        Some(_) => pil::commissioning(&scenario),
        None => Commissioning::of(&scenario),
    };
    let machine = machine.map_err(of_scenario)?;
    let port = arguments.port.as_deref().map(Port::open).transpose();
    let port = port.map_err(|error| Fault::Input(error.to_string()))?;
    let mut files = Files::reading(&[&arguments.scenario], arguments.force);
    let json = files.output(arguments.json.as_deref())?;
    let mut rows = files.output(arguments.csv.as_deref())?.map(Rows::begin);
    let plot = files.picture(arguments.plot.as_deref())?;
    let page = files.output(arguments.report.as_deref())?;
    let live = arguments.live.begin()?;
    let is_shown = plot.is_some() || page.is_some() || live.is_some();
    let mut traces = is_shown.then(report::Traces::default);
    let silent = files.own_standard_output();

    let largest = machine.largest_motion();
    if !silent {
        say!("{}", report::largest_motion(&largest))?;
    }
    let limits = machine.settings().limits;
    let before = machine.gains_before().copied();
    let title = call::title("Commissioning of", &arguments.scenario);
    let mut live =
        live.map(|live| LiveCommission::new(live, title.clone(), &scenario, limits, before));
    let mut observe = |sample: &Sample| {
        if let Some(rows) = &mut rows {
            rows.add(sample);
        }
        if let Some(traces) = &mut traces {
            traces.add(sample);
            if let Some(live) = &mut live {
                live.add(sample, traces);
            }
        }
    };
    let outcome = match port {
        Some(mut port) => pil::commission(machine, &mut port, &mut observe)
            .map_err(|error| Fault::Other(error.to_string()))?,
        None => machine.run(&mut observe).map_err(of_scenario)?,
    };

    let document = Document::new(&scenario, &limits, &largest, before.as_ref(), &outcome);
    let reported = traces.as_ref().map(|traces| {
        commissioning(&Commissioned {
            title: &title,
            command: &call::command(),
            scenario: &scenario,
            limits: &limits,
            before: before.as_ref(),
            outcome: &outcome,
            traces,
        })
    });
    files::commit([
        rows.map(Rows::finish),
        plot.zip(traces.as_ref()).map(|(plot, traces)| {
            let promised = StepResponse::promised(&scenario, &outcome);
            plot.timeline(&report::picture(
                &limits,
                &outcome,
                traces,
                promised.as_ref(),
            ))
        }),
        page.zip(reported.as_ref())
            .map(|(page, reported)| page.page(reported)),
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
    if let (Some(live), Some(reported)) = (live, &reported) {
        live.into_live().stay(reported);
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
