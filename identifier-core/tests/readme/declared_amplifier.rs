use identifier_core::error::StepError;
use identifier_core::identifier::Identify;
use identifier_core::model::{Amplifier, AmplifierState};
use identifier_core::settings::SettingsError;
use identifier_core::{GaussNewton, GaussNewtonState, Settings};

/// A delay of at most six samples.
pub(super) type Behind = Amplifier<f32, 8>;

pub(super) fn build() -> Result<(Behind, GaussNewton), SettingsError> {
    let mut settings = Settings::new(1e-3, 10_000.0);
    settings.identifier.terms.delay = 1.6e-3; // s
    settings.identifier.terms.current_loop = 0.4e-3; // s
    settings.identifier.terms.dead_band = 0.02; // command units
    let (amplifier, behind) = settings.amplifier()?;
    Ok((amplifier, behind.build()?))
}

pub(super) fn sample(
    (amplifier, identifier): &(Behind, GaussNewton),
    (amplified, state): &mut (AmplifierState<f32, 8>, GaussNewtonState),
    moved: i32,
    command: f32,
) -> Result<(), StepError> {
    let acts = amplifier.process(amplified, command);
    identifier.process(state, moved, acts)?;
    Ok(())
}
