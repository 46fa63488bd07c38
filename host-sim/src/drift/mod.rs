//! One experiment in every number format, side by side on the same measurements: what a format
//! makes of them.
//!
//! Every format has its own controller and Γ-gradient identifier with the same setpoints and counts. Those in double
//! precision command the servo; the others act on nothing.

mod side_by_side;
mod statistics;

pub use side_by_side::{FORMATS, SIGNALS, Signal, Signals};
pub use statistics::{Difference, Differences, DriftResult};

use std::f64::consts::TAU;

use side_by_side::SideBySide;

use crate::scenario::{Fault, Scenario};
use crate::simulate::SimulatedAxis;

/// One sample in every format, in the order of [`FORMATS`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compared {
    /// Time, s.
    pub time: f64,
    /// Of each format.
    pub signals: [Signals; 3],
}

/// Runs `samples` samples of a scenario in every format and shows each to `observe`. The servo begins a number of turns
/// from its encoder's zero. `reference` gives the reference of a sample, rad from the servo's start.
///
/// # Errors
/// The key that a format cannot be built from.
pub fn run(
    scenario: &Scenario,
    turns: u32,
    samples: u64,
    reference: &mut dyn FnMut(u64) -> f64,
    observe: &mut dyn FnMut(&Compared),
) -> Result<(), Fault> {
    let unit = scenario.checked_units()?.position_unit();
    // The servo is where it is; its counter is as far away as its user has turned it, and wraps.
    let start = (f64::from(turns) * TAU / unit).round() as i64 as i32;
    let mut formats = SideBySide::new(scenario, start)?;
    let mut number = 0;
    let mut rig = SimulatedAxis::build::<f64>(scenario)?.counting_from(start);
    rig.samples = samples;
    rig.reference = Box::new(move || {
        let wanted = reference(number) / unit;
        number += 1;
        wanted
    });
    // An impossible sample ends the comparison; the samples before it count.
    rig.run(&mut formats, &mut |sample, formats| {
        observe(&Compared {
            time: sample.time,
            signals: formats.signals(),
        });
    });
    Ok(())
}
