// The loop and its settings, for the chip and for the build script.

use identifier_core::parameters::Ab;
use identifier_core::settings::{BoxSettings, SettingsError, diagonal};
use identifier_core::{ControllerSettings, GradientLoop, Settings};

/// PID and gradient law over a and b.
pub type Loop = GradientLoop<f32, Ab, 2>;

/// Certifies and builds the loop, for a sample time of a millisecond and an encoder of 10 000 counts.
///
/// # Errors
/// None for these settings.
pub fn build() -> Result<Loop, SettingsError> {
    let mut settings = Settings {
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..Settings::new(1e-3, 10_000.0)
    };
    settings.identifier.plant_box = Some(BoxSettings {
        a: [0.0, 50.0],
        b: [110.0, 1000.0],
    });
    settings.identifier.gamma = Some(diagonal([20.0, 3000.0, 0.0, 0.0]));
    settings.build()
}
