//! The identifier: model loop, law and load estimate beside a running controller.

use core::fmt;

use crate::adaptation::{
    Gradient, GradientConfig, GradientState, GradientUpdate, MatrixError, PositiveDefinite,
};
use crate::control::{CommandLimit, ControlSample, Controller, Gains, Pid};
use crate::error::{Allowed, OutOfRange};
use crate::interval::Interval;
use crate::measurement::velocity::VelocityEstimate;
use crate::model::{HeldStep, ModelLoop, ModelSample, ModelState};
use crate::number::Number;
use crate::stability::sampled_loop::{self, SampledLoopError};
use crate::stability::{Certificate, CertificateError, PlantBox, certificate};
use crate::units::Units;

/// Everything an identifier is built from, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IdentifierConfig {
    /// Sample time and position unit.
    pub units: Units,
    /// The gains of the PID that runs.
    pub gains: Gains,
    /// The amplifier's limit.
    pub limit: CommandLimit,
    /// Where the true servo may lie. With a box the identifier is built only if the box is
    /// certified; without one nothing is promised, and the bounds of the estimates stand in for it
    /// where the guard needs the smallest α.
    pub plant_box: Option<PlantBox>,
    /// μ, 1/s; none for the automatic one.
    pub mu: Option<f64>,
    /// Γ for [â, b̂], SI.
    pub gamma: PositiveDefinite<2>,
    /// Initial [â, b̂], 1/s and rad/s² per command unit.
    pub initial: [f64; 2],
    /// Box that the estimates [â, b̂] are kept in.
    pub bounds: [Interval; 2],
}

/// Why an identifier cannot be built.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum IdentifierError {
    /// A value outside its range.
    Range(OutOfRange),
    /// Γ is not symmetric positive definite.
    Gamma(MatrixError),
    /// The certificate fails.
    Certificate(CertificateError),
    /// The sampled loop of a servo in the box is unstable.
    SampledLoop(SampledLoopError),
}

impl fmt::Display for IdentifierError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(error) => error.fmt(f),
            Self::Gamma(error) => write!(f, "gamma: {error}"),
            Self::Certificate(error) => error.fmt(f),
            Self::SampledLoop(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for IdentifierError {}

impl From<OutOfRange> for IdentifierError {
    fn from(error: OutOfRange) -> Self {
        Self::Range(error)
    }
}

impl From<MatrixError> for IdentifierError {
    fn from(error: MatrixError) -> Self {
        Self::Gamma(error)
    }
}

impl From<CertificateError> for IdentifierError {
    fn from(error: CertificateError) -> Self {
        Self::Certificate(error)
    }
}

impl From<SampledLoopError> for IdentifierError {
    fn from(error: SampledLoopError) -> Self {
        Self::SampledLoop(error)
    }
}

impl IdentifierConfig {
    /// The controller that this configuration describes, with the velocity estimate that the
    /// drive uses.
    #[must_use]
    pub fn controller<N: Number, V: VelocityEstimate<N>>(&self, velocity: V) -> Controller<N, V> {
        Controller {
            pid: Pid::new(&self.units, &self.gains, &self.limit),
            velocity,
        }
    }

    /// μ as it will be used: the one given, or the automatic one.
    #[must_use]
    pub fn mu(&self) -> f64 {
        self.mu
            .unwrap_or_else(|| certificate::automatic_mu(&self.gains, &self.assumed_box()))
    }

    /// The box, or what stands in for it.
    fn assumed_box(&self) -> PlantBox {
        self.plant_box
            .unwrap_or_else(|| PlantBox::spanning(self.bounds[0], self.bounds[1]))
    }
}

/// The largest b̂, rad/s² per command unit: far beyond any servo, and small enough that the model
/// loop stays in the range of single precision.
const LARGEST_GAIN: f64 = 1e9;

/// The on-line identifier of [a, b] and the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identifier<N, V> {
    model: ModelLoop<N, V>,
    law: Gradient<N, 2>,
    initial: [f64; 2],
    units: Units,
    certificate: Option<Certificate>,
    gain_margin: Option<f64>,
}

/// What the identifier remembers between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IdentifierState<N: Number, S> {
    model: ModelState<N, S>,
    law: GradientState<N, 2>,
    load_command: N,
}

/// What one sample showed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identification<N> {
    /// The model loop's sample.
    pub model: ModelSample<N>,
    /// What the law did.
    pub update: GradientUpdate,
    /// True when the model had run out of the number format's reach and starts again where the
    /// servo is; the estimates are kept.
    pub restarted: bool,
}

/// Estimates in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimates {
    /// â, 1/s.
    pub a: f64,
    /// b̂, rad/s² per command unit.
    pub b: f64,
    /// d̂ = b̂ k_i ∫ε, rad/s².
    pub load: f64,
}

impl<N: Number, V: VelocityEstimate<N>> Identifier<N, V> {
    /// Builds the identifier for a velocity estimate, the same that the controller uses.
    ///
    /// # Errors
    /// See [`IdentifierError`]: ranges by name, the certificate's inequality, or the servo of the
    /// box whose sampled loop is unstable.
    pub fn new(config: &IdentifierConfig, velocity: V) -> Result<Self, IdentifierError> {
        let IdentifierConfig {
            units,
            gains,
            limit,
            plant_box,
            gamma,
            initial,
            bounds,
            ..
        } = config;
        let fastest = HeldStep::<N>::LARGEST_RATE / units.rate();
        let [a_bounds, b_bounds] = bounds;
        Allowed::Within(-fastest, fastest).check("bounds.a", a_bounds.min())?;
        Allowed::Within(-fastest, fastest).check("bounds.a", a_bounds.max())?;
        Allowed::Above(0.0).check("bounds.b", b_bounds.min())?;
        Allowed::AtMost(LARGEST_GAIN).check("bounds.b", b_bounds.max())?;
        Allowed::Within(a_bounds.min(), a_bounds.max()).check("initial.a", initial[0])?;
        Allowed::Within(b_bounds.min(), b_bounds.max()).check("initial.b", initial[1])?;

        let mu = config.mu();
        let transfer = velocity.transfer();
        let (certificate, gain_margin) = match plant_box {
            Some(plant_box) => {
                let certificate = Certificate::new(gains, plant_box, mu)?;
                sampled_loop::check(units, gains, &transfer, plant_box)?;
                let margin = sampled_loop::gain_margin(units, gains, &transfer, plant_box);
                (Some(certificate), Some(margin))
            }
            None => (None, None),
        };
        let scale = [units.rate(), units.acceleration()];
        let law = Gradient::new(&GradientConfig {
            gamma: gamma.scaled(scale.map(|s| s / units.velocity()))?,
            mu: mu * units.rate(),
            slowest_decay: config.assumed_box().slowest_decay(gains.kd()) * units.rate(),
            bounds: [a_bounds.scaled(scale[0]), b_bounds.scaled(scale[1])],
        })?;
        Ok(Self {
            model: ModelLoop {
                pid: Pid::new(units, gains, limit),
                velocity,
                step: HeldStep::new(),
            },
            law,
            initial: [initial[0] * scale[0], initial[1] * scale[1]],
            units: *units,
            certificate,
            gain_margin,
        })
    }

    /// The certificate of the box, where a box was given.
    #[must_use]
    pub fn certificate(&self) -> Option<&Certificate> {
        self.certificate.as_ref()
    }

    /// The gain margin of the sampled loop over the box, where a box was given: see
    /// [`sampled_loop::gain_margin`].
    #[must_use]
    pub fn gain_margin(&self) -> Option<f64> {
        self.gain_margin
    }

    /// The state at the start: the model at rest where the servo is, the estimates at their
    /// initial values.
    #[must_use]
    pub fn start(&self) -> IdentifierState<N, V::State> {
        IdentifierState {
            model: ModelState::at_rest(),
            law: GradientState::new(self.initial),
            load_command: N::ZERO,
        }
    }

    /// One sample, after the controller's.
    #[inline]
    pub fn process(
        &self,
        state: &mut IdentifierState<N, V::State>,
        real: &ControlSample<N>,
    ) -> Identification<N> {
        let model = self.model.observe(&mut state.model, real);
        let update = self.law.update(
            &mut state.law,
            &model.regressor,
            model.output_error,
            model.output_error_rate,
        );
        let [x, gain] = state.law.estimates();
        let in_reach = self.model.advance(&mut state.model, x, gain);
        state.load_command = model.load_command;
        Identification {
            model,
            update,
            restarted: !in_reach,
        }
    }

    /// The estimates in SI.
    #[must_use]
    pub fn estimates(&self, state: &IdentifierState<N, V::State>) -> Estimates {
        let [x, gain] = state.law.estimates().map(N::to_f64);
        let b = gain / self.units.acceleration();
        Estimates {
            a: x / self.units.rate(),
            b,
            load: b * state.load_command.to_f64(),
        }
    }
}
