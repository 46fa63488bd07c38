use std::path::PathBuf;
use std::sync::atomic::Ordering;

use super::call;
use super::documents::{Begun, Documents};
use super::fault::Fault;
use super::files;
use super::interruption;
use super::progress::Progress;
use super::standard_output::say;
use super::terminal;
use crate::report::distribution;
use crate::report::page::{self, Swept};
use crate::scenario::{Purpose, Scenario};
use crate::sweep::{self, Distribution};

#[derive(Debug, clap::Args)]
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
    /// Write every servo with what was found to this file, one row a servo; `-` is standard
    /// output.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    documents: Documents,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    let Begun {
        mut files,
        json,
        picture,
        page,
    } = arguments.documents.begin(&[&arguments.scenario])?;
    let csv = files.output(arguments.csv.as_deref())?;
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads as usize)
            .build_global()
            .map_err(|error| Fault::Other(format!("no {threads} threads: {error}")))?;
    }
    let stop = interruption::end_requested();
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
        picture.map(|picture| picture.figures("", 2, &distribution::figures(&result))),
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
