//! What a drive without a record starts from: the paper's loop, with protections for a bare motor.

use drive_link::{Dither, Format, Law, LoopSettings, Protection, Settings};
use identifier_core::settings::diagonal;

use crate::paper;

/// The settings.
#[must_use]
pub fn built_in() -> Settings {
    let mut core = paper::settings();
    // Ten times the paper's: chosen for its motor, they are slow far from it.
    core.identifier.gamma = Some(diagonal([20.0, 3000.0, 100.0, 0.0]));
    Settings {
        closed_loop: LoopSettings {
            core,
            law: Law::Gradient { friction: true },
            format: Format::Single,
        },
        dither: Dither {
            amplitude: 0.3,
            hold: 0.05,
        },
        protection: Protection {
            following_error: 1.5,
            travel: 6.3,
            speed: 6.3,
            stall_time: 0.1,
            overruns: 3,
        },
    }
}
