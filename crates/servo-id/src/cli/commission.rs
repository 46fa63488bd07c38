use std::path::PathBuf;

use host_sim::commission::{Commissioning, Recorded, Sample};
use host_sim::result::CommissioningResult;
use host_sim::scenario::{Purpose, Scenario};
use identifier_log::provenance::{Origin, ScenarioText, Task};

use super::call;
use super::fault::Fault;
use super::output::Outputs;
use super::progress::Progress;
use super::standard_output::show;
use super::streamed::Streamed;
use crate::VERSION;
use crate::csv::Rows;
use crate::present::{self, CommissionTraces, Commissioned};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario, a TOML file with [commission]; a [controller] is the one in use.
    scenario: PathBuf,
    #[command(flatten)]
    choices: Choices,
    #[command(flatten)]
    outputs: Outputs,
}

/// Choices that a scenario may state too.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(super) struct Choices {
    /// Add a reference model with feed-forward if the step then rises faster; as `feed_forward = true`.
    #[arg(long)]
    feed_forward: bool,
}

impl Choices {
    /// A scenario with them.
    pub(super) fn stated_in(self, mut text: ScenarioText) -> ScenarioText {
        if self.feed_forward {
            text = text.stating("commission", "feed_forward = true");
        }
        text
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let file = arguments.scenario.as_path();
    let text = (arguments.choices).stated_in(ScenarioText::read(file)?);
    let scenario = Scenario::of_text(&text, Purpose::Commission)?;
    let of_scenario = |fault| Fault::of_file(file, fault);
    let origin = Origin::new(VERSION, Task::Commission, &text, scenario.noise_seed());
    let machine = Commissioning::new(&scenario).map_err(of_scenario)?;
    let mut results = arguments.outputs.begin(&[file], origin)?;
    let mut rows = (results.csv.take()).map(|csv| Streamed::begin(csv, Rows::of_commissioning));
    let mut traces = results.show_traces().then(CommissionTraces::default);

    let largest = machine.largest_motion();
    if !results.own_standard_output() {
        show!("{}", present::largest_motion(&largest))?;
        show!("{}", present::unseen_motion(&largest))?;
    }
    let limits = machine.settings().limits;
    let before = machine.gains_before().copied();
    let progress = Progress::of_a_course();
    let mut recorded = Recorded::default();
    let mut observe = |sample: &Sample| {
        progress.advance();
        recorded.add(sample);
        if let Some(rows) = &mut rows {
            rows.write(|rows| rows.commissioning_sample(sample));
        }
        if let Some(traces) = &mut traces {
            traces.add(sample);
        }
    };
    let outcome = machine.run(&mut observe).map_err(of_scenario)?;
    let effects = recorded.effects(&scenario, outcome.reason());
    drop(progress);

    let result = CommissioningResult::new(
        &scenario,
        &limits,
        &largest,
        before.as_ref(),
        &outcome,
        &effects,
    );
    let page = present::commissioning(&Commissioned {
        title: &call::title("Commissioning of", file),
        command: &call::command(),
        scenario: &scenario,
        limits: &limits,
        before: before.as_ref(),
        outcome: &outcome,
        effects: &effects,
        traces: traces.as_ref(),
    });
    let written = [rows.map(|rows| rows.finish(Rows::finish))];
    let applied = outcome.is_applied();
    results.publish(&page, 1, applied, &result, written)?;
    if applied {
        return Ok(());
    }
    let verdict = &page.verdict;
    Err(Fault::Other(format!(
        "{}: {}",
        verdict.status, verdict.detail
    )))
}
