use super::{HeldStep, Motion};
use crate::control::{ControlSample, Pid};
use crate::measurement::velocity::VelocityEstimate;
use crate::number::{Number, RunningSum};

/// The model loop (5)–(7): the same PID, filter, hold and limit around the estimated servo.
///
/// It is computed *relative to the real loop*. Its state is the output error ε = q − q_e and
/// ω = ∑e_e − ∑e rather than q_e and z_e: from e_e = e + ε and z_e = z + ω everything else
/// follows, nothing large is ever subtracted, and the loop needs to know no origin.
///
/// **Limit and load.** The real command carries −d/b that the model's does not, so the model's
/// limits are those of the amplifier shifted by d̂/b̂ = k_i ω. The shift cancels: the model's
/// command is the PID of (e_e, q̇_e, z), limited as the real one, plus k_i ω.
///
/// **Anti-windup.** ω moves by what the model's integral takes minus what the real one takes, each
/// decided by its own limit with the same rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelLoop<N, V> {
    /// The control law, shared with the real loop.
    pub pid: Pid<N>,
    /// The velocity estimate, the same as the real loop's.
    pub velocity: V,
    /// The exact zero-order-hold step.
    pub step: HeldStep<N>,
}

/// What the model loop remembers between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelState<N: Number, S> {
    output_error: N,
    integral_error: N::Sum,
    motion: Motion<N>,
    filter: S,
    command: N,
    command_filter: S,
}

impl<N: Number, S: Default> ModelState<N, S> {
    /// At rest where the servo is.
    #[must_use]
    pub fn at_rest() -> Self {
        Self {
            output_error: N::ZERO,
            integral_error: N::Sum::new(N::ZERO),
            motion: Motion {
                increment: N::ZERO,
                velocity: N::ZERO,
            },
            filter: S::default(),
            command: N::ZERO,
            command_filter: S::default(),
        }
    }
}

/// One sample of the model loop, as the adaptation needs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelSample<N> {
    /// Output error ε = q − q_e.
    pub output_error: N,
    /// Its rate ε̇, the difference of the two velocity estimates.
    pub output_error_rate: N,
    /// The regressor (9), [q̇_e, −u_e], both entries through the velocity filter: what the filter
    /// does to ε̇ it must do to φ, or their product loses its sign at the frequencies that the
    /// filter delays. The velocity is the filter's estimate from q_e; the command is the one that
    /// was held over the sample just passed, like the increment that the estimate is made of.
    pub regressor: [N; 2],
    /// The load over the gain, d̂/b̂ = k_i ω, command units.
    pub load_command: N,
}

impl<N: Number, V: VelocityEstimate<N>> ModelLoop<N, V> {
    /// Takes the real loop's sample and returns the model's of the same instant.
    #[inline]
    pub fn observe(
        &self,
        state: &mut ModelState<N, V::State>,
        real: &ControlSample<N>,
    ) -> ModelSample<N> {
        let output_error = state.output_error + (real.increment - state.motion.increment);
        let velocity = self
            .velocity
            .process(&mut state.filter, state.motion.increment);
        let load_command = self.pid.integral_command(state.integral_error.value());
        let error = real.error + output_error;
        let command = self.pid.command(error, velocity, real.integral);
        state
            .integral_error
            .add(match (command.integrates, real.integrates) {
                (true, true) => output_error,
                (true, false) => error,
                (false, true) => -real.error,
                (false, false) => N::ZERO,
            });
        let filtered_command = self
            .velocity
            .process(&mut state.command_filter, state.command);
        state.command = command.value + load_command;
        state.output_error = output_error;
        ModelSample {
            output_error,
            output_error_rate: real.velocity - velocity,
            regressor: [velocity, -filtered_command],
            load_command,
        }
    }

    /// Moves the model to the next sample under the command of the last observation, with the
    /// estimates x = â T and `gain` = b̂ in machine units.
    ///
    /// False when the model has left the reach of the number format, [`Number::REACH`]: it then
    /// stands still where the servo is, as at the start.
    #[inline]
    #[must_use]
    pub fn advance(&self, state: &mut ModelState<N, V::State>, x: N, gain: N) -> bool {
        state.motion = self
            .step
            .process(x, gain * state.command, state.motion.velocity);
        let in_reach = state.output_error.magnitude() <= N::REACH
            && state.motion.velocity.magnitude() <= N::REACH;
        if !in_reach {
            *state = ModelState::at_rest();
        }
        in_reach
    }
}
