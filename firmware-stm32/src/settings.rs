//! Example settings of a drive without a record: the paper's loop, with protections for a bare motor. It does
//! not start with them: they are not those of its servo.

use drive_link::{Estimator, LoopSettings, Settings};
use identifier_core::parameters::PerParameter;

use crate::paper;

/// The settings.
#[must_use]
pub fn built_in() -> Settings {
    let mut core = paper::settings();
    core.identifier.gamma = Some(PerParameter::new(2.0, 300.0, 10.0, 0.0));
    Settings::example(LoopSettings {
        core,
        law: Estimator::Gradient { friction: true },
    })
}
