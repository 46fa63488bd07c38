use std::path::PathBuf;
use std::sync::atomic::Ordering;

use super::call;
use super::drawing::Drawing;
use super::fault::Fault;
use super::files::{self, Files};
use super::interruption;
use super::progress::Progress;
use super::standard_output::say;
use super::terminal;
use crate::report::distribution;
use crate::report::page::{self, Swept};
use crate::scenario::{Purpose, Scenario, keys};
use crate::sweep::{self, Distribution};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The scenario, a TOML file; servos are drawn from its plant_box.
    scenario: PathBuf,
    /// Servos to be run.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    runs: u32,
    /// What the servos and references follow from.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u32,
    /// Threads; all cores unless stated. The result is the same for any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
    /// Write the distribution as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write every servo with what was found to this file, one row a servo; `-` is standard
    /// output.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    drawing: Drawing,
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
    let csv = files.output(arguments.csv.as_deref())?;
    let picture = files.picture(&arguments.drawing)?;
    let page = files.output(arguments.report.as_deref())?;
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads as usize)
            .build_global()
            .map_err(|error| Fault::Other(format!("no {threads} threads: {error}")))?;
    }
    let stop = interruption::asks_first();
    let what = "servos (Ctrl-C ends with what is done)";
    let progress = Progress::of(u64::from(arguments.runs), what);
    let runs = sweep::sweep(&scenario, arguments.runs, arguments.seed, stop, &|| {
        progress.advance()
    })
    .map_err(|fault| Fault::of_scenario(&arguments.scenario, fault))?;
    drop(progress);
    if runs.is_empty() {
        return Err(Fault::Other("stopped before a servo was done".to_owned()));
    }

    let result = Distribution::of(&runs);
    let law = scenario.identifier.law.name();
    let document = || distribution::Document::new(law, arguments.seed, arguments.runs, &result);
    files::commit([
        csv.map(|csv| csv.table(|file| distribution::csv(file, &runs))),
        picture.map(|picture| picture.panels("", 2, &distribution::panels(&result))),
        page.map(|page| {
            page.page(&page::sweep(&Swept {
                title: &call::title("Sweep around", &arguments.scenario),
                command: &call::command(),
                scenario: &scenario,
                seed: arguments.seed,
                distribution: &result,
            }))
        }),
        json.map(|json| json.document(&document())),
    ])?;
    if !files.own_standard_output() {
        say!("{}", distribution::table(&result, terminal::width()))?;
        say!(
            "{law}, {} servos: {} converged, {} unexplained, {} without information, {} moving, {} aborted",
            result.runs,
            result.converged,
            result.unexplained,
            result.no_information,
            result.moving,
            result.aborted
        )?;
    }
    if stop.load(Ordering::Relaxed) && runs.len() < arguments.runs as usize {
        return Err(Fault::Other(format!(
            "stopped after {} of {} servos; what is shown is of these",
            runs.len(),
            arguments.runs
        )));
    }
    Ok(())
}
