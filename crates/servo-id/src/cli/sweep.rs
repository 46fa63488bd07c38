use std::path::PathBuf;
use std::sync::atomic::Ordering;

use host_sim::result::{Distribution, SweepResult};
use host_sim::scenario::{Purpose, Scenario};
use host_sim::sweep;

use super::fault::Fault;
use super::files::Drawing;
use super::output::Documents;
use super::progress::Progress;
use super::{call, interruption};
use crate::{csv, present};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario, a TOML file; servos are drawn from its servo_range.
    scenario: PathBuf,
    /// Number of servos.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    runs: u32,
    /// Seed of the servos and references.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u32,
    /// Threads; all cores by default. The result is the same for any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
    /// Write every servo with its result to this file, one row per servo; `-` is standard
    /// output.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    documents: Documents,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    let documents = &arguments.documents;
    let mut results = documents.begin(
        &[&arguments.scenario],
        &Drawing::default(),
        arguments.csv.as_deref(),
    )?;
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads as usize)
            .build_global()
            .map_err(|error| Fault::Other(format!("no {threads} threads: {error}")))?;
    }
    let stop = interruption::end_requested();
    let what = "servos (Ctrl-C ends it with those that are done)";
    let progress = Progress::of_items(u64::from(arguments.runs), what);
    let runs = sweep::sweep(&scenario, 0..arguments.runs, arguments.seed, stop, &|| {
        progress.advance()
    })
    .map_err(|fault| Fault::of_file(&arguments.scenario, fault))?;
    drop(progress);
    if runs.is_empty() {
        return Err(Fault::Other(
            "stopped before the first servo was done".to_owned(),
        ));
    }

    let result = SweepResult {
        law: scenario.identifier.law.name(),
        seed: arguments.seed,
        wanted: arguments.runs,
        distribution: Distribution::new(&runs),
    };
    let page = present::sweep(
        &call::title("Sweep around", &arguments.scenario),
        &call::command(),
        &result,
    );
    let rows = results.csv.take();
    let rows = rows.map(|rows| rows.table(|file| csv::sweep(file, &runs)));
    results.publish(&page, 1, true, &result, [rows])?;
    if stop.load(Ordering::Relaxed) && runs.len() < arguments.runs as usize {
        return Err(Fault::Other(format!(
            "stopped after {} of {} servos; the figures are for these",
            runs.len(),
            arguments.runs
        )));
    }
    Ok(())
}
