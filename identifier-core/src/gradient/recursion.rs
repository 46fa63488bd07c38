use core::marker::PhantomData;

use super::certificate::Certificate;
use super::law::{Gradient, GradientStep};
use super::memory::{GradientCorrection, GradientMemory};
use crate::constants::{Encode, encode};
use crate::error::StepError;
use crate::identify::{Event, Identify, MachineEstimates, Update, check};
use crate::interval::Interval;
use crate::measurement::standstill::{Rest, Standstill};
use crate::measurement::velocity::VelocityEstimate;
use crate::model::{FrictionPhase, ModelLoop, ModelState, Observed};
use crate::number::{Arithmetic, Encoded};
use crate::parameters::{
    ModelParameters, Parameter, ParameterSet, PerParameter, PerQuantity, ServoParameters,
    unknowns_fingerprint,
};
use crate::scales::{FullScales, power};
use crate::units::Units;
use crate::unrolled::{each, from_fn};
use crate::windows::{MeasuredPiece, Measuring, Pieces, WindowSettings};

/// The results of the stability checks over the parameter range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StabilityCheck {
    pub(crate) certificate: Certificate,
    pub(crate) gain_margin: f64,
}

encode! {
    [] StabilityCheck as "StabilityCheck" { certificate, gain_margin }
}

/// The paper's identifier for the parameter set S. It has the model loop with its correction in command form, the
/// Γ-gradient estimator and the load estimate.
///
/// It is also the interrupt's half of a [`GradientIdentifier`](super::GradientIdentifier), and gathers the pieces of the
/// motion that the [`GradientMemory`](super::GradientMemory) remembers. Where nobody takes them it is the paper's alone.
///
/// ```text
///   interrupt: GradientRecursion ──► pieces ──────► background: GradientMemory
///                                ◄── corrections ◄──
/// ```
///
/// The halves share no memory. A piece that the background does not take before the next is complete is lost: no window
/// goes across the gap.
///
/// V is the velocity filter that ε̇ and φ pass through. It may differ from the controller's. If it is
/// the same, and no limit acts, this is the paper's loop to the last digit.
///
/// In fixed point increments and commands are fractions of full scales that follow from the settings.
/// [`Identify::increment`] converts counts, [`GradientRecursion::command_word`] command units. A controller built from
/// the same settings has the same full scales.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientRecursion<N: Arithmetic, V, S, const P: usize> {
    pub(crate) model: ModelLoop<N, V>,
    pub(crate) law: Gradient<N, P>,
    pub(crate) pieces: Pieces<N>,
    pub(crate) windows: WindowSettings<N::Real>,
    pub(crate) standstill: Standstill<N>,
    /// The largest increment that is taken.
    pub(crate) most: N,
    pub(crate) increments: N::Counts,
    pub(crate) initial: [N; P],
    pub(crate) bounds: [Interval; P],
    pub(crate) gamma: [f64; P],
    pub(crate) mu: f64,
    pub(crate) scales: FullScales,
    pub(crate) units: Units,
    pub(crate) stability_check: Option<StabilityCheck>,
    pub(crate) set: PhantomData<S>,
}

encode! {
    [N: Encoded, V: Encode, S: ParameterSet<P>, const P: usize]
    GradientRecursion<N, V, S, P> as "GradientRecursion" {
        model, law, pieces, windows, standstill, most, increments, initial, bounds, gamma, mu, scales, units, stability_check, set,
    }
    also unknowns_fingerprint(&S::UNKNOWNS, P)
}

/// State of the identifier between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientRecursionState<N: Arithmetic, F, const P: usize> {
    model: ModelState<N, F>,
    estimates: [N::Sum; P],
    rest: Rest<N>,
    measuring: Measuring<N>,
    /// The load that the windows found.
    load: Option<N>,
}

impl<N: Arithmetic, F, const P: usize> GradientRecursionState<N, F, P> {
    #[inline(always)]
    fn estimates(&self) -> [N; P] {
        from_fn(N::ZERO, |i| N::of_sum(self.estimates[i]))
    }
}

/// Why the estimator's share of a sample is not the usual one.
#[derive(Debug, Clone, Copy)]
enum Exception {
    /// The servo is at standstill.
    Standing,
    /// The guard shortens the step.
    Strong,
    /// An estimate has left its range.
    Outside,
}

/// The estimates of a sample, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientEstimates<N, const P: usize> {
    parameters: [N; P],
    /// The part of the load that the correction's integral carries, command units.
    load_command: N,
    /// The load that the windows found.
    load: Option<N>,
}

/// Its state, by the velocity filter.
type StateOf<N, V, const P: usize> =
    GradientRecursionState<N, <V as VelocityEstimate<N>>::State, P>;

impl<N, V, S, const P: usize> GradientRecursion<N, V, S, P>
where
    N: Arithmetic,
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

    /// The diagonal of Γ over the parameters of the set, SI.
    #[must_use]
    pub fn gamma(&self) -> &[f64; P] {
        &self.gamma
    }

    /// The bounds that an estimate is kept in, SI; none for a parameter that the model does not have.
    #[must_use]
    pub fn bounds(&self, wanted: Parameter) -> Option<Interval> {
        let mut own = S::PARAMETERS.into_iter().zip(self.bounds);
        own.find(|(parameter, _)| *parameter == wanted)
            .map(|(_, bounds)| bounds)
    }

    /// A command in command units as the identifier computes with it. In fixed point it saturates, and is zero for NaN.
    #[must_use]
    pub fn command_word(&self, command: f64) -> N {
        N::signal(command, self.scales.command).saturated_to_half()
    }

    /// A command as a number, command units.
    #[must_use]
    pub fn command(&self, command: N) -> f64 {
        command.value(self.scales.command)
    }

    /// The output error of a sample as a number, counts (position units).
    #[must_use]
    pub fn output_error(&self, seen: &Update<N>) -> f64 {
        seen.output_error.value(self.scales.position)
    }

    /// The piece of the motion that the last sample completed, if it did.
    #[inline]
    pub fn take_piece(&self, state: &mut StateOf<N, V, P>) -> Option<MeasuredPiece<N>> {
        state.measuring.take()
    }

    /// The background's half.
    #[must_use]
    pub fn memory(&self) -> GradientMemory<N> {
        GradientMemory {
            pieces: self.pieces,
            windows: self.windows,
            scales: self.scales,
            units: self.units,
        }
    }

    /// Takes over a correction of the memory. It moves the estimates closer to the servo in the norm of Γ⁻¹, in which the
    /// bounds do not take them away from it again. Output error and model stay, so the storage function (12) falls, and the
    /// certificate holds.
    pub fn take_over(&self, state: &mut StateOf<N, V, P>, correction: &GradientCorrection<N>) {
        each::<P>(|i| {
            if S::PARAMETERS[i] != Parameter::Load {
                state.estimates[i] = correction.estimates.get(S::PARAMETERS[i]).sum();
            }
        });
        self.law.projection.apply(&mut state.estimates);
        state.load = Some(correction.estimates.load);
    }

    /// Nothing is learnt; a model with friction is set to the servo's position.
    fn stand(&self, state: &mut StateOf<N, V, P>, command: N) -> Event {
        if S::HAS_COULOMB {
            state.model.hold_at_measurement();
        }
        let should_move = self.should_move(state, command);
        if self
            .standstill
            .is_stuck_under_command(&mut state.rest, should_move)
        {
            Event::NotFollowing
        } else {
            Event::Standing
        }
    }

    /// True if a command overcomes load and friction by the estimates.
    fn should_move(&self, state: &StateOf<N, V, P>, command: N) -> bool {
        let parameters = ModelParameters::from_values::<S, P>(&state.estimates());
        let pushed = self.model.drive(&state.model, command, &parameters);
        // Twice the friction, so that estimates that have not settled raise no false alarm, and more
        // than the encoder's resolution hides.
        let hidden = self.standstill.hidden_acceleration();
        pushed.magnitude() > parameters.coulomb + parameters.coulomb + hidden
    }

    /// The estimator's share of a sample; the exception if it is not the usual one.
    #[inline(always)]
    fn learn_from(
        &self,
        state: &mut StateOf<N, V, P>,
        increment: N,
        observed: &Observed<N, P>,
    ) -> Option<Exception> {
        // At standstill nothing can be learnt: it must not be mistaken for a small b when the
        // amplifier is off, and a slip within the friction's band shows nothing.
        let is_still = if S::HAS_COULOMB {
            self.standstill.is_still(&mut state.rest, increment)
        } else {
            self.standstill.is_at_rest(&mut state.rest, increment)
        };
        if is_still {
            return Some(Exception::Standing);
        }
        let update = self.step(state, observed);
        if !update.is_gentle() {
            return Some(Exception::Strong);
        }
        self.law.add(&mut state.estimates, &update);
        let is_inside = self.law.projection.surely_contains(&state.estimates);
        (!is_inside).then_some(Exception::Outside)
    }

    /// The estimator's step.
    #[inline(always)]
    fn step(&self, state: &StateOf<N, V, P>, observed: &Observed<N, P>) -> GradientStep<N, P> {
        let gain = ModelParameters::from_values::<S, P>(&state.estimates()).gain;
        let (output_error, rate) = (observed.output_error, observed.rate);
        self.law
            .update(&observed.regressor, output_error, rate, gain)
    }

    /// The model's share of a sample.
    #[inline(always)]
    fn advance(
        &self,
        state: &mut StateOf<N, V, P>,
        observed: &Observed<N, P>,
        command: N,
        event: Event,
    ) -> Update<N> {
        let parameters = ModelParameters::from_values::<S, P>(&state.estimates());
        let phase =
            self.model
                .advance::<S, P>(&mut state.model, observed.rate, command, &parameters);
        // In floating point the guard acts before the model can leave its range.
        let may_be_lost = N::IS_FIXED || event != Event::None;
        let is_lost = may_be_lost && state.model.restart_if_lost();
        if is_lost {
            state.measuring.lose();
        }
        if S::HAS_COULOMB && phase == FrictionPhase::Stuck {
            state.measuring.stick();
            if self.standstill.is_paused(&state.rest) {
                state.model.hold_at_measurement();
            }
        }
        Update {
            output_error: observed.output_error,
            event: if is_lost { Event::Restarted } else { event },
        }
    }

    /// The rest of a sample with an exception. By value and with a model of its own: so the usual sample keeps its numbers
    /// in registers.
    #[cold]
    #[inline(never)]
    fn advance_rarely(
        &self,
        state: &mut StateOf<N, V, P>,
        observed: Observed<N, P>,
        command: N,
        exception: Exception,
    ) -> Update<N> {
        let event = match exception {
            Exception::Standing => {
                state.measuring.lose();
                self.stand(state, command)
            }
            Exception::Strong => {
                let update = self.step(state, &observed);
                self.law.shorten(&mut state.estimates, &update);
                Event::Slowed
            }
            Exception::Outside => {
                self.law.projection.apply(&mut state.estimates);
                Event::None
            }
        };
        self.advance(state, &observed, command, event)
    }
}

impl<N, V, S, const P: usize> Identify<N> for GradientRecursion<N, V, S, P>
where
    N: Arithmetic,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    type State = StateOf<N, V, P>;
    type Snapshot = GradientEstimates<N, P>;

    fn start(&self) -> Self::State {
        GradientRecursionState {
            model: ModelState::at_rest(),
            estimates: self.initial.map(N::sum),
            rest: self.standstill.at_rest(),
            measuring: self.pieces.start(),
            load: None,
        }
    }

    #[inline]
    fn increment(&self, moved: i32) -> N {
        N::increment(moved, self.increments)
    }

    #[inline]
    fn check(&self, increment: N, command: N) -> Result<(), StepError> {
        check(increment, command, self.most)
    }

    /// In fixed point values beyond their full scales saturate.
    #[inline(always)]
    fn update(&self, state: &mut Self::State, increment: N, command: N) -> Update<N> {
        let increment = increment.saturated();
        let direction = S::HAS_COULOMB.then(|| state.model.direction());
        if state.measuring.add(increment, direction) {
            let output_error = self.model.output_error(&state.model);
            state.measuring.complete(&self.pieces, output_error);
        }
        state.measuring.hold(command.saturated_to_half());
        let observed = self.model.observe::<S, P>(&mut state.model, increment);
        match self.learn_from(state, increment, &observed) {
            None => self.advance(state, &observed, command, Event::None),
            Some(exception) => self.advance_rarely(state, observed, command, exception),
        }
    }

    #[inline]
    fn snapshot(&self, state: &Self::State) -> Self::Snapshot {
        GradientEstimates {
            parameters: state.estimates(),
            load_command: self.model.load_command(&state.model),
            load: state.load,
        }
    }

    /// The load is that of the windows, and before they have one the parameter d̂ plus b̂ k_i ∫ε.
    fn estimates_in(&self, shown: &Self::Snapshot) -> ServoParameters {
        let machine = PerParameter::of_set::<S, P>(&shown.parameters, N::ZERO);
        let unit = PerQuantity::machine(&self.units);
        let si = |wanted: Parameter| {
            let value = machine.get(wanted).value(self.scales.estimate(wanted));
            value / unit.get(wanted.into())
        };
        let load = |own| match shown.load {
            Some(found) => found.value(self.scales.estimate(Parameter::Load)) / unit.acceleration,
            None => own,
        };
        let own = PerParameter::from_fn(si).with_load_of(self.command(shown.load_command));
        PerParameter {
            load: load(own.load),
            ..own
        }
    }

    fn at_bounds_in(&self, shown: &Self::Snapshot) -> PerParameter<bool> {
        let at = self.law.at_bounds(&shown.parameters);
        PerParameter::from_fn(|wanted| {
            let place = S::PARAMETERS.iter().position(|&own| own == wanted);
            place.is_some_and(|place| at[place])
        })
    }

    fn resume_moving(&self, state: &mut Self::State, increment: N) {
        state.model = state.model.alongside(increment);
        state.measuring.interrupt(&self.pieces);
    }
}

impl<N, V, S, const P: usize> MachineEstimates<N> for GradientRecursion<N, V, S, P>
where
    N: Arithmetic,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    #[inline]
    fn machine_estimates(&self, state: &Self::State) -> PerParameter<N> {
        let shown = self.snapshot(state);
        let machine = PerParameter::of_set::<S, P>(&shown.parameters, N::ZERO);
        PerParameter {
            load: match shown.load {
                Some(found) => found,
                None => machine.load + machine.b.part(shown.load_command),
            },
            ..machine
        }
    }

    fn machine_unit(&self, parameter: Parameter) -> f64 {
        let full = if N::IS_FIXED {
            power(self.scales.estimate(parameter))
        } else {
            1.0
        };
        full / parameter.scale(&self.units)
    }
}
