use super::arithmetic::{FULL, Fraction, Sum, Weight, Word, limit, product};
use super::controller::{FixedControlSample, FixedController};
use super::ranges::Scales;
use super::step::{FixedMotion, FixedPhase, FixedStep};
use super::velocity::FixedVelocity;
use crate::parameters::{Parameter, ParameterSet};

/// The model loop on words, relative to the real loop as [`ModelLoop`](crate::model::ModelLoop) is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedModelLoop<V> {
    /// Velocity estimate and control law: those of the real loop.
    pub(super) controller: FixedController<V>,
    step: FixedStep,
    /// Of an increment in the output error.
    weight: Weight,
}

/// What the model loop remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedModelState<F> {
    /// ε, of the position's full scale.
    output_error: Sum,
    /// ω.
    integral_error: Sum,
    motion: FixedMotion,
    filter: F,
    acted: Acted<Word>,
    regressor_filter: Acted<F>,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Acted<X> {
    command: X,
    direction: X,
    moving: X,
}

impl<F: Default> FixedModelState<F> {
    pub(super) fn at_rest() -> Self {
        Self {
            output_error: Sum::ZERO,
            integral_error: Sum::ZERO,
            motion: FixedMotion::NONE,
            filter: F::default(),
            acted: Acted {
                command: Word::ZERO,
                direction: Word::ZERO,
                moving: Word::ZERO,
            },
            regressor_filter: Acted {
                command: F::default(),
                direction: F::default(),
                moving: F::default(),
            },
        }
    }
}

/// The model's command of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedModelCommand {
    pub(super) value: Word,
    /// k_i ω, of the command's full scale.
    pub(super) load: Word,
    /// ε̇, at most twice the velocity's full scale.
    pub(super) output_error_rate: Word,
    pub(super) velocity: Word,
}

/// The estimates as they act.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedParameters {
    x: Fraction,
    gain: Word,
    coulomb: Word,
    load: Word,
}

impl FixedParameters {
    #[inline]
    pub(super) fn of_set<S: ParameterSet<P>, const P: usize>(values: &[Sum; P]) -> Self {
        let mut parameters = Self {
            x: Fraction::ZERO,
            gain: Word::ZERO,
            coulomb: Word::ZERO,
            load: Word::ZERO,
        };
        for (parameter, &value) in S::PARAMETERS.iter().zip(values) {
            match parameter {
                Parameter::A => parameters.x = value.fraction(),
                Parameter::B => parameters.gain = value.word(),
                Parameter::Coulomb => parameters.coulomb = value.word(),
                Parameter::Load => parameters.load = value.word(),
            }
        }
        parameters
    }
}

impl<V: FixedVelocity> FixedModelLoop<V> {
    pub(super) fn new(controller: FixedController<V>, scales: &Scales) -> Self {
        Self {
            controller,
            step: FixedStep::new(),
            weight: Weight::new(scales.velocity, scales.position),
        }
    }

    /// Brings the output error to this sample: both positions have moved.
    #[inline]
    pub(super) fn observe(&self, state: &mut FixedModelState<V::State>, real: &FixedControlSample) {
        let moved = real.increment - state.motion.increment;
        state.output_error.add(moved, self.weight);
    }

    /// ε as a word of the position's full scale.
    #[inline]
    pub(super) fn output_error(&self, state: &FixedModelState<V::State>) -> Word {
        limit(state.output_error.word())
    }

    /// The model's command for this sample.
    #[inline]
    pub(super) fn command(
        &self,
        state: &mut FixedModelState<V::State>,
        real: &FixedControlSample,
    ) -> FixedModelCommand {
        let velocity = self
            .controller
            .velocity
            .process(&mut state.filter, state.motion.increment);
        let load = self
            .controller
            .pid
            .integral_command(state.integral_error.word());
        let output_error = self.output_error(state);
        let error = limit(real.error + output_error);
        let command = self.controller.pid.command(error, velocity, real.integral);
        let gathered = match (command.integrates, real.integrates) {
            (true, true) => output_error,
            (true, false) => error,
            (false, true) => -real.error,
            (false, false) => Word::ZERO,
        };
        self.controller
            .pid
            .gather(&mut state.integral_error, gathered);
        FixedModelCommand {
            value: command.value + load,
            load,
            output_error_rate: real.velocity - velocity,
            velocity,
        }
    }

    /// The regressor (9), each entry of its own full scale.
    #[inline]
    pub(super) fn regressor<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut FixedModelState<V::State>,
        command: &FixedModelCommand,
    ) -> [Word; P] {
        let Acted {
            command: u,
            direction,
            moving,
        } = state.acted;
        let filters = &mut state.regressor_filter;
        S::PARAMETERS.map(|parameter| match parameter {
            Parameter::A => command.velocity,
            Parameter::B => -self.controller.velocity.process(&mut filters.command, u),
            Parameter::Coulomb => self
                .controller
                .velocity
                .process(&mut filters.direction, direction),
            Parameter::Load if S::HAS_COULOMB => -self
                .controller
                .velocity
                .process(&mut filters.moving, moving),
            Parameter::Load => -FULL,
        })
    }

    /// Moves the model to the next sample under its held command.
    #[inline]
    pub(super) fn advance<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut FixedModelState<V::State>,
        real: &FixedControlSample,
        command: &FixedModelCommand,
        parameters: &FixedParameters,
    ) {
        let drive = product(parameters.gain, command.value) + parameters.load;
        if S::HAS_COULOMB {
            let (motion, FixedPhase { direction, moving }) = self.step.rub(
                parameters.x,
                drive,
                parameters.coulomb,
                state.motion.velocity,
            );
            state.motion = motion;
            let stuck = moving == Word::ZERO && motion == FixedMotion::NONE;
            if stuck && self.servo_stands(real, parameters) {
                self.stand_beside(state);
            }
            state.acted = Acted {
                command: product(command.value, moving),
                direction,
                moving,
            };
        } else {
            state.motion = self.step.slide(parameters.x, drive, state.motion.velocity);
            state.acted.command = command.value;
        }
    }

    /// Puts the model where the servo is; what its integral has gathered stays.
    #[inline]
    pub(super) fn stand_beside(&self, state: &mut FixedModelState<V::State>) {
        state.output_error = Sum::ZERO;
    }

    /// Whether friction outweighs all damping of the servo, (a + b kd) |q̇| ≤ c: see
    /// [`ModelLoop::stand_together`](crate::model::ModelLoop::stand_together).
    #[inline]
    fn servo_stands(&self, real: &FixedControlSample, parameters: &FixedParameters) -> bool {
        let of_loop = product(parameters.gain, self.controller.pid.damping(real.velocity));
        let own = parameters.x.times(real.velocity);
        let damping =
            i64::from(own.to_bits()) + (i64::from(of_loop.to_bits()) << self.controller.pid.up());
        damping.abs() <= i64::from(parameters.coulomb.to_bits())
    }

    /// Starts the model again where the servo is if it has left its ranges; true if it had to.
    #[inline]
    pub(super) fn restart_if_lost(&self, state: &mut FixedModelState<V::State>) -> bool {
        let output_error = state.output_error.word();
        let within = output_error <= FULL && output_error >= -FULL && state.motion.is_within();
        if !within {
            *state = FixedModelState::at_rest();
        }
        !within
    }
}
