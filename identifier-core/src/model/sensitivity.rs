use super::{ModelCommand, ModelLoop, ModelState, Motion, Phase};
use crate::measurement::velocity::VelocityEstimate;
use crate::number::{Number, RunningSum};
use crate::parameters::{ModelParameters, Parameter, ParameterSet};

/// The model loop's motion per unit of each parameter: what it would have done differently, to
/// first order, had the parameter been larger by one all along.
///
/// Each parameter's tangent passes through the linearised model loop: the same filter, PID and
/// hold; zero where the limit holds the command; through a stop or a turn of friction as the exact
/// motion does (a stop forgets the velocity's tangent, a turn scales it by the ratio of the
/// accelerations after and before).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity<N, F, const P: usize> {
    tangents: [Tangent<N, F>; P],
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Tangent<N, F> {
    position: N,
    integral: N,
    motion: Motion<N>,
    filter: F,
    command: N,
}

impl<N: Number, F: Copy + Default, const P: usize> Sensitivity<N, F, P> {
    /// Nothing has happened yet.
    #[must_use]
    pub fn none() -> Self {
        Self {
            tangents: [Tangent {
                position: N::ZERO,
                integral: N::ZERO,
                motion: Motion::NONE,
                filter: F::default(),
                command: N::ZERO,
            }; P],
        }
    }
}

impl<N: Number, F: Copy + Default, const P: usize> Sensitivity<N, F, P> {
    /// The tangents of an initial position (second last) and an initial velocity (last) of the
    /// model, the others zero: for a motion that begins with the next sample.
    #[must_use]
    pub fn of_initial_state() -> Self {
        let mut sensitivity = Self::none();
        if let [.., position, velocity] = &mut sensitivity.tangents[..] {
            position.position = N::ONE;
            velocity.motion = Motion {
                increment: N::ONE,
                velocity: N::ONE,
            };
        }
        sensitivity
    }
}

impl<N: Number, F: Copy + Default, const Q: usize> Sensitivity<N, F, Q> {
    /// The first P tangents alone: those of the parameters.
    #[must_use]
    pub fn of_first<const P: usize>(&self) -> Sensitivity<N, F, P> {
        let mut first = Sensitivity::none();
        for (to, from) in first.tangents.iter_mut().zip(&self.tangents) {
            *to = *from;
        }
        first
    }
}

impl<N: Number, F, const P: usize> Sensitivity<N, F, P> {
    /// ∂q_e/∂θᵢ.
    #[inline]
    pub fn position(&self) -> [N; P] {
        core::array::from_fn(|i| self.tangents[i].position)
    }
}

impl<N: Number, F, const P: usize> Sensitivity<N, F, P> {
    /// ∂ω/∂θᵢ.
    #[inline]
    pub fn integral(&self) -> [N; P] {
        core::array::from_fn(|i| self.tangents[i].integral)
    }
}

impl<N: Number, V: VelocityEstimate<N>> ModelLoop<N, V> {
    /// Brings the tangents to this sample, with [`ModelLoop::observe`].
    #[inline]
    pub fn observe_tangents<const P: usize>(&self, sensitivity: &mut Sensitivity<N, V::State, P>) {
        for tangent in &mut sensitivity.tangents {
            tangent.position += tangent.motion.increment;
        }
    }

    /// Moves the model's state to where it would be, to first order, had the parameters always been
    /// larger by `change`.
    #[inline]
    pub fn follow<const P: usize>(
        &self,
        state: &mut ModelState<N, V::State>,
        sensitivity: &Sensitivity<N, V::State, P>,
        change: &[N; P],
    ) {
        for (tangent, &change) in sensitivity.tangents.iter().zip(change) {
            state.output_error = state.output_error - tangent.position * change;
            state.motion.increment += tangent.motion.increment * change;
            state.motion.velocity += tangent.motion.velocity * change;
            state.integral_error.add(tangent.integral * change);
            V::add_scaled(&mut state.filter, &tangent.filter, change);
        }
    }

    /// Forgets what led to where the model stands, with [`ModelLoop::stand_together`]; what the
    /// integral has gathered stays.
    #[inline]
    pub fn stand_still<const P: usize>(&self, sensitivity: &mut Sensitivity<N, V::State, P>) {
        for tangent in &mut sensitivity.tangents {
            tangent.position = N::ZERO;
            tangent.filter = V::State::default();
        }
    }

    /// The tangents of the command, with [`ModelLoop::command`].
    #[inline]
    pub fn command_tangents<const P: usize>(
        &self,
        sensitivity: &mut Sensitivity<N, V::State, P>,
        command: &ModelCommand<N>,
    ) {
        for tangent in &mut sensitivity.tangents {
            let velocity = self
                .controller
                .velocity
                .process(&mut tangent.filter, tangent.motion.increment);
            let load = self.controller.pid.integral_command(tangent.integral);
            tangent.command = if command.limited {
                load
            } else {
                self.controller.pid.linear(-tangent.position, velocity) + load
            };
            if command.integrates {
                tangent.integral = tangent.integral - tangent.position;
            }
        }
    }

    /// Moves the tangents to the next sample, with [`ModelLoop::advance`]: `velocity` is the
    /// model's before it. The first P tangents are those of the set's parameters, any further ones
    /// of initial states.
    #[inline]
    pub fn advance_tangents<S: ParameterSet<P>, const P: usize, const Q: usize>(
        &self,
        sensitivity: &mut Sensitivity<N, V::State, Q>,
        command: &ModelCommand<N>,
        parameters: &ModelParameters<N>,
        velocity: N,
        phase: Phase<N>,
    ) {
        let x = parameters.x;
        let (part, direction) = match phase {
            Phase::Slid { direction } => (N::ONE, direction),
            Phase::Stuck => (N::ZERO, N::ZERO),
            Phase::Stopped { direction, part }
            | Phase::Turned {
                direction, part, ..
            } => (part, direction),
        };
        let response = if S::HAS_COULOMB {
            self.step.step.partial_response(x, part)
        } else {
            self.step.step.response(x)
        };
        let rest = self.step.step.partial_response(x, N::ONE - part);
        for (i, tangent) in sensitivity.tangents.iter_mut().enumerate() {
            let own = |velocity: N, direction: N| match S::PARAMETERS.get(i) {
                Some(Parameter::A) => -velocity,
                Some(Parameter::B) => command.value,
                Some(Parameter::Coulomb) => -direction,
                Some(Parameter::Load) => N::ONE,
                None => N::ZERO,
            };
            let driven = parameters.gain * tangent.command;
            let before = tangent.motion.velocity;
            let acceleration = own(velocity, direction) + driven - x * before;
            let mut motion = Motion {
                increment: before * part + response.way * acceleration,
                velocity: before + response.velocity * acceleration,
            };
            match phase {
                Phase::Slid { .. } => {}
                Phase::Stuck => motion = Motion::NONE,
                Phase::Stopped { .. } => motion.velocity = N::ZERO,
                Phase::Turned { slowing, .. } => {
                    let turned = motion.velocity * slowing;
                    let acceleration = own(N::ZERO, -direction) + driven - x * turned;
                    motion = Motion {
                        increment: motion.increment
                            + turned * (N::ONE - part)
                            + rest.way * acceleration,
                        velocity: turned + rest.velocity * acceleration,
                    };
                }
            }
            tangent.motion = motion;
        }
    }
}
