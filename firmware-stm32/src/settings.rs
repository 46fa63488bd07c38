//! What a drive without a record starts from: the paper's loop, with protections for a bare motor.

use drive_link::{Format, LoopSettings, Protection, Settings, Shaking};

use crate::paper;

/// The settings.
#[must_use]
pub fn built_in() -> Settings {
    Settings {
        closed_loop: LoopSettings {
            friction: true,
            // Ten times the paper's: chosen for its motor, they are slow far from it.
            gamma: [20.0, 3000.0, 100.0],
            ..paper::loop_settings(Format::Single)
        },
        shaking: Shaking {
            amplitude: 0.3,
            hold: 0.05,
        },
        protection: Protection {
            following_error: 1.5,
            travel: 6.3,
            speed: 6.3,
            silence: 0.1,
            overruns: 3,
        },
    }
}
