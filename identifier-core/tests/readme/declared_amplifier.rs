use identifier_core::identifier::BehindAmplifier;
use identifier_core::settings::SettingsError;
use identifier_core::{GaussNewton, Settings};

/// Behind a delay of at most eight samples.
pub(super) type Identifier = BehindAmplifier<f32, GaussNewton, 8>;

pub(super) fn build() -> Result<Identifier, SettingsError> {
    let mut settings = Settings::new(1e-3, 10_000.0);
    settings.identifier.terms.delay = 1.6e-3; // s
    settings.identifier.terms.current_loop = 0.4e-3; // s
    settings.identifier.terms.dead_band = 0.02; // command units
    settings.build()
}
