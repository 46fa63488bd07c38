use super::arithmetic::{
    Fraction, Sum, Weight, Word, is_within, limit, limit_to_half, product, wide,
};
use super::pid::FixedCorrection;
use super::ranges::FullScales;
use super::step::{FixedMotion, FixedStep};
use crate::constants::{Encode, encode};
use crate::control::Gains;
use crate::measurement::velocity::VelocityEstimate;
use crate::parameters::{Parameter, ParameterSet};
use crate::units::Units;
use crate::unrolled::{each, from_fn};

/// The model loop on words, driven by the command that acted as [`ModelLoop`](crate::model::ModelLoop)
/// is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedModelLoop<V> {
    velocity: V,
    correction: FixedCorrection,
    step: FixedStep,
    /// The weight of an increment in the output error.
    weight: Weight,
}

encode! {
    [V: Encode] FixedModelLoop<V> as "FixedModelLoop" { velocity, correction, step, weight }
}

/// State of the model loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedModelState<F> {
    /// ε, of the position's full scale.
    output_error: Sum,
    /// ω.
    integral_error: Sum,
    motion: FixedMotion,
    rate: F,
    acted: FixedModelInputs,
    regressor: FixedRegressorFilter<F>,
}

/// The inputs of the model over the sample just passed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct FixedModelInputs {
    command: Word,
    direction: Word,
    moving: Word,
}

/// The velocity filters of the regressor's entries.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct FixedRegressorFilter<F> {
    velocity: F,
    command: F,
    direction: F,
    moving: F,
}

/// The observation of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedObserved<const P: usize> {
    /// ε, of the position's full scale.
    pub(super) output_error: Word,
    /// ε̇, of twice the velocity's full scale.
    pub(super) rate: Word,
    /// The regressor (9), each entry of its own full scale.
    pub(super) regressor: [Word; P],
}

/// The estimates as they act.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedParameters {
    x: Fraction,
    pub(super) gain: Word,
    pub(super) coulomb: Word,
    pub(super) load: Word,
}

impl FixedParameters {
    #[inline]
    pub(super) fn from_values<S: ParameterSet<P>, const P: usize>(values: &[Sum; P]) -> Self {
        let mut parameters = Self {
            x: Fraction::ZERO,
            gain: Word::ZERO,
            coulomb: Word::ZERO,
            load: Word::ZERO,
        };
        each::<P>(|i| match S::PARAMETERS[i] {
            Parameter::A => parameters.x = values[i].fraction(),
            Parameter::B => parameters.gain = values[i].word(),
            Parameter::Coulomb => parameters.coulomb = values[i].word(),
            Parameter::Load => parameters.load = values[i].word(),
        });
        parameters
    }
}

impl<F: Default> FixedModelState<F> {
    fn at_rest() -> Self {
        Self {
            output_error: Sum::ZERO,
            integral_error: Sum::ZERO,
            motion: FixedMotion::NONE,
            rate: F::default(),
            acted: FixedModelInputs::default(),
            regressor: FixedRegressorFilter::default(),
        }
    }
}

impl<V: VelocityEstimate<Word>> FixedModelLoop<V> {
    pub(super) fn new(velocity: V, units: &Units, gains: &Gains, scales: &FullScales) -> Self {
        Self {
            velocity,
            correction: FixedCorrection::new(units, gains, scales),
            step: FixedStep::new(),
            weight: Weight::new(scales.velocity, scales.position),
        }
    }

    /// At rest at the servo's position.
    pub(super) fn start(&self) -> FixedModelState<V::State> {
        FixedModelState::at_rest()
    }

    /// The state that moves with the servo at a velocity; the correction's integral is kept.
    pub(super) fn alongside(
        &self,
        state: &FixedModelState<V::State>,
        velocity: Word,
    ) -> FixedModelState<V::State> {
        let velocity = limit(velocity);
        FixedModelState {
            motion: FixedMotion {
                increment: velocity,
                velocity: wide(velocity),
            },
            integral_error: state.integral_error,
            ..self.start()
        }
    }

    /// Takes the increment of the servo since the last sample, at most one in magnitude.
    #[inline]
    pub(super) fn observe<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut FixedModelState<V::State>,
        increment: Word,
    ) -> FixedObserved<P> {
        let change = increment - state.motion.increment;
        state.output_error.add(change, self.weight);
        // The filter is linear: of the difference it is the difference of the velocity estimates,
        // and the half of it is a word.
        let rate = self.velocity.process(&mut state.rate, change >> 1);
        let acted = &state.acted;
        let filters = &mut state.regressor;
        let regressor = from_fn(Word::ZERO, |i| match S::PARAMETERS[i] {
            Parameter::A => self
                .velocity
                .process(&mut filters.velocity, state.motion.increment),
            Parameter::B => -self.velocity.process(&mut filters.command, acted.command),
            Parameter::Coulomb => self
                .velocity
                .process(&mut filters.direction, acted.direction),
            Parameter::Load if S::HAS_COULOMB => {
                -self.velocity.process(&mut filters.moving, acted.moving)
            }
            Parameter::Load => -Word::ONE,
        });
        FixedObserved {
            output_error: limit(state.output_error.word()),
            rate,
            regressor,
        }
    }

    /// Moves the model to the next sample under the command that acts until then. The command is limited to half of its
    /// full scale; `rate` is the observed ε̇. True if the model has left its ranges and was restarted at the servo's
    /// position.
    #[inline]
    pub(super) fn advance<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut FixedModelState<V::State>,
        rate: Word,
        command: Word,
        parameters: &FixedParameters,
    ) -> bool {
        let command = self.correction.process(
            &mut state.integral_error,
            limit_to_half(command),
            limit(state.output_error.word()),
            rate,
        );
        let drive = product(parameters.gain, command) + parameters.load;
        let velocity = state.motion.velocity;
        if S::HAS_COULOMB {
            let (motion, phase) =
                self.step
                    .step_with_friction(parameters.x, drive, parameters.coulomb, velocity);
            state.motion = motion;
            state.acted = FixedModelInputs {
                command: product(command, phase.moving),
                direction: phase.direction,
                moving: phase.moving,
            };
        } else {
            state.motion = self.step.step_frictionless(parameters.x, drive, velocity);
            state.acted.command = command;
        }
        self.restart_if_lost(state)
    }

    /// True if friction holds the model.
    #[inline]
    pub(super) fn is_stuck(&self, state: &FixedModelState<V::State>) -> bool {
        state.acted.moving == Word::ZERO
    }

    /// The driving acceleration, of the velocity's full scale: b̂ times the command that acts, plus the estimated load.
    pub(super) fn pushed(
        &self,
        state: &FixedModelState<V::State>,
        command: Word,
        parameters: &FixedParameters,
    ) -> Word {
        let command = limit_to_half(command) + self.load_command(state);
        product(parameters.gain, command) + parameters.load
    }

    /// k_i ω, the load over the gain, of the command's full scale.
    pub(super) fn load_command(&self, state: &FixedModelState<V::State>) -> Word {
        self.correction.load_command(state.integral_error)
    }

    /// Sets the model to the servo's position during standstill; the correction's integral is kept.
    #[inline]
    pub(super) fn hold_at_measurement(&self, state: &mut FixedModelState<V::State>) {
        state.output_error = Sum::ZERO;
    }

    /// Restarts the model at the servo's position if it has left its ranges; true if it did.
    #[inline]
    fn restart_if_lost(&self, state: &mut FixedModelState<V::State>) -> bool {
        let within = is_within(state.output_error.word()) && state.motion.is_within();
        if !within {
            *state = self.start();
        }
        !within
    }
}
