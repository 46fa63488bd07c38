use std::path::{Path, PathBuf};

use super::call;
use super::fault::Fault;
use super::files::{self, Files, io_error};
use super::live_commission::LiveCommission;
use super::output::Outputs;
use super::progress::Progress;
use super::rerun;
use super::standard_output::say;
use super::streamed::Streamed;
use crate::commission::{Commissioning, Sample, StepResponse};
use crate::log::mcap::commissioning as messages;
use crate::report::commission::{self as report, Document, RowWriter};
use crate::report::page::{Commissioned, commissioning};
use crate::rerun::{Kept, Origin, OriginAlone, ScenarioText, Task, WithOrigin};
use crate::scenario::Purpose;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario, a TOML file with [commission]; a [controller] is one that runs already.
    scenario: PathBuf,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let Arguments { scenario, outputs } = arguments;
    let text = ScenarioText::read(scenario)?;
    experiment(&text, outputs, scenario, None)
}

/// Commissions the servo of a scenario; the result is to be the one that was `kept`, if one was. No output may be `input`.
pub(super) fn experiment(
    text: &ScenarioText,
    outputs: &Outputs,
    input: &Path,
    kept: Option<&Kept>,
) -> Result<(), Fault> {
    let scenario = text.scenario(Purpose::Commission)?;
    let file = Path::new(&text.file);
    let of_scenario = |fault| Fault::of_scenario(file, fault);
    let origin = Origin::of(Task::Commission, text, &scenario);
    let machine = Commissioning::of(&scenario).map_err(of_scenario)?;
    let mut files = Files::reading(&[input], outputs.force);
    let json = files.output(outputs.json.as_deref())?;
    let rows = files.output(outputs.csv.as_deref())?;
    let begin = |csv| RowWriter::new(csv).map_err(io_error);
    let mut rows = rows.map(|csv| Streamed::begin(csv, begin));
    let description = files.description_of(outputs.csv.as_deref())?;
    let begin = |mcap| {
        let mut recorder = messages::begin(mcap)?;
        recorder.about("origin", origin.entries()?)?;
        Ok(recorder)
    };
    let mcap = files.output(outputs.mcap.as_deref())?;
    let mut mcap = mcap.map(|mcap| Streamed::begin(mcap, begin));
    let plot = files.picture(&outputs.drawing)?;
    let page = files.output(outputs.report.as_deref())?;
    let live = outputs.live.begin()?;
    let is_shown = plot.is_some() || page.is_some() || live.is_some();
    let mut traces = is_shown.then(report::Traces::default);
    let silent = files.own_standard_output();

    let largest = machine.largest_motion();
    if !silent {
        say!("{}", report::largest_motion(&largest))?;
    }
    let limits = machine.settings().limits;
    let before = machine.gains_before().copied();
    let title = call::title("Commissioning of", file);
    let mut live =
        live.map(|live| LiveCommission::new(live, title.clone(), &scenario, limits, before));
    let progress = Progress::of_a_course();
    let mut observe = |sample: &Sample| {
        progress.advance();
        if let Some(rows) = &mut rows {
            rows.write(|rows| rows.add(sample).map_err(io_error));
        }
        if let Some(mcap) = &mut mcap {
            mcap.write(|mcap| messages::add(mcap, sample));
        }
        if let Some(traces) = &mut traces {
            traces.add(sample);
            if let Some(live) = &mut live {
                live.add(sample, traces);
            }
        }
    };
    let outcome = machine.run(&mut observe).map_err(of_scenario)?;
    drop(progress);

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
        plot.zip(traces.as_ref()).map(|(plot, traces)| {
            let promised = StepResponse::promised(&scenario, &outcome);
            let figures = report::figures(&limits, &outcome, traces, promised.as_ref());
            plot.figures("", 1, &figures)
        }),
        page.zip(reported.as_ref())
            .map(|(page, reported)| page.page(reported)),
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
