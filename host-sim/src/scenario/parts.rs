//! The core's settings of a scenario, and the keys of their rejections.

use identifier_core::Settings;
use identifier_core::excitation::Excitation;
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::SettingsError;

use super::{ExcitationKind, Fault, Reference, Scenario};

impl Scenario {
    /// The scenario with the loop that its estimator closes, if it has one of its own, else with the declared one.
    #[must_use]
    pub fn in_own_loop(mut self) -> Self {
        let declared = self.stated.controller;
        self.stated.controller = declared.map(|declared| self.identifier.controller(declared));
        self
    }

    /// The settings of loop and identifier in a run: see [`Scenario::settings_for`].
    ///
    /// # Errors
    /// If the reference is not allowed, or no Γ can be chosen.
    pub fn settings(&self) -> Result<Settings, SettingsError> {
        let reference = Reference::new(&self.stated.units()?, &self.excitation)?;
        self.settings_for(Some(&reference))
    }

    /// The settings of loop and identifier. They are those of the file, with parameters that are not estimated as
    /// known. A gradient estimator gets a Γ chosen from range and reference if none is stated.
    ///
    /// # Errors
    /// If no Γ can be chosen.
    #[cfg_attr(
        not(feature = "experiments"),
        expect(unused_variables, unused_mut, reason = "only a Γ needs them")
    )]
    pub fn settings_for(
        &self,
        reference: Option<&impl Excitation<f64>>,
    ) -> Result<Settings, SettingsError> {
        let mut settings = self.identifier_settings();
        #[cfg(feature = "experiments")]
        if let Some(reference) = reference
            && self.identifier.law.is_gradient()
            && settings.identifier.gamma.is_none()
        {
            super::gamma::choose(self, &mut settings, reference)?;
        }
        Ok(settings)
    }

    /// The scenario with Γ stated if it would be chosen. It follows from the parameter range and the reference, so the
    /// servos of one range can share it. If none can be chosen, the scenario is unchanged.
    #[must_use]
    pub fn with_gamma_chosen(mut self) -> Self {
        if let Ok(settings) = self.settings() {
            self.stated.identifier.gamma = settings.identifier.gamma;
        }
        self
    }

    /// The true servo: a run needs it.
    ///
    /// # Errors
    /// It is not given.
    pub(crate) fn servo(&self) -> Result<ServoParameters, Fault> {
        self.plant.ok_or_else(|| {
            #[cfg(feature = "experiments")]
            let about = super::Key::<Self>::at("plant").map_or("", |key| key.about);
            #[cfg(not(feature = "experiments"))]
            let about = "the true servo";
            Fault::new("plant", format!("a run needs {about}"))
        })
    }

    /// The reference in a number format.
    ///
    /// # Errors
    /// The key that is out of its range.
    pub fn reference<N: Number>(&self) -> Result<Reference<N>, Fault> {
        let units = self.checked_units()?;
        Reference::new(&units, &self.excitation).map_err(|error| {
            let multisine = self.excitation.kind == ExcitationKind::Multisine;
            let key = match error.parameter {
                "tones" | "frequency" => "frequencies",
                "amplitude" if multisine => "amplitudes",
                other => other,
            };
            Fault::new(format!("excitation.{key}"), error)
        })
    }
}
