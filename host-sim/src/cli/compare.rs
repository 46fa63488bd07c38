use std::path::PathBuf;

use super::call;
use super::documents::{Begun, Documents};
use super::fault::Fault;
use super::files;
use super::progress::Progress;
use super::standard_output::say;
use super::terminal;
use crate::compare;
use crate::report::{comparison, page};
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
        page,
    } = arguments.documents.begin(&[&arguments.scenario])?;
    let of_scenario = |fault| Fault::of_scenario(&arguments.scenario, fault);
    let runs = compare::runs(&scenario).map_err(of_scenario)?;
    let progress = Progress::of(runs as u64, "runs");
    let compared = compare::compare(&scenario, &|| progress.advance()).map_err(of_scenario)?;
    drop(progress);
    let drawn = picture.map(|picture| picture.heat_maps(&comparison::heat_maps(&compared)));
    let document = comparison::Document::new(&compared);
    let reported = page.map(|page| {
        let title = call::title("Comparison on", &arguments.scenario);
        page.page(&page::comparison(
            &title,
            &call::command(),
            &compared,
            &document,
        ))
    });
    files::commit([drawn, reported, json.map(|json| json.document(&document))])?;
    if !files.own_standard_output() {
        let width = terminal::width();
        say!("{}", comparison::methods(&compared, width))?;
        for case in &compared.cases {
            say!("\n{}: {}", case.case.name, case.case.detail)?;
            say!("{}", comparison::case(case, &compared, width))?;
        }
        say!(
            "Errors: mean over the last quarter of {} s less the truth. Settled: from when on â stays \
             within ±0.1 1/s and b̂ within 2 %.\nOperations: additions, multiplications and \
             comparisons of the law alone, in single precision with compensated sums.",
            scenario.duration
        )?;
    }
    Ok(())
}
