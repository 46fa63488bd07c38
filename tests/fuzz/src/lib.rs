//! Settings that targets begin with.

use identifier_core::Settings;
use identifier_core::parameters::PerParameter;
use identifier_core::settings::{ControllerSettings, ParameterRangeSettings};

/// A loop that is certified.
#[must_use]
pub fn certified() -> Settings {
    let mut settings = Settings {
        resolution: 6e-4,
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..Settings::new(1e-3, 1.0)
    };
    let identifier = &mut settings.identifier;
    identifier.parameter_range = Some(ParameterRangeSettings {
        a: [0.0, 50.0],
        b: [110.0, 1000.0],
    });
    identifier.initial.a = Some(0.0);
    identifier.initial.b = Some(200.0);
    identifier.bounds.a = Some([0.0, 100.0]);
    identifier.bounds.b = Some([5.0, 5000.0]);
    identifier.bounds.coulomb = Some([0.0, 100.0]);
    identifier.bounds.load = Some([-100.0, 100.0]);
    identifier.gamma = Some(PerParameter::new(20.0, 3000.0, 20.0, 20.0));
    identifier.start_time = Some(32.0 * settings.sample_time);
    settings
}
