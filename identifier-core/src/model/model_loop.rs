use super::{FrictionStep, Motion, Phase};
use crate::control::{ControlSample, ControlState, Controller};
use crate::measurement::velocity::VelocityEstimate;
use crate::number::{Number, RunningSum};
use crate::parameters::{ModelParameters, Parameter, ParameterSet};

/// The model loop (5)–(7): the same PID, filter, hold and limit around the estimated servo.
///
/// It is computed *relative to the real loop*. Its state is the output error ε = q − q_e and
/// ω = ∑e_e − ∑e rather than q_e and z_e: from e_e = e + ε and z_e = z + ω everything else
/// follows, nothing large is ever subtracted, and the loop needs to know no origin.
///
/// **Limit and load.** A load that is no parameter of the model is carried by the real command as
/// −d/b and by the model's not, so the model's limits are those of the amplifier shifted by
/// d̂/b̂ = k_i ω. The shift cancels: the model's command is the PID of (e_e, q̇_e, z), limited as the
/// real one, plus k_i ω.
///
/// **Anti-windup.** ω moves by what the model's integral takes minus what the real one takes, each
/// decided by its own limit with the same rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelLoop<N, V> {
    /// Velocity estimate and control law: those of the real loop.
    pub controller: Controller<N, V>,
    /// The exact zero-order-hold step, with friction where the model has it.
    pub step: FrictionStep<N>,
}

/// What the model loop remembers between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelState<N: Number, F> {
    pub(super) output_error: N,
    pub(super) integral_error: N::Sum,
    pub(super) motion: Motion<N>,
    pub(super) filter: F,
    acted: Acted<N>,
    regressor_filter: Acted<F>,
}

/// What acted on the model over the sample just passed, or the filters of these signals.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Acted<X> {
    command: X,
    direction: X,
    moving: X,
}

impl<N: Number, F: Default> ModelState<N, F> {
    /// At rest where the servo is.
    #[must_use]
    pub fn at_rest() -> Self {
        Self {
            output_error: N::ZERO,
            integral_error: N::Sum::new(N::ZERO),
            motion: Motion::NONE,
            filter: F::default(),
            acted: Acted {
                command: N::ZERO,
                direction: N::ZERO,
                moving: N::ZERO,
            },
            regressor_filter: Acted {
                command: F::default(),
                direction: F::default(),
                moving: F::default(),
            },
        }
    }
}

impl<N: Number, F: Copy + Default> ModelState<N, F> {
    /// Moving with the servo: where it is, as fast as its velocity estimate says, with the same
    /// filter state. For an identifier that joins a loop in motion, before the next sample.
    #[must_use]
    pub fn alongside(control: &ControlState<N, F>) -> Self {
        let velocity = control.velocity();
        Self {
            motion: Motion {
                increment: velocity,
                velocity,
            },
            filter: *control.filter(),
            ..Self::at_rest()
        }
    }
}

impl<N: Number, F> ModelState<N, F> {
    /// Displaced by `position` and faster by `velocity`, before the next sample.
    #[must_use]
    pub fn displaced(mut self, position: N, velocity: N) -> Self {
        self.output_error = self.output_error - position;
        self.motion.increment += velocity;
        self.motion.velocity += velocity;
        self
    }

    /// Output error ε = q − q_e.
    #[inline]
    pub fn output_error(&self) -> N {
        self.output_error
    }

    /// The model's velocity.
    #[inline]
    pub fn velocity(&self) -> N {
        self.motion.velocity
    }
}

/// The model's command of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelCommand<N> {
    /// What drives the model: u_e, and the injection behind the real controller if there is one.
    pub value: N,
    /// The load over the gain that the integral has found, k_i ω, command units.
    pub load: N,
    /// The rate of the output error, ε̇: the difference of the two velocity estimates.
    pub output_error_rate: N,
    /// The velocity estimate of the model's position.
    pub velocity: N,
    /// Whether the limit holds the command.
    pub limited: bool,
    /// Whether the model's integral took this sample's error.
    pub integrates: bool,
}

impl<N: Number, V: VelocityEstimate<N>> ModelLoop<N, V> {
    /// Brings the output error to this sample: both positions have moved.
    #[inline]
    pub fn observe(&self, state: &mut ModelState<N, V::State>, real: &ControlSample<N>) {
        state.output_error += real.increment - state.motion.increment;
    }

    /// The model's command for this sample.
    #[inline]
    pub fn command(
        &self,
        state: &mut ModelState<N, V::State>,
        real: &ControlSample<N>,
    ) -> ModelCommand<N> {
        let velocity = self
            .controller
            .velocity
            .process(&mut state.filter, state.motion.increment);
        let load = self
            .controller
            .pid
            .integral_command(state.integral_error.value());
        let error = real.error + state.output_error;
        let command = self.controller.pid.command(error, velocity, real.integral);
        state
            .integral_error
            .add(match (command.integrates, real.integrates) {
                (true, true) => state.output_error,
                (true, false) => error,
                (false, true) => -real.error,
                (false, false) => N::ZERO,
            });
        ModelCommand {
            // Written so that an injection that is known to be zero costs nothing.
            value: command.value + load - (N::ZERO - real.injection),
            load,
            output_error_rate: real.velocity - velocity,
            velocity,
            limited: command.limited,
            integrates: command.integrates,
        }
    }

    /// The regressor (9) of a parameter set, [q̇_e, −u_e, sign q̇_e, −1], its entries through the
    /// velocity filter: what the filter does to ε̇ it must do to φ, or their product loses its sign
    /// at the frequencies that the filter delays. They are those of the sample just passed, like
    /// the increment that the velocity is made of. While friction holds the model nothing acts on
    /// it, and the regressor is zero.
    #[inline]
    pub fn regressor<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut ModelState<N, V::State>,
        command: &ModelCommand<N>,
    ) -> [N; P] {
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
            Parameter::Load => -N::ONE,
        })
    }

    /// Moves the model to the next sample under its held command.
    #[inline]
    pub fn advance<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut ModelState<N, V::State>,
        command: &ModelCommand<N>,
        parameters: &ModelParameters<N>,
    ) -> Phase<N> {
        // Written so that a load that is known to be zero costs nothing.
        let drive = parameters.gain * command.value - (N::ZERO - parameters.load);
        if S::HAS_COULOMB {
            let (motion, phase) = self.step.process(
                parameters.x,
                drive,
                parameters.coulomb,
                state.motion.velocity,
            );
            state.motion = motion;
            let moving = phase.moving_part();
            state.acted = Acted {
                command: command.value * moving,
                direction: phase.mean_direction(),
                moving,
            };
            phase
        } else {
            state.motion = self
                .step
                .step
                .process(parameters.x, drive, state.motion.velocity);
            state.acted.command = command.value;
            Phase::Slid { direction: N::ONE }
        }
    }

    /// Puts the model where the servo is while both stand; true if they do.
    ///
    /// Real friction gives a little before it breaks away, and creeps: where exactly within the
    /// friction's band a servo comes to stand says nothing of its parameters, and the model's own
    /// place there would be an error that the next motion begins with. The servo counts as standing
    /// while friction outweighs all damping, (a + b kd) |q̇| ≤ c, and the model does while it is
    /// stuck.
    #[inline]
    pub fn stand_together(
        &self,
        state: &mut ModelState<N, V::State>,
        real: &ControlSample<N>,
        parameters: &ModelParameters<N>,
        phase: Phase<N>,
    ) -> bool {
        if phase != Phase::Stuck {
            return false;
        }
        let damping = parameters.x * real.velocity
            - parameters.gain * self.controller.pid.linear(N::ZERO, real.velocity);
        let stand = damping.magnitude() <= parameters.coulomb;
        if stand {
            self.stand_beside(state);
        }
        stand
    }

    /// Puts the model where the servo is; what its integral has gathered stays.
    #[inline]
    pub fn stand_beside(&self, state: &mut ModelState<N, V::State>) {
        state.output_error = N::ZERO;
    }

    /// Starts the model again where the servo is if it has left the reach of the number format,
    /// [`Number::REACH`]; true if it had to.
    #[inline]
    #[must_use]
    pub fn restart_if_lost(&self, state: &mut ModelState<N, V::State>) -> bool {
        // One comparison for both; it fails for what is no number.
        let in_reach =
            state.output_error.magnitude() + state.motion.velocity.magnitude() <= N::REACH;
        if !in_reach {
            *state = ModelState::at_rest();
        }
        !in_reach
    }
}
