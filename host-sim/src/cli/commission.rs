use std::path::{Path, PathBuf};

use super::fault::Fault;
use super::files::{self, Files, io_error};
use super::rerun;
use super::standard_output::say;
use super::streamed::Streamed;
use crate::commission::{Commissioning, Sample, StepResponse};
use crate::log_file::commissioning as messages;
use crate::pil;
use crate::port::Port;
use crate::report::commission::{self as report, Document, RowWriter};
use crate::rerun::{Kept, Origin, OriginAlone, ScenarioText, Task, WithOrigin};
use crate::scenario::{Purpose, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The scenario, a TOML file with [commission]; a [controller] is one that runs already.
    pub(super) scenario: PathBuf,
    /// Have the machine on the chip there, the servo simulated here: a serial device, or tcp:HOST:PORT
    /// for an emulator.
    #[arg(long, value_name = "PORT")]
    pub(super) port: Option<String>,
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Write the samples, a row each, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// Write the samples, with where they are from, to this MCAP file, which Foxglove and PlotJuggler show; `-`
    /// is standard output.
    #[arg(long, value_name = "FILE")]
    pub(super) mcap: Option<PathBuf>,
    /// Draw phases, limits and signals into this file, .png or .svg; `-` is standard output, as SVG.
    #[arg(long, value_name = "FILE")]
    pub(super) plot: Option<PathBuf>,
    /// Replace files that are there already.
    #[arg(long)]
    pub(super) force: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let text = ScenarioText::read(&arguments.scenario)?;
    experiment(arguments, &text, None)
}

/// Commissions the servo of a scenario, whose text is given; the result is to be the one that was `kept`, if
/// one was.
pub(super) fn experiment(
    arguments: &Arguments,
    text: &ScenarioText,
    kept: Option<&Kept>,
) -> Result<(), Fault> {
    let scenario = text.scenario(Purpose::Commission)?;
    let of_scenario = |fault| Fault::of_scenario(Path::new(&text.file), fault);
    let commissioning = match &arguments.port {
        Some(_) => pil::commissioning(&scenario),
        None => Commissioning::of(&scenario),
    };
    let commissioning = commissioning.map_err(of_scenario)?;
    let port = arguments.port.as_deref().map(Port::open).transpose();
    let port = port.map_err(|error| Fault::Input(error.to_string()))?;
    let mut files = Files::reading(&[&arguments.scenario], arguments.force);
    let json = files.output(arguments.json.as_deref())?;
    let rows = files.output(arguments.csv.as_deref())?;
    let description = files.description_of(arguments.csv.as_deref())?;
    let mcap = files.output(arguments.mcap.as_deref())?;
    let plot = files.picture(arguments.plot.as_deref())?;
    let mut traces = plot.is_some().then(report::Traces::default);
    let silent = files.own_standard_output();

    let task = match arguments.port {
        Some(_) => Task::Pil,
        None => Task::Commission,
    };
    let origin = Origin::of(task, text, &scenario);
    let begin = |csv| RowWriter::new(csv).map_err(io_error);
    let mut rows = rows.map(|csv| Streamed::begin(csv, begin));
    let begin = |mcap| {
        let mut recorder = messages::begin(mcap)?;
        recorder.about("origin", origin.entries()?)?;
        Ok(recorder)
    };
    let mut mcap = mcap.map(|mcap| Streamed::begin(mcap, begin));

    let largest = commissioning.largest_motion();
    if !silent {
        say!("{}", report::largest_motion(&largest))?;
    }
    let limits = commissioning.settings().limits;
    let before = commissioning.gains_before().copied();
    let mut observe = |sample: &Sample| {
        if let Some(rows) = &mut rows {
            rows.write(|rows| rows.add(sample).map_err(io_error));
        }
        if let Some(mcap) = &mut mcap {
            mcap.write(|mcap| messages::add(mcap, sample));
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
    let told = WithOrigin {
        result: &document,
        origin: &origin,
    };
    files::commit([
        rows.map(|rows| rows.finish(RowWriter::finish)),
        description.map(|description| description.document(&OriginAlone::of(&origin))),
        mcap.map(|mcap| {
            mcap.finish(|mut mcap| {
                mcap.about("result", Origin::entry(&document)?)?;
                mcap.finish()
            })
        }),
        plot.zip(traces).map(|(plot, traces)| {
            let promised = StepResponse::promised(&scenario, &outcome);
            plot.timeline(&report::picture(
                &limits,
                &outcome,
                &traces,
                promised.as_ref(),
            ))
        }),
        json.map(|json| json.document(&told)),
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
    if let Some(kept) = kept {
        rerun::compare(kept, &document, silent)?;
    }
    if !outcome.is_applied() {
        return Err(Fault::Other(verdict));
    }
    if !silent {
        say!("{verdict}")?;
    }
    Ok(())
}
