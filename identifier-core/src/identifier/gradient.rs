use core::marker::PhantomData;

use super::config::Promise;
use super::{IdentifierConfig, IdentifierError};
use crate::adaptation::{
    DiagonalGain, FullGain, Gain, GradientConfig, GradientState, GradientUpdate, GradientWith,
    PositiveDefinite,
};
use crate::control::{ControlSample, ControlState, Controller};
use crate::measurement::travel::Travel;
use crate::measurement::velocity::VelocityEstimate;
use crate::model::{ModelLoop, ModelState, ServoParameters};
use crate::number::Number;
use crate::parameters::{ModelParameters, ParameterSet};
use crate::stability::{Certificate, certificate};
use crate::units::Units;

/// What the Γ-gradient law needs besides an [`IdentifierConfig`], SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientLaw<const P: usize> {
    /// Γ for the parameters of the set, in their order.
    pub gamma: PositiveDefinite<P>,
    /// μ, 1/s; none for the automatic one.
    pub mu: Option<f64>,
    /// Parameters that are known and stay at their initial values.
    pub frozen: [bool; P],
}

impl<const P: usize> GradientLaw<P> {
    /// μ as it will be used: the one given, or the automatic one.
    #[must_use]
    pub fn mu(&self, config: &IdentifierConfig) -> f64 {
        self.mu
            .unwrap_or_else(|| certificate::automatic_mu(&config.gains, &config.assumed_box()))
    }
}

/// The paper's identifier: model loop, Γ-gradient law and load estimate, for the parameter set S and
/// a form of Γ, G.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientIdentifierWith<N, V, S, const P: usize, G> {
    model: ModelLoop<N, V>,
    law: GradientWith<N, P, G>,
    travel: Travel<N>,
    initial: [f64; P],
    units: Units,
    promise: Option<Promise>,
    set: PhantomData<S>,
}

/// The paper's identifier with any Γ.
pub type GradientIdentifier<N, V, S, const P: usize> =
    GradientIdentifierWith<N, V, S, P, FullGain<N, P>>;

/// The paper's identifier with a diagonal Γ, which costs less in every sample.
pub type DiagonalGradientIdentifier<N, V, S, const P: usize> =
    GradientIdentifierWith<N, V, S, P, DiagonalGain<N, P>>;

/// What the identifier remembers between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientIdentifierState<N: Number, F, const P: usize> {
    model: ModelState<N, F>,
    law: GradientState<N, P>,
    travelled: N,
    load_command: N,
}

/// What one sample showed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GradientIdentification<N> {
    /// Output error ε = q − q_e, machine units.
    pub output_error: N,
    /// What the law did.
    pub update: GradientUpdate,
    /// True when the model had run out of the number format's reach and starts again where the
    /// servo is; the estimates are kept.
    pub restarted: bool,
}

impl<N, V, S, const P: usize, G> GradientIdentifierWith<N, V, S, P, G>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
    G: Gain<N, P>,
{
    /// Builds the identifier for a velocity estimate, the same that the controller uses.
    ///
    /// # Errors
    /// See [`IdentifierError`]: ranges by name, the certificate's inequality, or the servo of the
    /// box whose sampled loop is unstable.
    pub fn new(
        config: &IdentifierConfig,
        law: &GradientLaw<P>,
        velocity: V,
    ) -> Result<Self, IdentifierError> {
        config.check::<S, P>()?;
        let units = &config.units;
        let mu = law.mu(config);
        let promise = config.certify(mu, &velocity.transfer())?;
        let scale = S::PARAMETERS.map(|parameter| parameter.scale(units) / units.velocity());
        let decay = config.assumed_box().slowest_decay(config.gains.kd());
        let gamma = law.gamma.scaled(scale)?;
        let gradient = GradientConfig {
            gamma,
            mu: mu * units.rate(),
            slowest_decay: decay * units.rate(),
            bounds: config.bounds_of::<S, P>(),
            frozen: law.frozen,
        };
        Ok(Self {
            model: config.model_loop(velocity),
            law: GradientWith::new(G::new(&gamma, law.frozen)?, &gradient)?,
            travel: Travel::new(units),
            initial: config.initial_of::<S, P>(),
            units: *units,
            promise,
            set: PhantomData,
        })
    }

    /// The controller that the model loop has. Closing the real loop with this one, in place of one of
    /// your own, costs fewer instructions, and the two cannot differ.
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

    /// The gain margin of the sampled loop over the box, where a box was given: see
    /// [`sampled_loop::gain_margin`](crate::stability::sampled_loop::gain_margin).
    #[must_use]
    pub fn gain_margin(&self) -> Option<f64> {
        self.promise.map(|promise| promise.gain_margin)
    }

    /// The state at the start: the model at rest where the servo is, the estimates at their
    /// initial values.
    #[must_use]
    pub fn start(&self) -> GradientIdentifierState<N, V::State, P> {
        GradientIdentifierState {
            model: ModelState::at_rest(),
            law: GradientState::new(self.initial),
            travelled: N::ZERO,
            load_command: N::ZERO,
        }
    }

    /// One sample, after the controller's.
    #[inline]
    pub fn process(
        &self,
        state: &mut GradientIdentifierState<N, V::State, P>,
        real: &ControlSample<N>,
    ) -> GradientIdentification<N> {
        self.model.observe(&mut state.model, real);
        let output_error = state.model.output_error();
        // A model that friction can hold has nothing to learn from a servo that stays where it is.
        if S::HAS_COULOMB && self.travel.stays(&mut state.travelled, real.increment) {
            // By value: what is pointed at would have to be in memory in every sample.
            return self.wait(state, *real, output_error);
        }
        self.follow(state, real, output_error, |law, regressor, rate| {
            self.law.update(law, regressor, output_error, rate)
        })
    }

    /// A sample in which nothing is learnt, the model beside the servo.
    #[cold]
    #[inline(never)]
    fn wait(
        &self,
        state: &mut GradientIdentifierState<N, V::State, P>,
        real: ControlSample<N>,
        output_error: N,
    ) -> GradientIdentification<N> {
        self.model.stand_beside(&mut state.model);
        self.follow(state, &real, output_error, |_, _, _| GradientUpdate::Held)
    }

    /// The rest of a sample, with what is learnt from regressor and rate of the output error.
    #[inline]
    fn follow(
        &self,
        state: &mut GradientIdentifierState<N, V::State, P>,
        real: &ControlSample<N>,
        output_error: N,
        learn: impl FnOnce(&mut GradientState<N, P>, &[N; P], N) -> GradientUpdate,
    ) -> GradientIdentification<N> {
        let command = self.model.command(&mut state.model, real);
        let regressor = self.model.regressor::<S, P>(&mut state.model, &command);
        let update = learn(&mut state.law, &regressor, command.output_error_rate);
        let parameters = ModelParameters::of_set::<S, P>(&state.law.estimates());
        let phase = self
            .model
            .advance::<S, P>(&mut state.model, &command, &parameters);
        self.model
            .stand_together(&mut state.model, real, &parameters, phase);
        state.load_command = command.load;
        GradientIdentification {
            output_error,
            update,
            restarted: self.model.restart_if_lost(&mut state.model),
        }
    }

    /// The estimates in SI; the load is the part found as a parameter plus b̂ k_i ∫ε.
    #[must_use]
    pub fn estimates(&self, state: &GradientIdentifierState<N, V::State, P>) -> ServoParameters {
        let parameters = ModelParameters::of_set::<S, P>(&state.law.estimates());
        parameters
            .to_si(&self.units)
            .with_load_of(state.load_command.to_f64())
    }

    /// Joins a loop in motion, before its next sample: the model moves with the servo. The estimates
    /// are kept, so this also starts another pass over a recording.
    pub fn join(
        &self,
        state: &mut GradientIdentifierState<N, V::State, P>,
        control: &ControlState<N, V::State>,
    ) {
        state.model = ModelState::alongside(control);
    }
}
