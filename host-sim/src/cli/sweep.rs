use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressStyle};

use super::fault::Fault;
use super::output;
use crate::report::{distribution, plot};
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
    /// Write every servo with what was found to this file, one row a servo.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw the distribution into this file, .png or .svg.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    if let Some(path) = &arguments.plot {
        plot::check_format(path)?;
    }
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads as usize)
            .build_global()
            .map_err(|error| Fault::Other(format!("no {threads} threads: {error}")))?;
    }
    let stop = Arc::new(AtomicBool::new(false));
    let stopper = Arc::clone(&stop);
    ctrlc::set_handler(move || stopper.store(true, Ordering::Relaxed))
        .map_err(|error| Fault::Other(format!("Ctrl-C cannot be caught: {error}")))?;
    // Shown on a terminal alone.
    let bar = ProgressBar::new(u64::from(arguments.runs));
    if let Ok(style) = ProgressStyle::with_template(
        "{bar:40} {pos} of {len} servos, {per_sec}, {eta} left (Ctrl-C ends with what is done)",
    ) {
        bar.set_style(style);
    }
    let runs = sweep::sweep(&scenario, arguments.runs, arguments.seed, &stop, &|| {
        bar.inc(1)
    })
    .map_err(|fault| Fault::Input(format!("{}: {fault}", arguments.scenario.display())))?;
    bar.finish_and_clear();

    let result = Distribution::of(&runs);
    if let Some(path) = &arguments.csv {
        let file = File::create(path).map_err(|error| Fault::unwritable(path, error))?;
        distribution::csv(BufWriter::new(file), &runs)
            .map_err(|error| Fault::unwritable(path, error))?;
    }
    if let Some(path) = &arguments.plot {
        plot::write(path, "", 2, &distribution::panels(&result))?;
    }
    let law = scenario.identifier.law.name();
    if let Some(path) = &arguments.json {
        let document = distribution::Document::new(law, arguments.seed, arguments.runs, &result);
        output::document(path, &document)?;
    }
    if !output::is_standard_output(arguments.json.as_deref()) {
        say!("{}", distribution::table(&result));
        say!(
            "{law}, {} servos: {} converged, {} not, {} aborted",
            result.runs,
            result.converged,
            result.not_converged,
            result.aborted
        );
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
