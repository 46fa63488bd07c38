//! The core's settings of a scenario, and the keys of their rejections.

use identifier_core::Settings;
use identifier_core::error::OutOfRange;
use identifier_core::excitation::Excitation;
use identifier_core::interval::Interval;
use identifier_core::measurement::VelocityEstimate;
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::SettingsError;
use identifier_core::stability::{ParameterRange, SampledLoop, SampledLoopError};
use rivals::{LeastSquaresConfig, Relay};

use super::dispatch::with_velocity;
use super::{ExcitationKind, Fault, LoopKind, Reference, Scenario};

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
    /// The key of a reference that is not allowed, or for which no Γ can be chosen.
    pub fn settings(&self) -> Result<Settings, Fault> {
        self.settings_for(Some(&self.reference::<f64>()?))
    }

    /// The settings of loop and identifier. They are those of the file, with parameters that are not estimated as
    /// known. A gradient estimator gets a Γ chosen from range and reference if none is stated.
    ///
    /// # Errors
    /// The key for which no Γ can be chosen.
    #[cfg_attr(
        not(feature = "experiments"),
        expect(unused_variables, unused_mut, reason = "only a Γ needs them")
    )]
    pub fn settings_for(
        &self,
        reference: Option<&impl Excitation<f64>>,
    ) -> Result<Settings, Fault> {
        let mut settings = self.identifier_settings();
        #[cfg(feature = "experiments")]
        if let Some(reference) = reference
            && self.identifier.law.is_gradient()
            && settings.identifier.gamma.is_none()
        {
            super::gamma::choose(self, &mut settings, reference)
                .map_err(|error| self.fault(&error))?;
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

    /// The settings of a recursive least squares.
    #[must_use]
    pub fn least_squares(&self) -> LeastSquaresConfig {
        let settings = &self.identifier.rival;
        LeastSquaresConfig {
            cutoff: settings.filter_cutoff,
            forgetting: settings.forgetting,
            a: self.stated.identifier.initial.a.unwrap_or(0.0),
            // Out of every range: it is refused by its key.
            b: self.stated.identifier.initial.b.unwrap_or(f64::NAN),
        }
    }

    /// The paper's relay, within the amplifier's limit.
    ///
    /// # Errors
    /// The level must be above zero.
    pub fn relay<N: Number>(&self) -> Result<Relay<N>, OutOfRange> {
        let [low, high] = self.controller().limit;
        let level = self.identifier.rival.relay.min(high).min(-low);
        Relay::new(level)
    }

    /// Why a loop cannot hold its servo; none where it can, or where another than
    /// a PID closes it. A simulated encoder never fails, so this is why a run leaves every range.
    #[must_use]
    pub fn unstable_loop(&self) -> Option<SampledLoopError> {
        let servo = self.plant.as_ref()?;
        let closing = self.identifier.law.closing();
        if closing == LoopKind::Relay {
            return None;
        }
        match with_velocity!(self, f64 => check(&self.stated, servo.a, servo.b)) {
            Err(SettingsError::SampledLoop(error)) => Some(error),
            _ => None,
        }
    }
}

fn check<V: VelocityEstimate<f64>>(
    settings: &Settings,
    a: f64,
    b: f64,
) -> Result<(), SettingsError> {
    let velocity = settings.velocity::<f64, V>()?;
    let servo = ParameterRange::new(Interval::new("a", a, a)?, Interval::new("b", b, b)?)?;
    let gains = settings.own_controller()?.gains()?;
    let units = settings.units()?;
    SampledLoop::new(&units, &gains, &velocity.transfer()).check(&servo)?;
    Ok(())
}
