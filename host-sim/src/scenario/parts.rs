//! The parts of the core that a scenario describes.

use identifier_core::adaptation::{
    AutomaticGain, LeastSquares, LeastSquaresConfig, MatrixError, PositiveDefinite,
};
use identifier_core::control::{Controller, Pid};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::identifier::{Identifier, IdentifierConfig, IdentifierError};
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;
use identifier_core::stability::{CertificateError, PlantBox};
use identifier_core::units::Units;

use super::error::Fault;
use super::{
    ControllerSettings, ExcitationSettings, GradientSettings, Law, Reference, RelaySettings,
    Scenario, WithVelocity,
};

/// Standard deviations of the least squares' initial [â, b̂], SI, for a filtered acceleration with
/// noise of 1 rad/s²: so wide that the first second of data outweighs them.
const LEAST_SQUARES_UNCERTAINTY: [f64; 2] = [100.0, 1000.0];

impl RelaySettings {
    /// The least-squares recursion for a loop with these units and initial estimates.
    ///
    /// # Errors
    /// The parameter out of its range.
    pub fn least_squares<N: Number>(
        &self,
        units: &Units,
        initial: [f64; 2],
    ) -> Result<LeastSquares<N>, OutOfRange> {
        LeastSquares::new(
            units,
            &LeastSquaresConfig {
                cutoff: self.filter_cutoff,
                forgetting: self.forgetting,
                initial,
                uncertainty: LEAST_SQUARES_UNCERTAINTY,
            },
        )
    }
}

impl Scenario {
    /// The controller with a velocity estimate.
    #[must_use]
    pub fn controller<N: Number, V: VelocityEstimate<N>>(&self, velocity: V) -> Controller<N, V> {
        let ControllerSettings { gains, units, .. } = &self.controller;
        Controller {
            pid: Pid::new(units, gains, &self.limit),
            velocity,
        }
    }

    /// The configuration of the Γ-gradient identifier, Γ chosen from the box and the excitation
    /// where none is given.
    ///
    /// # Errors
    /// If no Γ can be chosen.
    pub fn identifier_config(
        &self,
        settings: &GradientSettings,
    ) -> Result<IdentifierConfig, IdentifierError> {
        let ControllerSettings { gains, units, .. } = self.controller;
        let gamma = match settings.gamma {
            Some(gamma) => gamma,
            None => self.automatic_gamma(settings)?,
        };
        Ok(IdentifierConfig {
            units,
            gains,
            limit: self.limit,
            plant_box: settings.plant_box,
            mu: settings.mu,
            gamma,
            initial: self.identifier.initial,
            bounds: settings.bounds,
        })
    }

    fn automatic_gamma(
        &self,
        settings: &GradientSettings,
    ) -> Result<PositiveDefinite<2>, IdentifierError> {
        /// Time for which the reference is played, s, and the most samples of it.
        const PLAYED: (f64, f64) = (10.0, 200_000.0);

        struct Choose<'a>(&'a Scenario, AutomaticGain, Reference<f64>);

        impl WithVelocity<f64> for Choose<'_> {
            type Output = Result<PositiveDefinite<2>, MatrixError>;

            fn with<V: VelocityEstimate<f64>>(self, velocity: V) -> Self::Output {
                let Self(scenario, automatic, reference) = self;
                automatic.gamma(&scenario.controller(velocity), &reference)
            }
        }

        let ControllerSettings {
            gains,
            units,
            velocity,
        } = &self.controller;
        let [a, b] = settings.bounds;
        let (time, most) = PLAYED;
        let automatic = AutomaticGain {
            units: *units,
            plant_box: settings
                .plant_box
                .unwrap_or_else(|| PlantBox::spanning(a, b)),
            kd: gains.kd(),
            samples: (time / units.sample_time()).min(most) as u32,
        };
        let reference = Reference::new(units, &self.excitation)?;
        Ok(velocity.with(units, Choose(self, automatic, reference))??)
    }

    /// Whether every part can be built from these settings, as is checked when a file is read.
    #[must_use]
    pub fn is_buildable(&self) -> bool {
        self.try_parts().is_ok()
    }

    /// Builds every part once, so that nothing can fail after output has begun.
    pub(super) fn try_parts(&self) -> Result<(), Fault> {
        let units = &self.controller.units;
        Reference::<f64>::new(units, &self.excitation).map_err(|error| {
            let multisine = matches!(self.excitation, ExcitationSettings::Multisine(_));
            let key = match error.parameter {
                "tones" | "frequency" => "frequencies",
                "amplitude" if multisine => "amplitudes",
                other => other,
            };
            Fault::new(format!("excitation.{key}"), error)
        })?;
        let cutoff = |error| Fault::new("controller.velocity_filter.cutoff", error);
        match &self.identifier.law {
            Law::Gradient(settings) => {
                let fault = |error: IdentifierError| Fault::new(key_of(&error, settings), error);
                // The filter first: choosing Γ needs it.
                self.controller
                    .velocity
                    .with(units, Built)
                    .map_err(cutoff)?;
                let config = self.identifier_config(settings).map_err(fault)?;
                self.controller
                    .velocity
                    .with(units, Build(&config))
                    .map_err(cutoff)?
                    .map_err(fault)
            }
            Law::RelayLeastSquares(settings) => Allowed::Above(0.0)
                .check("relay", settings.relay)
                .and_then(|_| settings.least_squares::<f64>(units, self.identifier.initial))
                .map(|_| ())
                .map_err(|error| {
                    let key = match error.parameter {
                        "cutoff" => "filter_cutoff",
                        other => other,
                    };
                    Fault::new(format!("identifier.{key}"), error)
                }),
        }
    }
}

/// Only the velocity estimate.
struct Built;

impl WithVelocity<f64> for Built {
    type Output = ();

    fn with<V: VelocityEstimate<f64>>(self, _: V) {}
}

/// A whole identifier.
struct Build<'a>(&'a IdentifierConfig);

impl WithVelocity<f64> for Build<'_> {
    type Output = Result<(), IdentifierError>;

    fn with<V: VelocityEstimate<f64>>(self, velocity: V) -> Self::Output {
        Identifier::new(self.0, velocity).map(|_| ())
    }
}

/// The key that an identifier's error is best mended at.
fn key_of(error: &IdentifierError, settings: &GradientSettings) -> String {
    match error {
        IdentifierError::Range(error) => match error.parameter {
            "alpha_min" => "controller.kd".to_owned(),
            parameter => format!("identifier.{parameter}"),
        },
        IdentifierError::Certificate(CertificateError::ProportionalGainTooSmall { .. }) => {
            "controller.kp".to_owned()
        }
        IdentifierError::Certificate(_) if settings.mu.is_some() => "identifier.mu".to_owned(),
        IdentifierError::Certificate(_) => "identifier.plant_box".to_owned(),
        IdentifierError::SampledLoop(_) => "controller.sample_time".to_owned(),
        _ => "identifier.gamma".to_owned(),
    }
}
