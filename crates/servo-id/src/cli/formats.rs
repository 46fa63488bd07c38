//! `run --formats`: one experiment in every number format, side by side on the same measurements.

use std::path::Path;

use host_sim::drift::{self, Differences};
use host_sim::scenario::{Arithmetic, Purpose, Reference, Scenario};
use identifier_core::excitation::Excitation;

use super::fault::Fault;
use super::progress::Progress;
use super::standard_output::show;
use super::terminal::width;
use crate::present;
use crate::render::terminal;

/// Prints the differences of the formats from double precision.
pub(super) fn run(file: &Path) -> Result<(), Fault> {
    let mut scenario = Scenario::load(file, Purpose::Run)?;
    let input = |fault: String| Fault::of_file(file, fault);
    let law = scenario.identifier.law;
    if !law.is_gradient() {
        let fault = "does not exist in fixed point: \"gradient\", \"paper\" and \"pd-gradient\" do";
        return Err(input(format!("identifier.law: \"{}\" {fault}", law.name())));
    }
    scenario.identifier.arithmetic = Arithmetic::Fixed;
    scenario.buildable().map_err(input)?;
    let units = scenario.units();
    let reference = Reference::<f64>::new(&units, &scenario.excitation)
        .map_err(|error| input(error.to_string()))?;
    let mut state = reference.start();
    let samples = scenario.samples();
    let mut differences = Differences::lasting(scenario.duration);
    let progress = Progress::of_samples(samples);
    drift::run(
        &scenario,
        0,
        samples,
        &mut |_| reference.process(&mut state) * units.position_unit(),
        &mut |compared| {
            progress.advance();
            differences.add(compared);
        },
    )
    .map_err(|error| input(error.to_string()))?;
    drop(progress);
    let result = differences.result(samples);
    show!("{}", terminal::blocks(&present::formats(&result), width()))?;
    if result.all_finite {
        Ok(())
    } else {
        Err(Fault::Other("a value was not finite".to_owned()))
    }
}
