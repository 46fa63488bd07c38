use core::marker::PhantomData;

use super::config::Promise;
use super::{Found, IdentifierConfig, IdentifierError};
use crate::adaptation::{GaussNewton, GaussNewtonConfig, GaussNewtonState};
use crate::control::{ControlSample, ControlState, Controller};
use crate::error::Allowed;
use crate::measurement::velocity::VelocityEstimate;
use crate::model::{ModelLoop, ModelState, Sensitivity, ServoParameters};
use crate::number::Number;
use crate::parameters::{ModelParameters, Parameter, ParameterSet};
use crate::stability::{Certificate, certificate};
use crate::units::Units;

/// What is known before the first sample, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// Standard deviations of the initial estimates; none for the default, a factor of three.
    pub initial: [Option<f64>; 4],
    /// Standard deviation of the position noise, rad; none for an encoder's, a count over √12.
    pub noise: Option<f64>,
}

impl Uncertainty {
    /// Nothing stated.
    pub const UNSTATED: Self = Self {
        initial: [None; 4],
        noise: None,
    };

    /// The standard deviation of an initial estimate.
    ///
    /// A factor of three makes it twice the value. Where the value is zero: for a, the damping that
    /// the loop itself adds, or its natural frequency if it adds none; for friction and load, a tenth of what the command can do, since a
    /// servo that needs more for them is not one to identify.
    pub(super) fn of(&self, parameter: Parameter, config: &IdentifierConfig) -> f64 {
        /// Half-width of a factor of three: 3 − 1.
        const FACTOR: f64 = 2.0;
        let b = config.initial.b;
        let stated = match parameter {
            Parameter::A => self.initial[0],
            Parameter::B => self.initial[1],
            Parameter::Coulomb => self.initial[2],
            Parameter::Load => self.initial[3],
        };
        let command = config
            .limit
            .high()
            .min(-config.limit.low())
            .min(config.gains.kp());
        let least = match parameter {
            Parameter::A if config.gains.kd() > 0.0 => b * config.gains.kd(),
            Parameter::A => libm::sqrt(b * config.gains.kp()),
            Parameter::B => 0.0,
            Parameter::Coulomb | Parameter::Load => 0.1 * b * command,
        };
        stated.unwrap_or_else(|| (FACTOR * libm::fabs(parameter.of(&config.initial))).max(least))
    }
}

/// The fast identifier: recursive Gauss–Newton on the model loop, for the parameter set S.
///
/// When an estimate moves, the model's state moves with it to where it would have been, to first
/// order, had the estimate always been the new one. The output error then is what the *present*
/// estimates leave unexplained, and nothing has to wait for the loop to forget the old ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonIdentifier<N, V, S, const P: usize> {
    model: ModelLoop<N, V>,
    law: GaussNewton<N, P>,
    initial: [f64; P],
    units: Units,
    load_weight: N,
    promise: Option<Promise>,
    set: PhantomData<S>,
}

/// What the identifier remembers between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonIdentifierState<N: Number, F, const P: usize> {
    model: ModelState<N, F>,
    sensitivity: Sensitivity<N, F, P>,
    law: GaussNewtonState<N, P>,
    load_command: N,
    load_mean: N,
    load_variance: N,
}

/// What one sample showed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonIdentification<N> {
    /// Output error ε = q − q_e before the update, machine units.
    pub output_error: N,
    /// True when the model had run out of the number format's reach and starts again where the
    /// servo is; the estimates are kept.
    pub restarted: bool,
}

impl<N, V, S, const P: usize> GaussNewtonIdentifier<N, V, S, P>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    /// Velocity below which the servo counts as standing, position units (counts) per sample.
    pub const DEAD_ZONE: f64 = 0.02;

    /// Samples over which the unrest of the integral's part of the load is taken.
    pub const LOAD_MEMORY: f64 = 5000.0;

    /// Builds the identifier for a velocity estimate, the same that the controller uses; `frozen`
    /// parameters are known and stay at their initial values.
    ///
    /// # Errors
    /// See [`IdentifierError`].
    pub fn new(
        config: &IdentifierConfig,
        uncertainty: &Uncertainty,
        frozen: [bool; P],
        velocity: V,
    ) -> Result<Self, IdentifierError> {
        config.check::<S, P>()?;
        let units = &config.units;
        let mu = certificate::automatic_mu(&config.gains, &config.assumed_box());
        let promise = config.certify(mu, &velocity.transfer())?;
        let noise = match uncertainty.noise {
            Some(noise) => {
                let scaled = Allowed::Above(0.0).check("noise", noise)? * units.position();
                scaled * scaled
            }
            None => 1.0 / 12.0,
        };
        let mut deviations = S::PARAMETERS
            .map(|parameter| uncertainty.of(parameter, config) * parameter.scale(units));
        for (deviation, frozen) in deviations.iter_mut().zip(frozen) {
            if frozen {
                *deviation = 0.0;
            }
        }
        Ok(Self {
            model: config.model_loop(velocity),
            law: GaussNewton::new(&GaussNewtonConfig {
                noise,
                dead_zone: Self::DEAD_ZONE,
                uncertainty: deviations,
                bounds: config.bounds_of::<S, P>(),
            })?,
            initial: config.initial_of::<S, P>(),
            units: *units,
            load_weight: N::from_f64(1.0 / Self::LOAD_MEMORY),
            promise,
            set: PhantomData,
        })
    }

    /// The controller that the model loop has, to close the real loop with.
    #[inline]
    #[must_use]
    pub fn controller(&self) -> &Controller<N, V> {
        &self.model.controller
    }

    /// The certificate of the box, where a box was given.
    #[must_use]
    pub fn certificate(&self) -> Option<&Certificate> {
        self.promise.as_ref().map(|promise| &promise.certificate)
    }

    /// The gain margin of the sampled loop over the box, where a box was given.
    #[must_use]
    pub fn gain_margin(&self) -> Option<f64> {
        self.promise.map(|promise| promise.gain_margin)
    }

    /// The state at the start: the model at rest where the servo is, the estimates at their
    /// initial values.
    #[must_use]
    pub fn start(&self) -> GaussNewtonIdentifierState<N, V::State, P> {
        GaussNewtonIdentifierState {
            model: ModelState::at_rest(),
            sensitivity: Sensitivity::none(),
            law: self.law.start(self.initial),
            load_command: N::ZERO,
            load_mean: N::ZERO,
            load_variance: N::ZERO,
        }
    }

    /// One sample, after the controller's.
    #[inline]
    pub fn process(
        &self,
        state: &mut GaussNewtonIdentifierState<N, V::State, P>,
        real: &ControlSample<N>,
    ) -> GaussNewtonIdentification<N> {
        let GaussNewtonIdentifierState {
            model,
            sensitivity,
            law,
            load_command,
            load_mean,
            load_variance,
        } = state;
        self.model.observe(model, real);
        self.model.observe_tangents(sensitivity);
        let output_error = model.output_error();
        let change = self
            .law
            .update(law, &sensitivity.position(), output_error, model.velocity());
        self.model.follow(model, sensitivity, &change);

        let parameters = ModelParameters::of_set::<S, P>(&law.estimates());
        let command = self.model.command(model, real);
        self.model.command_tangents(sensitivity, &command);
        let velocity = model.velocity();
        let phase = self.model.advance::<S, P>(model, &command, &parameters);
        self.model
            .advance_tangents::<S, P, P>(sensitivity, &command, &parameters, velocity, phase);
        if self.model.stand_together(model, real, &parameters, phase) {
            self.model.stand_still(sensitivity);
        }
        *load_command = command.load;
        let deviation = command.load - *load_mean;
        *load_mean += self.load_weight * deviation;
        *load_variance += self.load_weight * (deviation * deviation - *load_variance);
        let restarted = self.model.restart_if_lost(model);
        if restarted {
            *sensitivity = Sensitivity::none();
        }
        GaussNewtonIdentification {
            output_error,
            restarted,
        }
    }

    /// The estimates in SI; the load is the part found as a parameter plus b̂ k_i ∫ε.
    #[must_use]
    pub fn estimates(&self, state: &GaussNewtonIdentifierState<N, V::State, P>) -> ServoParameters {
        let parameters = ModelParameters::of_set::<S, P>(&state.law.estimates());
        parameters
            .to_si(&self.units)
            .with_load_of(state.load_command.to_f64())
    }

    /// The standard errors of a, b, friction and load, SI; zero for what the model has not got.
    ///
    /// The load is the sum of its part as a parameter and b̂ k_i ω; its error is that of the sum,
    /// with the unrest of the integral.
    #[must_use]
    pub fn standard_errors(
        &self,
        state: &GaussNewtonIdentifierState<N, V::State, P>,
    ) -> ServoParameters {
        let of = |wanted: Parameter| {
            let mut combination = S::PARAMETERS.map(|p| if p == wanted { N::ONE } else { N::ZERO });
            let gain = ModelParameters::of_set::<S, P>(&state.law.estimates()).gain;
            if wanted == Parameter::Load {
                let integral = state.sensitivity.integral();
                for (i, parameter) in S::PARAMETERS.into_iter().enumerate() {
                    combination[i] +=
                        gain * self.model.controller.pid.integral_command(integral[i]);
                    if parameter == Parameter::B {
                        combination[i] += state.load_command;
                    }
                }
            }
            let error = self.law.standard_error(&state.law, &combination);
            let unrest = if wanted == Parameter::Load {
                gain.to_f64() * libm::sqrt(state.load_variance.to_f64())
            } else {
                0.0
            };
            libm::hypot(error, unrest) / wanted.scale(&self.units)
        };
        ServoParameters {
            a: of(Parameter::A),
            b: of(Parameter::B),
            coulomb: of(Parameter::Coulomb),
            load: of(Parameter::Load),
        }
    }

    /// Takes over what a window has found, as the new start.
    pub fn adopt(
        &self,
        state: &mut GaussNewtonIdentifierState<N, V::State, P>,
        found: &Found<N, V::State, P>,
    ) {
        state.model = found.model;
        state.sensitivity = found.sensitivity;
        state.law = self
            .law
            .resume(&found.estimates, &found.covariance, found.unexplained);
    }

    /// Joins a loop in motion, before its next sample: the model moves with the servo. The estimates
    /// and what is known of them are kept, so this also starts another pass over a recording.
    pub fn join(
        &self,
        state: &mut GaussNewtonIdentifierState<N, V::State, P>,
        control: &ControlState<N, V::State>,
    ) {
        state.model = ModelState::alongside(control);
        state.sensitivity = Sensitivity::none();
    }
}
