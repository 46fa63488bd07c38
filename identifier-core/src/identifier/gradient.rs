use core::marker::PhantomData;

use super::identify::check;
use super::{Event, Identify, MachineEstimates, Update};
use crate::adaptation::{Gradient, GradientState, GradientStep};
use crate::constants::{Encode, encode};
use crate::control::ControlSample;
use crate::error::StepError;
use crate::interval::Interval;
use crate::measurement::standstill::{Rest, Standstill};
use crate::measurement::velocity::VelocityEstimate;
use crate::model::{CommandCorrection, Correction, FrictionPhase, ModelLoop, ModelState, Observed};
use crate::number::Number;
use crate::parameters::{
    ModelParameters, Parameter, ParameterSet, PerParameter, ServoParameters, set_fingerprint,
};
use crate::stability::{Certificate, StabilityCheck};
use crate::units::Units;

/// The paper's identifier for the parameter set S. It has the model loop with its correction in command form, the
/// Γ-gradient estimator and the load estimate.
///
/// V is the velocity filter that ε̇ and φ pass through. It may differ from the controller's. If it is
/// the same, and no limit acts, this is the paper's loop to the last digit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientIdentifier<N, V, S, const P: usize> {
    pub(crate) model: ModelLoop<N, V, CommandCorrection<N>>,
    pub(crate) law: Gradient<N, P>,
    pub(crate) standstill: Standstill<N>,
    pub(crate) most: N,
    pub(crate) initial: [f64; P],
    pub(crate) bounds: [Interval; P],
    pub(crate) gamma: [[f64; P]; P],
    pub(crate) mu: f64,
    pub(crate) units: Units,
    pub(crate) stability_check: Option<StabilityCheck>,
    pub(crate) set: PhantomData<S>,
}

encode! {
    [N: Encode, V: Encode, S: ParameterSet<P>, const P: usize]
    GradientIdentifier<N, V, S, P> as "GradientIdentifier" {
        model, law, standstill, most, initial, bounds, gamma, mu, units, stability_check, set,
    }
    also set_fingerprint(&S::PARAMETERS)
}

type CorrectionState<N> = <CommandCorrection<N> as Correction<N>>::State;

/// State of the identifier between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientIdentifierState<N: Number, F, const P: usize> {
    model: ModelState<N, F, CorrectionState<N>>,
    law: GradientState<N, P>,
    rest: Rest<N>,
}

/// The estimates of a sample, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientEstimates<N, const P: usize> {
    parameters: [N; P],
    /// The part of the load that the correction's integral carries, command units.
    load_command: N,
}

impl<N, V, S, const P: usize> GradientIdentifier<N, V, S, P>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    /// The certificate of the parameter range; none without one.
    #[must_use]
    pub fn certificate(&self) -> Option<&Certificate> {
        self.stability_check
            .as_ref()
            .map(|stability_check| &stability_check.certificate)
    }

    /// The gain margin of the sampled loop over the parameter range; none without one. See
    /// [`SampledLoop::gain_margin`](crate::stability::SampledLoop::gain_margin).
    #[must_use]
    pub fn gain_margin(&self) -> Option<f64> {
        self.stability_check
            .map(|stability_check| stability_check.gain_margin)
    }

    /// The μ in use, 1/s: the one given, or the automatic one.
    #[must_use]
    pub fn mu(&self) -> f64 {
        self.mu
    }

    /// Γ over the parameters of the set, SI.
    #[must_use]
    pub fn gamma(&self) -> &[[f64; P]; P] {
        &self.gamma
    }

    /// The bounds that an estimate is kept in, SI; none for a parameter that the model does not have.
    #[must_use]
    pub fn bounds(&self, wanted: Parameter) -> Option<Interval> {
        let mut own = S::PARAMETERS.into_iter().zip(self.bounds);
        own.find(|(parameter, _)| *parameter == wanted)
            .map(|(_, bounds)| bounds)
    }

    /// Nothing is learnt; a model with friction is set to the servo's position.
    #[cold]
    #[inline(never)]
    fn stand(&self, state: &mut GradientIdentifierState<N, V::State, P>, command: N) -> Event {
        if S::HAS_COULOMB {
            self.model.hold_at_measurement(&mut state.model);
        }
        let should_move = self.should_move(state, command);
        if self.standstill.resists(&mut state.rest, should_move) {
            Event::NotFollowing
        } else {
            Event::Standing
        }
    }

    /// True if a command overcomes load and friction by the estimates.
    fn should_move(&self, state: &GradientIdentifierState<N, V::State, P>, command: N) -> bool {
        let ModelParameters {
            gain,
            coulomb,
            load,
            ..
        } = ModelParameters::from_values::<S, P>(&state.law.estimates());
        let pushed = gain * (command + self.model.load_command(&state.model)) + load;
        // Twice the friction, so that estimates that have not settled raise no false alarm, and more
        // than the encoder's resolution hides.
        let hidden = self.standstill.hidden_acceleration();
        pushed.magnitude() > coulomb + coulomb + hidden
    }

    /// The guard shortens the estimator's step.
    #[cold]
    #[inline(never)]
    fn learn_slowly(
        &self,
        state: &mut GradientIdentifierState<N, V::State, P>,
        rate: N,
        regressor: [N; P],
    ) -> Event {
        let output_error = self.model.output_error(&state.model);
        let update = self.update(state, output_error, rate, &regressor);
        self.law.shorten(&mut state.law, &update);
        Event::Slowed
    }

    /// The event, where the model may have left its range: the guard acts before that.
    #[cold]
    #[inline(never)]
    fn restart_if_lost(
        &self,
        state: &mut GradientIdentifierState<N, V::State, P>,
        event: Event,
    ) -> Event {
        if self.model.restart_if_lost(&mut state.model) {
            Event::Restarted
        } else {
            event
        }
    }

    /// The rest of a sample, from its observation.
    #[inline]
    fn learn_from(
        &self,
        state: &mut GradientIdentifierState<N, V::State, P>,
        observed: Observed<N, P>,
        increment: N,
        command: N,
    ) -> Update<N> {
        let Observed {
            output_error,
            rate,
            regressor,
        } = observed;
        // At standstill nothing can be learnt: it must not be mistaken for a small b when the
        // amplifier is off, and a slip within the friction's band shows nothing.
        let stands = if S::HAS_COULOMB {
            self.standstill.stands(&mut state.rest, increment)
        } else {
            self.standstill.rests(&mut state.rest, increment)
        };
        let event = if stands {
            self.stand(state, command)
        } else {
            let update = self.update(state, output_error, rate, &regressor);
            if update.is_gentle() {
                self.law.take(&mut state.law, &update);
                Event::None
            } else {
                // By value: with a reference, the compiler would keep it in memory in every sample.
                self.learn_slowly(state, rate, regressor)
            }
        };
        let parameters = ModelParameters::from_values::<S, P>(&state.law.estimates());
        let phase = self
            .model
            .advance::<S, P>(&mut state.model, rate, command, &parameters);
        if S::HAS_COULOMB && phase == FrictionPhase::Stuck && self.standstill.pauses(&state.rest) {
            self.model.hold_at_measurement(&mut state.model);
        }
        let event = match event {
            Event::None => event,
            other => self.restart_if_lost(state, other),
        };
        Update {
            output_error,
            event,
        }
    }

    /// The estimator's step.
    #[inline]
    fn update(
        &self,
        state: &GradientIdentifierState<N, V::State, P>,
        output_error: N,
        rate: N,
        regressor: &[N; P],
    ) -> GradientStep<N, P> {
        let gain = ModelParameters::from_values::<S, P>(&state.law.estimates()).gain;
        self.law.update(regressor, output_error, rate, gain)
    }
}

impl<N, V, S, const P: usize> Identify<N> for GradientIdentifier<N, V, S, P>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    type State = GradientIdentifierState<N, V::State, P>;
    type Snapshot = GradientEstimates<N, P>;

    fn start(&self) -> Self::State {
        GradientIdentifierState {
            model: self.model.start(),
            law: GradientState::new(self.initial),
            rest: self.standstill.at_rest(),
        }
    }

    #[inline]
    fn increment(&self, moved: i32) -> N {
        N::from_count(moved)
    }

    #[inline]
    fn check(&self, increment: N, command: N) -> Result<(), StepError> {
        check(increment, command, self.most)
    }

    #[inline]
    fn update(&self, state: &mut Self::State, increment: N, command: N) -> Update<N> {
        let observed = self.model.observe::<S, P>(&mut state.model, increment);
        self.learn_from(state, observed, increment, command)
    }

    #[inline]
    fn update_with_velocity(
        &self,
        state: &mut Self::State,
        sample: &ControlSample<N>,
    ) -> Update<N> {
        let observed =
            self.model
                .observe_beside::<S, P>(&mut state.model, sample.increment, sample.velocity);
        self.learn_from(state, observed, sample.increment, sample.command)
    }

    #[inline]
    fn snapshot(&self, state: &Self::State) -> Self::Snapshot {
        GradientEstimates {
            parameters: state.law.estimates(),
            load_command: self.model.load_command(&state.model),
        }
    }

    /// The load is the parameter d̂ plus b̂ k_i ∫ε.
    fn estimates_in(&self, shown: &Self::Snapshot) -> ServoParameters {
        ModelParameters::from_values::<S, P>(&shown.parameters)
            .to_si(&self.units)
            .with_load_of(shown.load_command.to_f64())
    }

    fn at_bounds_in(&self, shown: &Self::Snapshot) -> PerParameter<bool> {
        let at = self.law.at_bounds(&shown.parameters);
        PerParameter::from_fn(|wanted| {
            let place = S::PARAMETERS.iter().position(|&own| own == wanted);
            place.is_some_and(|place| at[place])
        })
    }

    fn resume_moving(&self, state: &mut Self::State, increment: N) {
        state.model = self.model.alongside(&state.model, increment);
    }
}

impl<N, V, S, const P: usize> MachineEstimates<N> for GradientIdentifier<N, V, S, P>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    #[inline]
    fn machine_estimates(&self, state: &Self::State) -> PerParameter<N> {
        let shown = self.snapshot(state);
        let mut machine = ModelParameters::from_values::<S, P>(&shown.parameters);
        machine.load += machine.gain * shown.load_command;
        machine.per_parameter()
    }

    fn machine_unit(&self, parameter: Parameter) -> f64 {
        1.0 / parameter.scale(&self.units)
    }
}
