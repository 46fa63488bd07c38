use super::{Corrected, Correction, FrictionPhase, FrictionStep, Motion};
use crate::constants::{Encode, encode};
use crate::measurement::velocity::VelocityEstimate;
use crate::number::Number;
use crate::parameters::{ModelParameters, Parameter, ParameterSet};
use crate::unrolled::from_fn;

/// The model loop (5)–(7), driven by the command that acted.
///
/// **From the paper's loop to this one.** The paper closes a second PID around the model. The servo's u is a linear law
/// on e, q̇ and z. Its u_e is the same law on e_e = e + ε, q̇_e = q̇ − ε̇ and z_e = z + ω. So, if no limit acts,
///
/// u_e = k_p (e + ε) − k_d (q̇ − ε̇) + k_i (z + ω) = u + k_p ε + k_d ε̇ + k_i ω = u + u_ε,
///
/// and (5) becomes q̈_e = −â q̇_e + b̂ (u + u_ε). That is computed here. u is the command that acted, as a
/// *measurement*: limited, with feed-forward, dither or injection, of any controller. Reference, structure, limit and
/// anti-windup of the controller do not enter.
///
/// **Consequence for the proof.** Subtracting from (2) gives ε̈ = −α ε̇ − b k_p ε − b k_i ω + θ̃ᵀφ with φ = [q̇_e,
/// −(u + u_ε)]ᵀ. This is (8) with φ of (9) for any u, and (10) to (14) follow unchanged. The paper's Proposition 1
/// needs the servo's signals bounded. Its PID without a limit ensures that; here any controller must ensure it. So the
/// identifier also converges while the command saturates. u is then bounded and known, and the feedback on ε continues.
///
/// **Relative.** Its state is ε rather than q_e: no large numbers are subtracted, and the loop has no
/// origin. Two calls make a sample: [`ModelLoop::observe`] and [`ModelLoop::advance`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModelLoop<N, V, C> {
    velocity: V,
    correction: C,
    step: FrictionStep<N>,
}

encode! {
    [N: Encode, V: Encode, C: Encode] ModelLoop<N, V, C> as "ModelLoop" { velocity, correction, step }
}

/// The state of the model loop between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModelState<N, F, C> {
    output_error: N,
    motion: Motion<N>,
    measured: F,
    rate: F,
    correction: C,
    acted: ModelInputs<N>,
    regressor: RegressorFilter<F>,
}

/// The inputs of the model over the sample just passed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ModelInputs<N> {
    command: N,
    direction: N,
    moving: N,
}

/// The velocity filters of the regressor's entries.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RegressorFilter<F> {
    command: F,
    direction: F,
    moving: F,
}

/// The observation of a sample, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Observed<N, const P: usize> {
    /// Output error ε = q − q_e.
    pub output_error: N,
    /// Its rate ε̇ through the velocity filter: the difference of the two velocity estimates.
    pub rate: N,
    /// ψ = −φ, the regressor (9) of the parameter set with its sign turned. It is ∂q̈_e/∂θ = [−q̇_e, u_e, −sign q̇_e,
    /// 1], with its entries through the velocity filter. The filter must act on φ as it does on ε̇. Otherwise their
    /// product loses its sign at the frequencies that the filter delays. The entries are those of the past sample, like
    /// the increment that gives the rate. While friction holds the model at rest, the regressor is zero.
    pub regressor: [N; P],
}

impl<N: Number, V: VelocityEstimate<N>, C: Correction<N>> ModelLoop<N, V, C> {
    /// The loop with a velocity filter for ε̇ and a correction.
    #[must_use]
    pub(crate) fn new(velocity: V, correction: C) -> Self {
        Self {
            velocity,
            correction,
            step: FrictionStep::new(),
        }
    }

    /// At rest at the servo's position.
    #[must_use]
    pub(crate) fn start(&self) -> ModelState<N, V::State, C::State> {
        let rest = V::State::default();
        ModelState {
            output_error: N::ZERO,
            motion: Motion::NONE,
            measured: rest,
            rate: rest,
            correction: self.correction.start(),
            acted: ModelInputs {
                command: N::ZERO,
                direction: N::ZERO,
                moving: N::ZERO,
            },
            regressor: RegressorFilter {
                command: rest,
                direction: rest,
                moving: rest,
            },
        }
    }

    /// The state that moves with the servo at a velocity (machine units). It is for an identifier that joins a loop in
    /// motion before the next sample. The correction's integral is kept.
    #[must_use]
    pub(crate) fn alongside(
        &self,
        state: &ModelState<N, V::State, C::State>,
        velocity: N,
    ) -> ModelState<N, V::State, C::State> {
        ModelState {
            motion: Motion {
                increment: velocity,
                velocity,
            },
            correction: state.correction,
            ..self.start()
        }
    }

    /// Takes the increment of the servo since the last sample and gives output error, rate and
    /// regressor.
    #[inline]
    pub(crate) fn observe<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut ModelState<N, V::State, C::State>,
        increment: N,
    ) -> Observed<N, P> {
        let velocity = self.velocity.process(&mut state.measured, increment);
        self.observe_beside::<S, P>(state, increment, velocity)
    }

    /// The same where a controller with the same velocity filter has computed the servo's velocity
    /// estimate already.
    #[inline]
    pub(crate) fn observe_beside<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut ModelState<N, V::State, C::State>,
        increment: N,
        velocity: N,
    ) -> Observed<N, P> {
        let change = increment - state.motion.increment;
        state.output_error += change;
        // The filter is linear: of the difference it is the difference of the velocity estimates.
        let rate = self.velocity.process(&mut state.rate, change);
        let acted = &state.acted;
        let filters = &mut state.regressor;
        let regressor = from_fn(N::ZERO, |i| match S::PARAMETERS[i] {
            Parameter::A => rate - velocity,
            Parameter::B => self.velocity.process(&mut filters.command, acted.command),
            Parameter::Coulomb => -self
                .velocity
                .process(&mut filters.direction, acted.direction),
            Parameter::Load if S::HAS_COULOMB => {
                self.velocity.process(&mut filters.moving, acted.moving)
            }
            Parameter::Load => N::ONE,
        });
        Observed {
            output_error: state.output_error,
            rate,
            regressor,
        }
    }

    /// Moves the model to the next sample under the command that acts until then. `rate` is the observed ε̇.
    #[inline]
    pub(crate) fn advance<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut ModelState<N, V::State, C::State>,
        rate: N,
        command: N,
        parameters: &ModelParameters<N>,
    ) -> FrictionPhase<N> {
        let Corrected {
            command: correction,
            acceleration,
        } = self
            .correction
            .process(&mut state.correction, state.output_error, rate);
        let command = command + correction;
        // Written so that known zeros cost nothing.
        let drive =
            parameters.gain * command - (N::ZERO - parameters.load) - (N::ZERO - acceleration);
        let velocity = state.motion.velocity;
        if S::HAS_COULOMB {
            let (motion, phase) =
                self.step
                    .process(parameters.x, drive, parameters.coulomb, velocity);
            state.motion = motion;
            let moving = phase.moving_part();
            state.acted = ModelInputs {
                command: command * moving,
                direction: phase.mean_direction(),
                moving,
            };
            phase
        } else {
            state.motion = self.step.step.process(parameters.x, drive, velocity);
            state.acted.command = command;
            FrictionPhase::Slid { direction: N::ONE }
        }
    }

    /// Output error ε = q − q_e, machine units.
    #[inline]
    pub(crate) fn output_error(&self, state: &ModelState<N, V::State, C::State>) -> N {
        state.output_error
    }

    /// k_i ω: the load over the gain as the correction's integral estimates it, command units; by (9),
    /// ω → 0.
    #[inline]
    pub(crate) fn load_command(&self, state: &ModelState<N, V::State, C::State>) -> N {
        self.correction.load_command(&state.correction)
    }

    /// Sets the model to the servo's position during standstill; the correction's integral is kept.
    ///
    /// Real friction yields elastically before it breaks away, and creeps. So the position of rest within the
    /// friction's band contains no information on the parameters. A difference there would be an output error at the
    /// start of the next motion.
    #[inline]
    pub(crate) fn hold_at_measurement(&self, state: &mut ModelState<N, V::State, C::State>) {
        state.output_error = N::ZERO;
    }

    /// Restarts the model at the servo's position if it has left the range of the number format, [`Number::REACH`].
    /// True if it was restarted.
    #[inline]
    #[must_use]
    pub(crate) fn restart_if_lost(&self, state: &mut ModelState<N, V::State, C::State>) -> bool {
        // One comparison for both; it fails for NaN.
        let in_reach =
            state.output_error.magnitude() + state.motion.velocity.magnitude() <= N::REACH;
        if !in_reach {
            *state = self.start();
        }
        !in_reach
    }
}
