//! The parts of the core that a scenario describes.

use identifier_core::adaptation::{AutomaticGain, MatrixError, PositiveDefinite};
use identifier_core::control::{Controller, Pid};
use identifier_core::excitation::Excitation;
use identifier_core::identifier::{
    GaussNewtonIdentifier, GradientIdentifier, GradientLaw, IdentifierConfig, IdentifierError,
    Uncertainty, WindowIdentifier,
};
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;
use identifier_core::parameters::ParameterSet;
use identifier_core::stability::CertificateError;

use super::error::Fault;
use super::{
    Arithmetic, ControllerSettings, ExcitationSettings, GradientSettings, IdentifierSettings, Law,
    Reference, Scenario, WithSet, WithVelocity, fixed,
};

impl Scenario {
    /// The scenario with the loop that its law closes in place of the declared one, where it has one
    /// of its own.
    #[must_use]
    pub fn in_own_loop(mut self) -> Self {
        self.controller.gains = self.identifier.law.gains(&self.controller.gains);
        self
    }

    /// The controller with a velocity estimate.
    #[must_use]
    pub fn controller<N: Number, V: VelocityEstimate<N>>(&self, velocity: V) -> Controller<N, V> {
        let ControllerSettings { gains, units, .. } = &self.controller;
        Controller {
            pid: Pid::new(units, gains, &self.limit),
            velocity,
        }
    }

    /// What every identifier is built from.
    #[must_use]
    pub fn identifier_config(&self) -> IdentifierConfig {
        let ControllerSettings { gains, units, .. } = self.controller;
        IdentifierConfig {
            units,
            gains,
            limit: self.limit,
            plant_box: self.identifier.plant_box,
            initial: self.identifier.initial,
            bounds: self.identifier.bounds,
        }
    }

    /// The Γ-gradient law for a parameter set, Γ chosen from the box and the reference where none
    /// is given.
    ///
    /// # Errors
    /// If no Γ can be chosen, or the one given is not positive definite.
    pub fn gradient_law<S: ParameterSet<P>, const P: usize>(
        &self,
        settings: &GradientSettings,
        reference: &impl Excitation<f64>,
    ) -> Result<GradientLaw<P>, IdentifierError> {
        let gamma = match &settings.gamma {
            Some(gamma) => self.identifier.spread::<S, P>(gamma)?,
            None => self.automatic_gamma::<S, P>(reference)?,
        };
        Ok(GradientLaw {
            gamma,
            mu: settings.mu,
            frozen: self.identifier.frozen::<S, P>(),
        })
    }

    fn automatic_gamma<S: ParameterSet<P>, const P: usize>(
        &self,
        reference: &impl Excitation<f64>,
    ) -> Result<PositiveDefinite<P>, IdentifierError> {
        /// Time for which the reference is played, s, and the most samples of it.
        const PLAYED: (f64, f64) = (10.0, 200_000.0);

        struct Choose<'a, S, E, const P: usize> {
            scenario: &'a Scenario,
            automatic: AutomaticGain,
            reference: &'a E,
            set: std::marker::PhantomData<S>,
        }

        impl<S: ParameterSet<P>, E: Excitation<f64>, const P: usize> WithVelocity<f64>
            for Choose<'_, S, E, P>
        {
            type Output = Result<PositiveDefinite<P>, MatrixError>;

            fn with<V: VelocityEstimate<f64> + 'static>(self, velocity: V) -> Self::Output {
                let controller = self.scenario.controller(velocity);
                self.automatic
                    .gamma::<S, V, _, P>(&controller, self.reference)
            }
        }

        let ControllerSettings {
            gains,
            units,
            velocity,
        } = &self.controller;
        let (time, most) = PLAYED;
        let automatic = AutomaticGain {
            units: *units,
            plant_box: self.identifier_config().assumed_box(),
            kd: gains.kd(),
            samples: (time / units.sample_time()).min(most) as u32,
        };
        let work = Choose {
            scenario: self,
            automatic,
            reference,
            set: std::marker::PhantomData::<S>,
        };
        Ok(velocity.with(units, work)??)
    }

    /// Whether every part can be built from these settings, as is checked when a file is read.
    #[must_use]
    pub fn is_buildable(&self) -> bool {
        self.try_parts().is_ok()
    }

    /// The same with the reason.
    ///
    /// # Errors
    /// What cannot be built.
    pub fn buildable(&self) -> Result<(), String> {
        self.try_parts()
            .map_err(|Fault { key, fault }| format!("{key}: {fault}"))
    }

    /// The scenario with Γ stated where it would be chosen: it follows from the box and the
    /// reference, so many servos of one box can share it. Where none can be chosen it stays as it is.
    #[must_use]
    pub fn with_gamma_chosen(mut self) -> Self {
        struct Choose<'a>(&'a Scenario, &'a GradientSettings);

        impl WithSet for Choose<'_> {
            type Output = Option<Vec<Vec<f64>>>;

            fn with<S: ParameterSet<P> + 'static, const P: usize, const Q: usize>(
                self,
            ) -> Self::Output {
                let Self(scenario, settings) = self;
                let units = &scenario.controller.units;
                let reference = Reference::<f64>::new(units, &scenario.excitation).ok()?;
                let law = scenario.gradient_law::<S, P>(settings, &reference).ok()?;
                let entries = law.gamma.entries();
                let place = |wanted| S::PARAMETERS.iter().position(|&own| own == wanted);
                let own = &scenario.identifier.parameters;
                own.iter()
                    .map(|&row| {
                        own.iter()
                            .map(|&column| Some(entries[place(row)?][place(column)?]))
                            .collect()
                    })
                    .collect()
            }
        }

        let gamma = match &self.identifier.law {
            Law::Gradient(settings) | Law::PdGradient(settings) if settings.gamma.is_none() => {
                self.identifier.model_set().with(Choose(&self, settings))
            }
            _ => None,
        };
        if let (Some(gamma), Law::Gradient(settings) | Law::PdGradient(settings)) =
            (gamma, &mut self.identifier.law)
        {
            settings.gamma = Some(gamma);
        }
        self
    }

    /// Builds every part once, so that nothing can fail after output has begun.
    pub(super) fn try_parts(&self) -> Result<(), Fault> {
        let units = &self.controller.units;
        let reference = Reference::<f64>::new(units, &self.excitation).map_err(|error| {
            let multisine = matches!(self.excitation, ExcitationSettings::Multisine(_));
            let key = match error.parameter {
                "tones" | "frequency" => "frequencies",
                "amplitude" if multisine => "amplitudes",
                other => other,
            };
            Fault::new(format!("excitation.{key}"), error)
        })?;
        if let Law::Baseline(baseline, _) = &self.identifier.law {
            return self.try_baseline(*baseline).map_err(|error| {
                let key = match error.parameter {
                    "cutoff" => "filter_cutoff",
                    "sample_time" => "block",
                    other => other,
                };
                Fault::new(format!("identifier.{key}"), error)
            });
        }
        // The filter first: choosing Γ needs it.
        let cutoff = |error| Fault::new("controller.velocity_filter.cutoff", error);
        let velocity = &self.controller.velocity;
        velocity.with(units, Built).map_err(cutoff)?;
        let fault = |error| Fault::new(key_of(&error, &self.identifier.law), error);
        if self.identifier.arithmetic == Arithmetic::Fixed {
            fixed::check(self).map_err(fault)?;
        }
        let work = Build {
            scenario: self,
            reference: &reference,
        };
        self.identifier.model_set().with(work).map_err(fault)
    }
}

impl IdentifierSettings {
    /// Which parameters of a set are known.
    #[must_use]
    pub fn frozen<S: ParameterSet<P>, const P: usize>(&self) -> [bool; P] {
        S::PARAMETERS.map(|parameter| self.is_frozen(parameter))
    }

    /// A matrix over the user's parameters as one over a set; a parameter that is not estimated
    /// gets a one that the law does not use.
    fn spread<S: ParameterSet<P>, const P: usize>(
        &self,
        entries: &[Vec<f64>],
    ) -> Result<PositiveDefinite<P>, MatrixError> {
        let place = S::PARAMETERS.map(|p| self.parameters.iter().position(|&own| own == p));
        PositiveDefinite::new(std::array::from_fn(|i| {
            std::array::from_fn(|j| match (place[i], place[j]) {
                (Some(row), Some(column)) => entries[row][column],
                _ if i == j => 1.0,
                _ => 0.0,
            })
        }))
    }
}

/// Only the velocity estimate.
struct Built;

impl WithVelocity<f64> for Built {
    type Output = ();

    fn with<V: VelocityEstimate<f64> + 'static>(self, _: V) {}
}

/// A whole identifier.
struct Build<'a> {
    scenario: &'a Scenario,
    reference: &'a Reference<f64>,
}

impl WithSet for Build<'_> {
    type Output = Result<(), IdentifierError>;

    fn with<S: ParameterSet<P> + 'static, const P: usize, const Q: usize>(self) -> Self::Output {
        struct Inner<'a, S, const P: usize, const Q: usize>(
            &'a Scenario,
            Option<GradientLaw<P>>,
            std::marker::PhantomData<S>,
        );

        impl<S: ParameterSet<P>, const P: usize, const Q: usize> WithVelocity<f64> for Inner<'_, S, P, Q> {
            type Output = Result<(), IdentifierError>;

            fn with<V: VelocityEstimate<f64> + 'static>(self, velocity: V) -> Self::Output {
                let Self(scenario, law, _) = self;
                let config = scenario.identifier_config();
                let frozen = scenario.identifier.frozen::<S, P>();
                match (law, &scenario.identifier.law) {
                    (Some(law), _) => {
                        GradientIdentifier::<f64, V, S, P>::new(&config, &law, velocity)?;
                    }
                    (None, Law::GaussNewton(uncertainty, _)) => {
                        GaussNewtonIdentifier::<f64, V, S, P>::new(
                            &config,
                            uncertainty,
                            frozen,
                            velocity,
                        )?;
                        WindowIdentifier::<f64, V, S, P, Q>::new(
                            &config,
                            uncertainty,
                            frozen,
                            velocity,
                        )?;
                    }
                    (None, Law::Window(_)) => {
                        let unstated = &Uncertainty::UNSTATED;
                        WindowIdentifier::<f64, V, S, P, Q>::new(
                            &config, unstated, frozen, velocity,
                        )?;
                    }
                    _ => {}
                }
                Ok(())
            }
        }

        let Self {
            scenario,
            reference,
        } = self;
        let law = match &scenario.identifier.law {
            Law::Gradient(settings) | Law::PdGradient(settings) => {
                Some(scenario.gradient_law::<S, P>(settings, reference)?)
            }
            _ => None,
        };
        let ControllerSettings {
            units, velocity, ..
        } = &scenario.controller;
        velocity.with(
            units,
            Inner::<S, P, Q>(scenario, law, std::marker::PhantomData),
        )?
    }
}

/// The key that an identifier's error is best mended at.
fn key_of(error: &IdentifierError, law: &Law) -> String {
    let states_mu = matches!(
        law,
        Law::Gradient(settings) | Law::PdGradient(settings) if settings.mu.is_some()
    );
    match error {
        IdentifierError::Range(error) => match error.parameter {
            "alpha_min" => "controller.kd".to_owned(),
            "sample_time" => "controller.sample_time".to_owned(),
            parameter => format!("identifier.{parameter}"),
        },
        IdentifierError::Certificate(CertificateError::ProportionalGainTooSmall { .. }) => {
            "controller.kp".to_owned()
        }
        IdentifierError::Certificate(_) if states_mu => "identifier.mu".to_owned(),
        IdentifierError::Certificate(_) => "identifier.plant_box".to_owned(),
        IdentifierError::SampledLoop(_) => "controller.sample_time".to_owned(),
        _ => "identifier.gamma".to_owned(),
    }
}
