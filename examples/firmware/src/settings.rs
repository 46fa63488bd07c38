// The loop and its settings, for the chip and for the build script.

use identifier_core::settings::SettingsError;
use identifier_core::{AB, GradientLoop, Settings};

/// PID and gradient estimator of a and b.
pub type Loop = GradientLoop<f32, AB>;

/// Certifies and builds the loop, for a sample time of a millisecond and an encoder of 10 000 counts.
///
/// # Errors
/// None for these settings.
pub fn build() -> Result<Loop, SettingsError> {
    Settings::new(1e-3, 10_000.0)
        .with_pid(9.0, 0.19, 4.0, 2.0)
        .with_servo_range([0.0, 50.0], [110.0, 1000.0])
        .build()
}
