//! The core's settings of a scenario, and the keys of their rejections.

use identifier_core::Settings;
use identifier_core::excitation::Excitation;
use identifier_core::number::Number;
use identifier_core::parameters::{PerParameter, ServoParameters};
use identifier_core::settings::{GainError, SettingsError};
use identifier_core::stability::CertificateError;
use identifier_core::units::Units;

use super::{Arithmetic, ExcitationKind, Fault, Reference, Scenario};

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
        expect(unused_variables, reason = "only the other estimators have a Γ")
    )]
    pub fn settings_for(
        &self,
        reference: Option<&impl Excitation<f64>>,
    ) -> Result<Settings, SettingsError> {
        let mut settings = self.stated;
        settings.identifier.known =
            PerParameter::from_fn(|parameter| self.identifier.is_known(parameter));
        if self.identifier.arithmetic == Arithmetic::Fixed {
            bound_by_the_range(&mut settings);
        }
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
            let about = super::Key::at("plant").map_or("", |key| key.about);
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

    /// [`Scenario::units`] where they are not known to be allowed.
    ///
    /// # Errors
    /// The key that is out of its range.
    pub(crate) fn checked_units(&self) -> Result<Units, Fault> {
        self.stated
            .units()
            .map_err(|error| self.fault(&error.into()))
    }

    /// An error of the core at the key that it is best mended at.
    #[must_use]
    pub fn fault(&self, error: &SettingsError) -> Fault {
        Fault::new(self.key_of(error), error)
    }

    fn key_of(&self, error: &SettingsError) -> String {
        let given = &self.stated.identifier;
        let gains = match given.correction {
            Some(_) => "identifier.correction",
            None => "controller",
        };
        match error {
            SettingsError::Range(error) => match error.parameter {
                "alpha_min" => format!("{gains}.kd"),
                parameter @ ("kp" | "kd" | "ki") => format!("{gains}.{parameter}"),
                "cutoff" => "controller.velocity_filter.cutoff".to_owned(),
                "reference_filter" => "controller.reference_filter".to_owned(),
                "notch" => "controller.notch".to_owned(),
                "sample_time" => "controller.sample_time".to_owned(),
                "resolution" => "encoder.counts_per_rev".to_owned(),
                "delay" => "amplifier.delay".to_owned(),
                "dead_band" => "amplifier.dead_band".to_owned(),
                "current_loop" => "amplifier.current_loop".to_owned(),
                "limit" | "limit_low" | "limit_high" => "amplifier.limit".to_owned(),
                "a_min" => "identifier.plant_box.a".to_owned(),
                "b_min" => "identifier.plant_box.b".to_owned(),
                parameter => match parameter.strip_prefix("feed_forward_") {
                    Some(own) => format!("controller.feed_forward.{own}"),
                    None => format!("identifier.{parameter}"),
                },
            },
            SettingsError::NotGiven {
                setting: "controller",
            } => "controller".to_owned(),
            SettingsError::NotGiven { setting } => format!("identifier.{setting}"),
            SettingsError::NoAmplifier { setting } => format!("amplifier.{setting}"),
            SettingsError::Certificate(CertificateError::ProportionalGainTooSmall { .. }) => {
                format!("{gains}.kp")
            }
            SettingsError::Certificate(_) if given.mu.is_some() => "identifier.mu".to_owned(),
            SettingsError::Certificate(_) => "identifier.plant_box".to_owned(),
            SettingsError::NoGamma(GainError::AtRest) => "excitation.kind".to_owned(),
            SettingsError::NoGamma(_) => "controller.sample_time".to_owned(),
            SettingsError::SampledLoop(_) => "controller.sample_time".to_owned(),
            SettingsError::NoSuchTerm { .. } => "identifier.required_terms".to_owned(),
            SettingsError::Estimate(_) => "identifier.bounds.b".to_owned(),
            _ => "identifier.gamma".to_owned(),
        }
    }
}

/// Fixed point needs bounds of friction and load. If none are stated, the parameter range gives them. A command of the
/// limit, or of an error of one, makes no larger acceleration of any servo in it.
fn bound_by_the_range(settings: &mut Settings) {
    let (Some(within), Some(controller)) =
        (settings.identifier.parameter_range, settings.controller)
    else {
        return;
    };
    let [low, high] = controller.limit;
    let most = within.b[1] * controller.kp.min(high).min(-low);
    let bounds = &mut settings.identifier.bounds;
    bounds.coulomb.get_or_insert([0.0, most]);
    bounds.load.get_or_insert([-most, most]);
}

/// The matrix of which nothing is stated yet.
pub(super) fn identity() -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
}
