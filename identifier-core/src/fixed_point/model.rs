use super::arithmetic::{
    ACCUMULATOR_BITS, Accumulator, WORD_BITS, Word, between, limit, narrow, product, rounded_right,
    saturating_left, shifted, wide, word_product,
};
use super::controller::FixedControlSample;
use super::pid::{ErrorSum, FixedPid};
use super::ranges::Scales;
use super::step::{FixedMotion, FixedPhase, FixedStep};
use super::velocity::FixedVelocity;
use crate::parameters::{Parameter, ParameterSet};

/// The model loop on words, relative to the real loop as [`ModelLoop`](crate::model::ModelLoop) is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedModelLoop<V> {
    pub(super) pid: FixedPid,
    pub(super) velocity: V,
    pub(super) step: FixedStep,
    pub(super) scales: Scales,
}

/// What the model loop remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedModelState<F> {
    /// ε, with `scales.fine` fraction bits below the velocity's full scale.
    output_error: i64,
    integral_error: ErrorSum,
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
            output_error: 0,
            integral_error: 0,
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
    pub(super) output_error_rate: Accumulator,
    pub(super) velocity: Word,
}

/// The estimates as words of their own full scales.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedParameters {
    x: Word,
    gain: Word,
    coulomb: Word,
    load: Word,
}

impl FixedParameters {
    pub(super) fn of_set<S: ParameterSet<P>, const P: usize>(values: &[Accumulator; P]) -> Self {
        let mut parameters = Self {
            x: Word::ZERO,
            gain: Word::ZERO,
            coulomb: Word::ZERO,
            load: Word::ZERO,
        };
        for (parameter, &value) in S::PARAMETERS.iter().zip(values) {
            let word = narrow(value);
            match parameter {
                Parameter::A => parameters.x = word,
                Parameter::B => parameters.gain = word,
                Parameter::Coulomb => parameters.coulomb = word,
                Parameter::Load => parameters.load = word,
            }
        }
        parameters
    }
}

impl<V: FixedVelocity> FixedModelLoop<V> {
    /// Brings the output error to this sample: both positions have moved.
    #[inline]
    pub(super) fn observe(&self, state: &mut FixedModelState<V::State>, real: &FixedControlSample) {
        let Scales { velocity, fine, .. } = self.scales;
        let moved = saturating_left(i64::from(real.increment), (fine - velocity).unsigned_abs());
        let model = rounded_right(
            state.motion.increment.to_bits(),
            (ACCUMULATOR_BITS - fine).unsigned_abs(),
        );
        state.output_error = state
            .output_error
            .saturating_add(moved.saturating_sub(model));
    }

    /// ε as a word of the position's full scale.
    #[inline]
    pub(super) fn output_error(&self, state: &FixedModelState<V::State>) -> Word {
        let bits = rounded_right(state.output_error, self.error_shift());
        let one = i64::from(Word::ONE.to_bits());
        Word::from_bits(between(bits, -one, one) as i32)
    }

    #[inline]
    fn error_shift(&self) -> u32 {
        let Scales {
            position,
            velocity,
            fine,
            ..
        } = self.scales;
        (fine - velocity + position - WORD_BITS).unsigned_abs()
    }

    /// The model's command for this sample.
    #[inline]
    pub(super) fn command(
        &self,
        state: &mut FixedModelState<V::State>,
        real: &FixedControlSample,
    ) -> FixedModelCommand {
        let estimate = self
            .velocity
            .process(&mut state.filter, narrow(state.motion.increment));
        let velocity = narrow(estimate);
        let load = narrow(self.pid.integral_command(state.integral_error));
        let output_error = self.output_error(state);
        let error = limit(real.error.saturating_add(output_error));
        let command = self.pid.command(error, velocity, real.integral);
        let gathered = match (command.integrates, real.integrates) {
            (true, true) => output_error,
            (true, false) => error,
            (false, true) => -real.error,
            (false, false) => Word::ZERO,
        };
        self.pid.gather(&mut state.integral_error, gathered);
        FixedModelCommand {
            value: limit(command.value.saturating_add(load)),
            load,
            output_error_rate: real.velocity.saturating_sub(estimate),
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
        let through = |filter: &mut V::State, x: Word| narrow(self.velocity.process(filter, x));
        S::PARAMETERS.map(|parameter| match parameter {
            Parameter::A => command.velocity,
            Parameter::B => -through(&mut filters.command, u),
            Parameter::Coulomb => through(&mut filters.direction, direction),
            Parameter::Load if S::HAS_COULOMB => -through(&mut filters.moving, moving),
            Parameter::Load => -Word::ONE,
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
        let Scales {
            command: of_command,
            acceleration,
            gain,
            coulomb,
            load,
            ..
        } = self.scales;
        let drive = shifted(
            product(parameters.gain, command.value),
            gain + of_command - acceleration,
        )
        .saturating_add(shifted(wide(parameters.load), load - acceleration));
        if S::HAS_COULOMB {
            let friction = shifted(wide(parameters.coulomb), coulomb - acceleration);
            let (motion, FixedPhase { direction, moving }) =
                self.step
                    .rub(parameters.x, drive, friction, state.motion.velocity);
            state.motion = motion;
            let stuck = moving == Word::ZERO && motion == FixedMotion::NONE;
            if stuck && self.servo_stands(real, parameters, friction) {
                self.stand_beside(state);
            }
            state.acted = Acted {
                command: word_product(command.value, moving),
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
        state.output_error = 0;
    }

    /// Whether friction outweighs all damping of the servo, (a + b kd) |q̇| ≤ c: see
    /// [`ModelLoop::stand_together`](crate::model::ModelLoop::stand_together).
    #[inline]
    fn servo_stands(
        &self,
        real: &FixedControlSample,
        parameters: &FixedParameters,
        friction: Accumulator,
    ) -> bool {
        let Scales {
            command,
            acceleration,
            gain,
            rate,
            velocity: of_velocity,
            ..
        } = self.scales;
        let velocity = narrow(real.velocity);
        let of_loop = shifted(
            product(parameters.gain, narrow(self.pid.damping(velocity))),
            gain + command - acceleration,
        );
        let own = shifted(
            product(parameters.x, velocity),
            rate + of_velocity - acceleration,
        );
        own.saturating_add(of_loop).saturating_abs() <= friction
    }

    /// Starts the model again where the servo is if its output error has left the range; true if
    /// it had to.
    #[inline]
    pub(super) fn restart_if_lost(&self, state: &mut FixedModelState<V::State>) -> bool {
        let most = saturating_left(i64::from(Word::ONE.to_bits()), self.error_shift());
        let lost = state.output_error.saturating_abs() > most;
        if lost {
            *state = FixedModelState::at_rest();
        }
        lost
    }
}
