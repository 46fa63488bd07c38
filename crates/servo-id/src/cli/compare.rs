use std::path::PathBuf;

use host_sim::compare;
use host_sim::scenario::{Purpose, Scenario};

use super::call;
use super::fault::Fault;
use super::files::Drawing;
use super::output::Documents;
use super::progress::Progress;
use crate::present;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario, a TOML file; its estimator does not matter.
    scenario: PathBuf,
    #[command(flatten)]
    documents: Documents,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    let results = (arguments.documents).begin(&[&arguments.scenario], &Drawing::default(), None)?;
    let of_scenario = |fault| Fault::of_file(&arguments.scenario, fault);
    let runs = compare::runs(&scenario).map_err(of_scenario)?;
    let progress = Progress::of_items(runs as u64, "runs");
    let result = compare::compare(&scenario, &|| progress.advance()).map_err(of_scenario)?;
    drop(progress);
    let page = present::comparison(
        &call::title("Comparison on", &arguments.scenario),
        &call::command(),
        &result,
        scenario.duration,
    );
    results.publish(&page, 1, false, &result, [])
}
