use std::path::PathBuf;

use super::call;
use super::documents::{Begun, Documents};
use super::fault::Fault;
use super::files;
use super::progress::Progress;
use super::standard_output::say;
use super::terminal;
use crate::compare;
use crate::present;
use crate::render;
use crate::report::comparison;
use crate::result::ComparisonResult;
use crate::scenario::{Purpose, Scenario};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario, a TOML file; its law does not matter.
    scenario: PathBuf,
    #[command(flatten)]
    documents: Documents,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    let Begun {
        files,
        json,
        picture,
        page: html,
    } = arguments.documents.begin(&[&arguments.scenario])?;
    let of_scenario = |fault| Fault::of_scenario(&arguments.scenario, fault);
    let runs = compare::runs(&scenario).map_err(of_scenario)?;
    let progress = Progress::of(runs as u64, "runs");
    let compared = compare::compare(&scenario, &|| progress.advance()).map_err(of_scenario)?;
    drop(progress);
    let drawn = picture.map(|picture| picture.heat_maps(&comparison::heat_maps(&compared)));
    let result = ComparisonResult::new(&compared);
    let page = present::comparison(
        &call::title("Comparison on", &arguments.scenario),
        &call::command(),
        &compared,
        &result,
        scenario.duration,
    );
    files::commit([
        drawn,
        html.map(|html| html.page(&page)),
        json.map(|json| json.document(&result)),
    ])?;
    if !files.own_standard_output() {
        say!("{}", render::terminal::brief(&page, terminal::width()))?;
    }
    Ok(())
}
