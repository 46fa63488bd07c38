use std::path::{Path, PathBuf};

use super::call;
use super::fault::Fault;
use super::files::{self, Files, io_error};
use super::live_commission::LiveCommission;
use super::output::Outputs;
use super::progress::Progress;
use super::reproduce;
use super::standard_output::say;
use super::streamed::Streamed;
use super::terminal::width;
use crate::commission::{Commissioning, Sample, StepResponse};
use crate::log::mcap::commissioning as messages;
use crate::present::{self, Commissioned};
use crate::provenance::{Kept, Origin, OriginAlone, ScenarioText, Task, WithOrigin};
use crate::render::terminal;
use crate::report::commission::{self as report, RowWriter};
use crate::result::CommissioningResult;
use crate::scenario::Purpose;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario, a TOML file with [commission]; a [controller] is the one in use.
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
    let html = files.output(outputs.report.as_deref())?;
    let live = outputs.live.begin()?;
    let is_shown = plot.is_some() || html.is_some() || live.is_some();
    let mut traces = is_shown.then(report::Traces::default);
    let silent = files.own_standard_output();

    let largest = machine.largest_motion();
    if !silent {
        say!("{}", present::largest_motion(&largest))?;
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

    let result = CommissioningResult::new(&scenario, &limits, &largest, before.as_ref(), &outcome);
    let page = present::commissioning(&Commissioned {
        title: &title,
        command: &call::command(),
        scenario: &scenario,
        limits: &limits,
        before: before.as_ref(),
        outcome: &outcome,
        traces: traces.as_ref(),
    });
    let told = WithOrigin {
        result: &result,
        origin: &origin,
    };
    files::commit([
        rows.map(|rows| rows.finish(RowWriter::finish)),
        description.map(|description| description.document(&OriginAlone::of(&origin))),
        mcap.map(|mcap| {
            mcap.finish(|mut mcap| {
                mcap.about("result", Origin::entry(&result)?)?;
                mcap.finish()
            })
        }),
        plot.zip(traces.as_ref()).map(|(plot, traces)| {
            let promised = StepResponse::promised(&scenario, &outcome);
            let figures = report::figures(&limits, &outcome, traces, promised.as_ref());
            plot.figures("", 1, &figures)
        }),
        html.map(|html| html.page(&page)),
        json.map(|json| json.document(&told)),
    ])?;
    if !silent {
        say!("{}", terminal::brief(&page, width()))?;
    }
    if let Some(kept) = kept {
        reproduce::compare(kept, &result, silent)?;
    }
    if let Some(live) = live {
        live.into_live().stay(&page);
    }
    if !outcome.is_applied() {
        let verdict = &page.verdict;
        return Err(Fault::Other(format!(
            "{}: {}",
            verdict.status, verdict.detail
        )));
    }
    if !silent {
        say!("{}", terminal::verdict(&page))?;
    }
    Ok(())
}
