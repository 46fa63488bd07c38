use super::{Acting, FrictionPhase, FrictionStep, ModelValues, Motion, Response};
use crate::number::Number;
use crate::parameters::{ModelParameters, UnknownSet};
use crate::unrolled::each;

/// The model of the servo driven by the command that acted on the servo.
///
/// With the output error ε = q − q_e (counts) and the command u held over the sample,
///
/// q̇_e = v_e + l₁ ε, v̇_e = −â v_e + b̂ u + d̂ + l₂ ε − ĉ sign v_e.
///
/// The servo is q̈ = −a q̇ + b u + d − c sign q̇. The error then obeys ε̈ + (a + l₁) ε̇ + (l₂ + a l₁) ε = φᵀθ̃, φ =
/// [−q̇, u, −sign q̇, 1]. A correction l_p ε + l_d ε̇ of the acceleration gives the same equation. The gains are the
/// identifier's own; b̂ is not in the equation, so no estimate can make it unstable. This is the innovations form
/// (Ljung, System Identification, 2nd edition 1999, section 4.3), and nothing is differentiated. The encoder's rounding
/// enters the velocity only through l₂ ∫ε, not through l_d ε as in the other form. So it disturbs stopping and breaking
/// away far less.
///
/// The optional terms of an [`UnknownSet`] add to it. Only ε and the velocity are kept, never a position, so no travel
/// is too long for `f32`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ObserverModel<N> {
    /// ε before the increment of the sample, or after it once [`ObserverModel::observe`] was
    /// called; counts.
    pub error: N,
    /// Velocity, counts per sample.
    pub velocity: N,
}

/// The gains of the correction in innovations form, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Innovation<N> {
    /// l₁ T: the part of ε by which the position is moved each sample.
    pub position: N,
    /// l₂ T²: acceleration per ε.
    pub velocity: N,
}

impl<N: Number> Innovation<N> {
    /// A double pole at ω T: l₁ = 2 ω, l₂ = ω².
    #[inline]
    pub(crate) fn critically_damped(omega: N) -> Self {
        Self {
            position: omega + omega,
            velocity: omega * omega,
        }
    }
}

impl<N: Number> ObserverModel<N> {
    /// At the servo's position, with a velocity (counts per sample).
    pub(crate) fn alongside(velocity: N) -> Self {
        Self {
            error: N::ZERO,
            velocity,
        }
    }

    /// Takes the distance that the servo has moved over the last sample; ε is then the output error.
    #[inline]
    pub(crate) fn observe(&mut self, increment: N) {
        self.error += increment;
    }

    /// Moves the model one sample under its inputs; `response` is that of the step for the values' x.
    /// Returns the step of the model itself, without the correction of its position.
    #[inline]
    pub(crate) fn advance<S: UnknownSet<P>, const P: usize>(
        &mut self,
        step: &FrictionStep<N>,
        response: &Response<N>,
        values: &ModelValues<N>,
        acting: &Acting<N>,
        innovation: &Innovation<N>,
    ) -> ModelStep<N> {
        let push = self.push::<S, P>(response, values, acting, innovation);
        let x = values.parameters.x;
        let (motion, phase) = if S::HAS_COULOMB {
            step.process_with(response, x, push.drive, push.coulomb, self.velocity)
        } else {
            let direction = N::ZERO;
            let motion = response.motion(x, push.drive, self.velocity);
            (motion, FrictionPhase::Moving { direction })
        };
        let lead = push.lead * phase.moving_part();
        self.move_by(motion, lead, innovation);
        ModelStep {
            displacement: motion.increment,
            phase,
            stribeck_factor: push.stribeck_factor,
        }
    }

    /// [`ObserverModel::advance`] for a sample in which the model moves in one direction throughout, as in most. None,
    /// without any change, if friction stops or turns the model.
    #[inline]
    pub(crate) fn move_on<S: UnknownSet<P>, const P: usize>(
        &mut self,
        response: &Response<N>,
        values: &ModelValues<N>,
        acting: &Acting<N>,
        innovation: &Innovation<N>,
    ) -> Option<MovingStep<N>> {
        let push = self.push::<S, P>(response, values, acting, innovation);
        let x = values.parameters.x;
        let (direction, drive) = if !S::HAS_COULOMB {
            (N::ZERO, push.drive)
        } else if self.velocity > N::ZERO {
            (N::ONE, push.drive - push.coulomb)
        } else {
            (-N::ONE, push.drive + push.coulomb)
        };
        let motion = response.motion(x, drive, self.velocity);
        let onward = !S::HAS_COULOMB || motion.velocity * self.velocity > N::ZERO;
        onward.then(|| {
            self.move_by(motion, push.lead, innovation);
            MovingStep {
                displacement: motion.increment,
                direction,
                stribeck_factor: push.stribeck_factor,
            }
        })
    }

    /// True if friction holds the model throughout a sample; the sample is done then: only the
    /// correction moves the model.
    #[inline]
    pub(crate) fn rest<S: UnknownSet<P>, const P: usize>(
        &mut self,
        values: &ModelValues<N>,
        acting: &Acting<N>,
        innovation: &Innovation<N>,
    ) -> bool {
        if !S::HAS_COULOMB || self.velocity != N::ZERO {
            return false;
        }
        let holding = if S::HAS_COULOMB_TERMS {
            values.parameters.coulomb + values.terms.coulomb(N::ONE)
        } else {
            values.parameters.coulomb
        };
        let drive = drive::<N, S, P>(values, acting) + innovation.velocity * self.error;
        let is_at_rest = drive.magnitude() <= holding;
        if is_at_rest {
            self.move_by(Motion::none(), N::ZERO, innovation);
        }
        is_at_rest
    }

    /// The acceleration but for Coulomb friction, and that friction. Effects that depend on the velocity use that in
    /// the middle of the sample.
    #[inline]
    fn push<S: UnknownSet<P>, const P: usize>(
        &self,
        response: &Response<N>,
        values: &ModelValues<N>,
        acting: &Acting<N>,
        innovation: &Innovation<N>,
    ) -> Push<N> {
        let ModelValues { parameters, terms } = values;
        let mut push = Push {
            drive: drive::<N, S, P>(values, acting) + innovation.velocity * self.error,
            coulomb: parameters.coulomb,
            lead: N::ZERO,
            stribeck_factor: N::ONE,
        };
        if S::HAS_TERMS {
            push.lead = parameters.gain * acting.lead;
        }
        if S::HAS_SPEED_TERMS {
            let middle = self.middle(response, parameters, push.drive);
            if S::HAS_COULOMB_TERMS {
                push.stribeck_factor = stribeck_factor(middle * terms.per_low_speed_velocity);
                let coulomb = parameters.coulomb + terms.coulomb(push.stribeck_factor);
                push.coulomb = coulomb.limited(N::ZERO, N::REACH);
            }
            push.drive = push.drive - terms.brake(middle);
        }
        push
    }

    /// The velocity in the middle of the sample, zero where the model stops before.
    #[inline]
    fn middle(&self, response: &Response<N>, parameters: &ModelParameters<N>, drive: N) -> N {
        let friction = if self.velocity > N::ZERO {
            parameters.coulomb
        } else if self.velocity < N::ZERO {
            -parameters.coulomb
        } else {
            return N::ZERO;
        };
        let after = response.motion(parameters.x, drive - friction, self.velocity);
        let middle = N::from_f64(0.5) * (self.velocity + after.velocity);
        if middle * self.velocity > N::ZERO {
            middle
        } else {
            N::ZERO
        }
    }

    #[inline]
    fn move_by(&mut self, motion: Motion<N>, lead: N, innovation: &Innovation<N>) {
        let moved = motion.increment + lead;
        self.error = self.error - innovation.position * self.error - moved;
        self.velocity = motion.velocity;
    }
}

/// Accelerations of a model over a sample.
struct Push<N> {
    /// Acceleration but for Coulomb friction.
    drive: N,
    coulomb: N,
    /// The additional distance because the command came earlier than evenly spread.
    lead: N,
    stribeck_factor: N,
}

/// A model's own motion over a sample in which it moved in one direction throughout.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MovingStep<N> {
    /// The distance, counts.
    pub displacement: N,
    /// The direction, ±1; zero in models without friction.
    pub direction: N,
    /// exp(−(v/v_s)²), one in models without friction at low speed.
    pub stribeck_factor: N,
}

/// A model's own motion over a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModelStep<N> {
    /// The distance, counts.
    pub displacement: N,
    /// The phase of friction.
    pub phase: FrictionPhase<N>,
    /// As in [`MovingStep`].
    pub stribeck_factor: N,
}

/// The acceleration that does not depend on the model's motion.
#[inline]
pub(crate) fn drive<N: Number, S: UnknownSet<P>, const P: usize>(
    values: &ModelValues<N>,
    acting: &Acting<N>,
) -> N {
    let parameters = &values.parameters;
    let mut drive = parameters.gain * acting.command + parameters.load;
    if S::HAS_LOAD_TERMS {
        each::<4>(|i| drive += values.terms.waves[i] * acting.waves[i]);
    }
    drive
}

/// exp(−x²) to 10⁻³, without a transcendental: 1/(1 + z + z²/2 + z³/6)⁸ with z = x²/8.
#[inline]
pub(crate) fn stribeck_factor<N: Number>(x: N) -> N {
    /// Beyond this x² the result is below 10⁻⁸.
    const MAX_SQUARE: f64 = 20.0;
    let square = (x * x).limited(N::ZERO, N::from_f64(MAX_SQUARE));
    let z = square * N::from_f64(0.125);
    let (half, third) = (N::from_f64(1.0 / 2.0), N::from_f64(1.0 / 3.0));
    let root = N::ONE + z * (N::ONE + half * z * (N::ONE + third * z));
    let square = root * root;
    let fourth = square * square;
    (fourth * fourth).reciprocal()
}

#[cfg(test)]
mod tests {
    use super::stribeck_factor;

    #[test]
    fn the_stribeck_factor_is_near_the_exponential_everywhere() {
        for k in 0..600 {
            let x = 0.01 * f64::from(k);
            assert!((stribeck_factor(x) - libm::exp(-x * x)).abs() < 1e-3, "{x}");
            assert!(
                (f64::from(stribeck_factor(x as f32)) - stribeck_factor(x)).abs() < 1e-5,
                "{x}"
            );
        }
    }
}
