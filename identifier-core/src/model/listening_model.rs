use super::{FrictionStep, Motion, Phase, Response};
use crate::number::Number;
use crate::parameters::{ModelParameters, Parameter, ParameterSet};

/// The model of the servo driven by the command that acted on the servo.
///
/// With the output error ε = q − q_e (counts) and the command u held over the sample,
///
/// q̇_e = v_e + l₁ ε, v̇_e = −â v_e + b̂ u + d̂ + l₂ ε − ĉ sign v_e.
///
/// With q̈ = −a q̇ + b u + d − c sign q̇ the error obeys ε̈ + (a + l₁) ε̇ + (l₂ + a l₁) ε = φᵀθ̃,
/// φ = [−q̇, u, −sign q̇, 1]: the same equation as a correction l_p ε + l_d ε̇ of the acceleration
/// gives. The gains are the identifier's own; b̂ is not in the equation, so no estimate can make it
/// unstable. In this form (the innovations form of Ljung, System Identification, 2nd edition 1999,
/// section 4.3) nothing is differentiated: the encoder's rounding enters the velocity only through
/// l₂ ∫ε, not through l_d ε as in the other, and so disturbs stopping and breaking away far less.
///
/// Only ε and the velocity are kept, never a position, so no travel is too long for `f32`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListeningModel<N> {
    /// ε before the increment of the sample, or after it once [`ListeningModel::observe`] was
    /// called; counts.
    pub error: N,
    /// Velocity, counts per sample.
    pub velocity: N,
}

/// The gains of the correction in innovations form, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation<N> {
    /// l₁ T: the part of ε by which the position is moved each sample.
    pub position: N,
    /// l₂ T²: acceleration per ε.
    pub velocity: N,
}

impl<N: Number> Innovation<N> {
    /// A double pole at ω T: l₁ = 2 ω, l₂ = ω².
    #[inline]
    #[must_use]
    pub fn critically_damped(omega: N) -> Self {
        Self {
            position: omega + omega,
            velocity: omega * omega,
        }
    }
}

impl<N: Number> ListeningModel<N> {
    /// At the servo's position, with a velocity (counts per sample).
    #[must_use]
    pub fn alongside(velocity: N) -> Self {
        Self {
            error: N::ZERO,
            velocity,
        }
    }

    /// Takes the distance that the servo has moved over the last sample; ε is then the output error.
    #[inline]
    pub fn observe(&mut self, increment: N) {
        self.error += increment;
    }

    /// Moves the model one sample under a held command; `response` is that of the step for the
    /// parameters' x. Returns the distance that the model itself moved, without the correction of its
    /// position, and what friction did.
    #[inline]
    pub fn advance<S: ParameterSet<P>, const P: usize>(
        &mut self,
        step: &FrictionStep<N>,
        response: &Response<N>,
        parameters: &ModelParameters<N>,
        command: N,
        innovation: &Innovation<N>,
    ) -> (N, Phase<N>) {
        let drive = self.drive(parameters, command, innovation);
        let (motion, phase) = if S::HAS_COULOMB {
            step.process_with(
                response,
                parameters.x,
                drive,
                parameters.coulomb,
                self.velocity,
            )
        } else {
            let direction = N::ZERO;
            let motion = response.motion(parameters.x, drive, self.velocity);
            (motion, Phase::Slid { direction })
        };
        self.go(motion, innovation);
        (motion.increment, phase)
    }

    /// [`ListeningModel::advance`] for a sample in which the model moves in one direction throughout,
    /// as in most. Returns the way it went and the direction, ±1; none, and does nothing, if friction
    /// has more to say.
    #[inline]
    pub fn slide<S: ParameterSet<P>, const P: usize>(
        &mut self,
        response: &Response<N>,
        parameters: &ModelParameters<N>,
        command: N,
        innovation: &Innovation<N>,
    ) -> Option<(N, N)> {
        let drive = self.drive(parameters, command, innovation);
        if !S::HAS_COULOMB {
            let motion = response.motion(parameters.x, drive, self.velocity);
            self.go(motion, innovation);
            return Some((motion.increment, N::ZERO));
        }
        let (direction, pushed) = if self.velocity > N::ZERO {
            (N::ONE, drive - parameters.coulomb)
        } else {
            (-N::ONE, drive + parameters.coulomb)
        };
        let motion = response.motion(parameters.x, pushed, self.velocity);
        if motion.velocity * self.velocity > N::ZERO {
            self.go(motion, innovation);
            Some((motion.increment, direction))
        } else {
            None
        }
    }

    /// Whether friction holds the model throughout a sample; if so, the sample is done: only the
    /// correction moves the model.
    #[inline]
    pub fn rest<S: ParameterSet<P>, const P: usize>(
        &mut self,
        parameters: &ModelParameters<N>,
        command: N,
        innovation: &Innovation<N>,
    ) -> bool {
        let rests = S::HAS_COULOMB
            && self.velocity == N::ZERO
            && self.drive(parameters, command, innovation).magnitude() <= parameters.coulomb;
        if rests {
            self.go(Motion::NONE, innovation);
        }
        rests
    }

    /// The acceleration but for friction.
    #[inline]
    fn drive(&self, parameters: &ModelParameters<N>, command: N, innovation: &Innovation<N>) -> N {
        parameters.gain * command + parameters.load + innovation.velocity * self.error
    }

    #[inline]
    fn go(&mut self, motion: Motion<N>, innovation: &Innovation<N>) {
        self.error = self.error - innovation.position * self.error - motion.increment;
        self.velocity = motion.velocity;
    }
}

/// The motion of a [`ListeningModel`] per unit of each of Q unknowns, the first P of them the
/// parameters of a set: ∂q_e/∂θ and ∂v_e/∂θ.
///
/// They are of first order in the sample time, which is enough: a tangent only gives a direction; the
/// step that is taken is judged with the exact model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangents<N, const Q: usize> {
    /// ∂q_e/∂θ.
    pub position: [N; Q],
    /// ∂v_e/∂θ.
    pub velocity: [N; Q],
}

impl<N: Number, const Q: usize> Tangents<N, Q> {
    /// No motion depends on any parameter yet.
    pub const NONE: Self = Self {
        position: [N::ZERO; Q],
        velocity: [N::ZERO; Q],
    };

    /// Moves the tangents over the sample in which the model went `way` in a `phase`.
    #[inline]
    pub fn advance<S: ParameterSet<P>, const P: usize>(
        &mut self,
        x: N,
        command: N,
        innovation: &Innovation<N>,
        way: N,
        phase: Phase<N>,
    ) {
        let direction = match phase {
            Phase::Slid { direction } => direction,
            _ => return self.advance_through_rest::<S, P>(x, command, innovation, way, phase),
        };
        self.slide::<S, P>(x, command, innovation, way, direction);
    }

    /// A sample in which the model moved, in one direction on the whole.
    #[inline]
    pub fn slide<S: ParameterSet<P>, const P: usize>(
        &mut self,
        x: N,
        command: N,
        innovation: &Innovation<N>,
        way: N,
        direction: N,
    ) {
        let followed = N::ONE - innovation.position;
        let braked = N::ONE - x;
        for i in 0..Q {
            let position = self.position[i];
            let kept = braked * self.velocity[i] - innovation.velocity * position;
            let velocity = match S::PARAMETERS.get(i) {
                Some(Parameter::A) => kept - way,
                Some(Parameter::B) => kept + command,
                Some(Parameter::Coulomb) => kept - direction,
                Some(Parameter::Load) => kept + N::ONE,
                None => kept,
            };
            self.position[i] = followed * position + velocity;
            self.velocity[i] = velocity;
        }
    }

    /// A sample in which the model was at rest from beginning to end, so that they have no velocity.
    #[inline]
    pub fn rest(&mut self, innovation: &Innovation<N>) {
        let followed = N::ONE - innovation.position;
        for position in &mut self.position {
            *position = *position * followed;
        }
    }

    /// A sample in which the model was at rest, stopped or turned.
    #[cold]
    fn advance_through_rest<S: ParameterSet<P>, const P: usize>(
        &mut self,
        x: N,
        command: N,
        innovation: &Innovation<N>,
        way: N,
        phase: Phase<N>,
    ) {
        let kept = match phase {
            Phase::Turned { slowing, .. } => slowing,
            _ => N::ZERO,
        };
        if matches!(phase, Phase::Stuck) {
            self.rest(innovation);
        } else {
            self.slide::<S, P>(x, command, innovation, way, phase.mean_direction());
        }
        for velocity in &mut self.velocity {
            *velocity = *velocity * kept;
        }
    }
}
