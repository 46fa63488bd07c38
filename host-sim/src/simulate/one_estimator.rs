//! From a scenario to its loop with room for one estimator in one number format. It is recursive Gauss–Newton in `f32`,
//! its velocity from a low-pass, and the fit of a whole record. The types, and so the bits, are those of the program.

use identifier_core::Settings;
use identifier_core::control::{Controller, Shaped};
use identifier_core::identifier::GaussNewtonIdentifier;
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{Parameter, Unknowns};
use identifier_core::settings::SettingsError;

use super::{SimulatedAxis, Simulation};
use crate::loops::{DynIdentifier, PidLoop, Running, WholeRecord};
use crate::scenario::{Arithmetic, Estimator, Fault, Scenario, Velocity};
use identifier_log::experiment::Outcome;

impl Simulation {
    /// Builds the experiment of a scenario.
    ///
    /// # Errors
    /// The key that something cannot be built from.
    pub fn build(scenario: &Scenario) -> Result<Self, Fault> {
        let settings = scenario.settings()?;
        let identifier = identifier(scenario, &settings)?;
        let controller: Controller<f32, LowPass<f32>, Shaped<f32>> =
            (settings.build()).map_err(|error| scenario.fault(&error))?;
        Ok(Self {
            rig: SimulatedAxis::build::<f32>(scenario)?,
            closed: Box::new(PidLoop::new(controller, identifier, 0)),
        })
    }
}

/// The identifier of a scenario beside any controller; the settings are those of [`Scenario::settings_for`].
///
/// # Errors
/// The key that it cannot be built from.
pub(crate) fn identifier(
    scenario: &Scenario,
    settings: &Settings,
) -> Result<Box<dyn DynIdentifier + Send>, Fault> {
    type Identifier = GaussNewtonIdentifier<f32, Unknowns<4>, 4>;
    let absent = |key: &str| Fault::new(key, "only the program `servo-id` has it");
    let chosen = &scenario.identifier;
    if scenario.velocity != Velocity::LowPass {
        return Err(absent("controller.velocity_filter.kind"));
    }
    match chosen.law {
        Estimator::Fit => return Ok(Box::new(WholeRecord)),
        Estimator::GaussNewton => {}
        _ => return Err(absent("identifier.law")),
    }
    if chosen.arithmetic != Arithmetic::F32 {
        return Err(absent("identifier.arithmetic"));
    }
    if !Parameter::ALL.into_iter().all(|one| chosen.estimates(one)) {
        return Err(absent("identifier.parameters"));
    }
    if scenario.has_terms() {
        return Err(absent("identifier.required_terms"));
    }
    if settings.identifier.terms.declares_amplifier() {
        return Err(absent("amplifier"));
    }
    let built: Result<Identifier, SettingsError> = settings.build();
    let built = built.map_err(|error| scenario.fault(&error))?;
    Ok(Box::new(Running::<f32, _>::new(
        built,
        None,
        Outcome::default(),
    )))
}
