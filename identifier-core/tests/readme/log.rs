use identifier_core::error::StepError;
use identifier_core::identifier::Identify;
use identifier_core::parameters::ServoParameters;
use identifier_core::{GaussNewton, GaussNewtonState};

/// The servo of a log of positions and commands, a sample a row; `resolution` is that of the settings.
pub(super) fn identify(
    identifier: &GaussNewton,
    resolution: f32,
    log: &[(f32, f32)],
) -> Result<Option<ServoParameters>, StepError> {
    let mut state: GaussNewtonState = identifier.start();
    let mut last = log.first().map_or(0.0, |row| row.0);
    for &(position, command) in log {
        identifier.learn(&mut state, (position - last) / resolution, command)?;
        identifier.work(&mut state, u32::MAX);
        last = position;
    }
    Ok(identifier.estimates(&state))
}
