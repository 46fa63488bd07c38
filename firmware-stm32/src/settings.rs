//! Example settings of a drive without a record: the paper's loop, with protections for a bare motor. It does
//! not start with them: they are not those of its servo.

use drive_link::{
    Dither, Estimator, LoopSettings, Protection, ServoChanges, Settings, TargetSource,
};
use identifier_core::parameters::PerParameter;

use crate::paper;

/// The settings.
#[must_use]
pub fn built_in() -> Settings {
    let mut core = paper::settings();
    core.identifier.gamma = Some(PerParameter::new(2.0, 300.0, 10.0, 0.0));
    Settings {
        closed_loop: LoopSettings {
            core,
            law: Estimator::Gradient { friction: true },
        },
        dither: Dither {
            amplitude: 0.3,
            hold: 0.05,
        },
        protection: Protection::OF_A_BARE_MOTOR,
        homing: None,
        source: TargetSource::Line,
        servo_changes: ServoChanges::Ignored,
        brake: None,
    }
}
