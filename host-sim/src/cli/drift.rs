use std::path::PathBuf;

use identifier_core::excitation::Excitation;

use super::call;
use super::fault::Fault;
use super::output::Documents;
use super::progress::Progress;
use crate::csv;
use crate::drift::{self, Differences};
use crate::present::{self, DriftTraces};
use crate::scenario::{Arithmetic, Purpose, Reference, Scenario};

/// The most samples in the trace.
const MAX_TRACE: u64 = 100_000;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario, a TOML file with the gradient law; its arithmetic does not matter.
    scenario: PathBuf,
    /// Turns of the servo from the zero of its counter at the start.
    #[arg(long, value_name = "N", default_value_t = 0)]
    turns: u32,
    /// Write the signals of every format to this file, at most 100 000 rows; `-` is standard
    /// output.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    documents: Documents,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let mut scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    if !scenario.identifier.law.is_gradient() {
        return Err(Fault::Input(format!(
            "{}: identifier.law: \"{}\" is not there in fixed point: \"gradient\" and \
             \"pd-gradient\" are",
            arguments.scenario.display(),
            scenario.identifier.law.name()
        )));
    }
    scenario.identifier.arithmetic = Arithmetic::Fixed;
    let input = |fault: String| Fault::of_file(&arguments.scenario, fault);
    scenario.buildable().map_err(input)?;

    let documents = &arguments.documents;
    let mut results = documents.begin(&[&arguments.scenario], arguments.csv.as_deref())?;

    let units = scenario.units();
    let reference = Reference::<f64>::new(&units, &scenario.excitation)
        .map_err(|error| input(error.to_string()))?;
    let mut state = reference.start();
    let samples = scenario.samples();
    let every = samples.div_ceil(MAX_TRACE).max(1);
    let mut trace = Vec::new();
    let mut traces = DriftTraces::default();
    let mut place = 0;
    let mut differences = Differences::lasting(scenario.duration);
    let progress = Progress::of_samples(samples);
    drift::run(
        &scenario,
        arguments.turns,
        samples,
        &mut |_| reference.process(&mut state) * units.position_unit(),
        &mut |compared| {
            progress.advance();
            differences.add(compared);
            traces.add(compared);
            if place % every == 0 {
                trace.push(*compared);
            }
            place += 1;
        },
    )
    .map_err(|error| input(error.to_string()))?;
    drop(progress);

    let result = differences.result(place, units.sample_time());
    let title = call::title("Number formats on", &arguments.scenario);
    let page = present::drift(&title, &call::command(), &result, &traces);
    let rows = results.csv.take();
    let rows = rows.map(|rows| rows.table(|file| csv::drift(file, &trace)));
    results.publish(&page, false, &result, [rows], |picture| {
        picture.figures("", 2, &page)
    })?;
    if result.all_finite {
        Ok(())
    } else {
        Err(Fault::Other("a value was infinite or no number".to_owned()))
    }
}
