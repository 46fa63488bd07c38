use std::path::PathBuf;

use identifier_core::parameters::Parameter;

use super::fault::Fault;
use super::output;
use crate::compare;
use crate::report::{comparison, plot};
use crate::scenario::{Purpose, Scenario, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The scenario, a TOML file; its law does not matter.
    scenario: PathBuf,
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw the errors of every method in every case into this file, .png or .svg.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    if let Some(path) = &arguments.plot {
        plot::check_format(path)?;
    }
    let compared = compare::compare(&scenario)
        .map_err(|fault| Fault::Input(format!("{}: {fault}", arguments.scenario.display())))?;
    if let Some(path) = &arguments.plot {
        let methods = compared.methods.iter().map(|method| method.name);
        let cases = compared.cases.iter().map(|compared| compared.case.name);
        let grid = |parameter, title: &str| plot::Grid {
            title: title.to_owned(),
            rows: methods.clone().map(str::to_owned).collect(),
            columns: cases.clone().map(str::to_owned).collect(),
            values: comparison::grid(&compared, parameter),
        };
        plot::write_grids(
            path,
            &[
                grid(Parameter::A, "log₁₀ of the error of a, 1/s"),
                grid(Parameter::B, "log₁₀ of the relative error of b"),
            ],
        )?;
    }
    if let Some(path) = &arguments.json {
        output::document(path, &comparison::Document::new(&compared))?;
    }
    if !output::is_standard_output(arguments.json.as_deref()) {
        say!("{}", comparison::methods(&compared));
        for case in &compared.cases {
            say!("\n{}: {}", case.case.name, case.case.detail);
            say!("{}", comparison::case(case, &compared));
        }
        say!(
            "Errors: mean over the last quarter of {} s less the truth. Settled: from when on â stays \
             within ±0.1 1/s and b̂ within 2 %.\nOperations: additions, multiplications and \
             comparisons of the law alone, in single precision with compensated sums.",
            scenario.duration
        );
    }
    Ok(())
}
