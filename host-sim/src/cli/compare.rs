use std::path::PathBuf;

use identifier_core::parameters::Parameter;

use super::call;
use super::fault::Fault;
use super::files::{self, Files};
use super::standard_output::say;
use crate::compare;
use crate::report::{comparison, page, plot};
use crate::scenario::{Purpose, Scenario, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The scenario, a TOML file; its law does not matter.
    scenario: PathBuf,
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw the errors of every method in every case into this file, .png or .svg; `-` is standard
    /// output, as SVG.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Write a report, one HTML page with everything in it, to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Replace files that are there already.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    let mut files = Files::reading(&[&arguments.scenario], arguments.force);
    let json = files.output(arguments.json.as_deref())?;
    let picture = files.picture(arguments.plot.as_deref())?;
    let page = files.output(arguments.report.as_deref())?;
    let compared = compare::compare(&scenario)
        .map_err(|fault| Fault::of_scenario(&arguments.scenario, fault))?;
    let drawn = picture.map(|picture| {
        let methods = compared.methods.iter().map(|method| method.name);
        let cases = compared.cases.iter().map(|compared| compared.case.name);
        let grid = |parameter, title: &str| plot::Grid {
            title: title.to_owned(),
            rows: methods.clone().map(str::to_owned).collect(),
            columns: cases.clone().map(str::to_owned).collect(),
            values: comparison::grid(&compared, parameter),
        };
        picture.grids(&[
            grid(Parameter::A, "log₁₀ of the error of a, 1/s"),
            grid(Parameter::B, "log₁₀ of the relative error of b"),
        ])
    });
    let document = comparison::Document::new(&compared);
    let reported = page.map(|page| {
        let title = call::title("Comparison on", &arguments.scenario);
        page.page(&page::comparison(
            title,
            call::command(),
            &compared,
            &document,
        ))
    });
    files::commit([drawn, reported, json.map(|json| json.document(&document))])?;
    if !files.own_standard_output() {
        say!("{}", comparison::methods(&compared))?;
        for case in &compared.cases {
            say!("\n{}: {}", case.case.name, case.case.detail)?;
            say!("{}", comparison::case(case, &compared))?;
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
