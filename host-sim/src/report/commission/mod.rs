//! A commissioning: in words and tables, as JSON, as CSV and as a picture.

pub mod document;
mod picture;
mod rows;
mod words;

pub use document::Document;
pub use picture::{Traces, figures};
pub use rows::RowWriter;
pub(crate) use words::why;
pub use words::{gain_rows, gains, largest_motion, phases, promise, promise_rows, servo, verdict};

use identifier_core::commission::IdentifiedServo;
use identifier_core::parameters::ServoParameters;

use crate::scenario::Scenario;

/// What is identified: its name, its unit, and its place in the covariance.
pub(crate) const UNKNOWNS: [(&str, &str, usize); 5] = [
    ("a", "1/s", IdentifiedServo::A),
    ("b", "rad/s² per command unit", IdentifiedServo::B),
    ("coulomb", "rad/s²", IdentifiedServo::COULOMB),
    ("load", "rad/s²", IdentifiedServo::LOAD),
    ("delay", "s", IdentifiedServo::DELAY),
];

/// The values in the order of [`UNKNOWNS`].
pub(crate) fn values(parameters: &ServoParameters, delay: f64) -> [f64; 5] {
    [
        parameters.a,
        parameters.b,
        parameters.coulomb,
        parameters.load,
        delay,
    ]
}

/// Those of the true servo, where it stands at first. A slow current loop delays as its time constant does.
pub(crate) fn truth(scenario: &Scenario) -> Option<[f64; 5]> {
    let effects = &scenario.effects;
    let delay = effects.delay + effects.current_loop;
    scenario.plant.as_ref().map(|plant| values(plant, delay))
}
