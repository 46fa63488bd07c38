use super::{CommandCorrection, FrictionPhase, FrictionStep, Motion};
use crate::constants::{Encode, encode};
use crate::control::Gains;
use crate::measurement::velocity::VelocityEstimate;
use crate::number::{Arithmetic, Encoded};
use crate::parameters::{ModelParameters, Parameter, ParameterSet};
use crate::scales::FullScales;
use crate::units::Units;
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
pub(crate) struct ModelLoop<N: Arithmetic, V> {
    velocity: V,
    correction: CommandCorrection<N>,
    step: FrictionStep<N>,
    /// From an increment to the output error.
    to_error: N::Shift,
}

encode! {
    [N: Encoded, V: Encode] ModelLoop<N, V> as "ModelLoop" { velocity, correction, step, to_error }
}

/// The state of the model loop between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModelState<N: Arithmetic, F> {
    /// ε = q − q_e.
    output_error: N::Fine,
    /// ω = ∑ε.
    integral_error: N::Sum,
    motion: Motion<N>,
    rate: F,
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
    velocity: F,
    command: F,
    direction: F,
    moving: F,
}

/// The observation of a sample, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Observed<N, const P: usize> {
    /// Output error ε = q − q_e.
    pub output_error: N,
    /// Its rate ε̇ through the velocity filter: the difference of the two velocity estimates. In fixed point it has
    /// twice the velocity's full scale.
    pub rate: N,
    /// ψ = −φ, the regressor (9) of the parameter set with its sign turned. It is ∂q̈_e/∂θ = [−q̇_e, u_e, −sign q̇_e,
    /// 1], with its entries through the velocity filter. The filter must act on φ as it does on ε̇. Otherwise their
    /// product loses its sign at the frequencies that the filter delays. The entries are those of the past sample, like
    /// the increment that gives the rate. While friction holds the model at rest, the regressor is zero.
    pub regressor: [N; P],
}

impl<N: Arithmetic, F: Default> ModelState<N, F> {
    /// With a motion, at the servo's position.
    #[inline]
    fn new(integral_error: N::Sum, motion: Motion<N>) -> Self {
        Self {
            output_error: N::ZERO.fine(),
            integral_error,
            motion,
            rate: F::default(),
            acted: ModelInputs {
                command: N::ZERO,
                direction: N::ZERO,
                moving: N::ZERO,
            },
            regressor: RegressorFilter {
                velocity: F::default(),
                command: F::default(),
                direction: F::default(),
                moving: F::default(),
            },
        }
    }

    /// At rest at the servo's position.
    pub(crate) fn at_rest() -> Self {
        Self::new(N::ZERO.sum(), Motion::none())
    }

    /// The state that moves with the servo at a velocity (machine units). It is for an identifier that joins a loop in
    /// motion before the next sample. The correction's integral is kept.
    pub(crate) fn alongside(&self, velocity: N) -> Self {
        Self::new(self.integral_error, Motion::steady(velocity.saturated()))
    }

    /// The mean direction over the sample just passed; zero while friction holds the model.
    #[inline(always)]
    pub(crate) fn direction(&self) -> N {
        self.acted.direction
    }

    /// Sets the model to the servo's position during standstill; the correction's integral is kept.
    ///
    /// Real friction yields elastically before it breaks away, and creeps. So the position of rest within the
    /// friction's band contains no information on the parameters. A difference there would be an output error at the
    /// start of the next motion.
    #[inline]
    pub(crate) fn hold_at_measurement(&mut self) {
        self.output_error = N::ZERO.fine();
    }

    /// Restarts the model at the servo's position if it has left the range of the number format. True if it was
    /// restarted.
    #[inline]
    #[must_use]
    pub(crate) fn restart_if_lost(&mut self) -> bool {
        // Not mapped: at "s" that is a call.
        let error = N::of_fine(self.output_error);
        let velocity = N::of_fine(self.motion.velocity);
        let in_range = if N::IS_FIXED {
            error.is_within() && velocity.is_within() && self.motion.increment.is_within()
        } else {
            // One comparison for both; it fails for NaN.
            error.magnitude() + velocity.magnitude() <= N::REACH
        };
        if !in_range {
            *self = Self::at_rest();
        }
        !in_range
    }
}

impl<N: Arithmetic, V: VelocityEstimate<N>> ModelLoop<N, V> {
    /// The loop with a velocity filter for ε̇ and the gains of its correction.
    pub(crate) fn new(velocity: V, units: &Units, gains: &Gains, scales: &FullScales) -> Self {
        Self {
            velocity,
            correction: CommandCorrection::new(units, gains, scales),
            step: FrictionStep::new(),
            to_error: N::lower(scales.position - scales.velocity),
        }
    }

    /// Takes the increment of the servo since the last sample and gives output error, rate and
    /// regressor.
    #[inline(always)]
    pub(crate) fn observe<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut ModelState<N, V::State>,
        increment: N,
    ) -> Observed<N, P> {
        let change = increment - state.motion.increment;
        N::add_fine(&mut state.output_error, change, self.to_error);
        // The filter is linear: of the difference it is the difference of the velocity estimates.
        let rate = self.velocity.process(&mut state.rate, change.coarser());
        let (acted, filters) = (&state.acted, &mut state.regressor);
        let moved = state.motion.increment;
        let regressor = from_fn(N::ZERO, |i| match S::PARAMETERS[i] {
            Parameter::A => -self.velocity.process(&mut filters.velocity, moved),
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
            output_error: self.output_error(state),
            rate,
            regressor,
        }
    }

    /// Moves the model to the next sample under the command that acts until then. `rate` is the observed ε̇.
    #[inline(always)]
    pub(crate) fn advance<S: ParameterSet<P>, const P: usize>(
        &self,
        state: &mut ModelState<N, V::State>,
        rate: N,
        command: N,
        parameters: &ModelParameters<N>,
    ) -> FrictionPhase<N> {
        let output_error = self.output_error(state);
        let command = command.saturated_to_half();
        let sum = &mut state.integral_error;
        let command = self.correction.process(sum, command, output_error, rate);
        // Written so that a known zero costs nothing.
        let pushed = parameters.gain.times(command).quartered();
        let drive = pushed - (N::ZERO - parameters.load);
        let velocity = state.motion.velocity;
        if S::HAS_COULOMB {
            let (motion, phase) =
                self.step
                    .process(parameters.x, drive, parameters.coulomb, velocity);
            state.motion = motion;
            let moving = phase.moving_part();
            state.acted = ModelInputs {
                command: command.part(moving),
                direction: phase.mean_direction(),
                moving,
            };
            phase
        } else {
            state.motion = self.step.step.process(parameters.x, drive, velocity);
            state.acted.command = command;
            FrictionPhase::Moving { direction: N::ONE }
        }
    }

    /// Output error ε = q − q_e, machine units.
    #[inline(always)]
    pub(crate) fn output_error(&self, state: &ModelState<N, V::State>) -> N {
        N::of_fine(state.output_error).saturated()
    }

    /// k_i ω: the load over the gain as the correction's integral estimates it, command units; by (9),
    /// ω → 0.
    #[inline(always)]
    pub(crate) fn load_command(&self, state: &ModelState<N, V::State>) -> N {
        self.correction.load_command(state.integral_error)
    }

    /// The driving acceleration: b̂ times the command that acts and that of the load, plus the estimated load.
    pub(crate) fn drive(
        &self,
        state: &ModelState<N, V::State>,
        command: N,
        parameters: &ModelParameters<N>,
    ) -> N {
        let command = command.saturated_to_half() + self.load_command(state);
        parameters.gain.times(command).quartered() + parameters.load
    }
}
