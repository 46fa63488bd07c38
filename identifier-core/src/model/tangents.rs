use super::{Acting, FrictionPhase, Innovation, ModelStep, ModelValues, MovingStep};
use crate::number::Number;
use crate::parameters::{Unknown, UnknownSet};
use crate::unrolled::each;

/// The sensitivities of an [`ObserverModel`](super::ObserverModel) to each of Q unknowns: ∂q_e/∂θ and ∂v_e/∂θ. The
/// first P unknowns are those of a set.
///
/// They are of first order in the sample time. This is enough, as a tangent only gives a direction. The exact model
/// decides on the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tangents<N, const Q: usize> {
    /// ∂q_e/∂θ.
    pub position: [N; Q],
    /// ∂v_e/∂θ.
    pub velocity: [N; Q],
}

impl<N: Number, const Q: usize> Tangents<N, Q> {
    /// No motion depends on any parameter yet.
    pub(crate) const NONE: Self = Self {
        position: [N::ZERO; Q],
        velocity: [N::ZERO; Q],
    };

    /// Moves the tangents over the sample in which the model moved by the displacement `way` in a `phase`.
    #[inline]
    pub(crate) fn advance<S: UnknownSet<P>, const P: usize>(
        &mut self,
        values: &ModelValues<N>,
        acting: &Acting<N>,
        innovation: &Innovation<N>,
        moved: &ModelStep<N>,
    ) {
        let direction = match moved.phase {
            FrictionPhase::Moving { direction } => direction,
            _ => return self.advance_through_rest::<S, P>(values, acting, innovation, moved),
        };
        let moving = MovingStep {
            displacement: moved.displacement,
            direction,
            stribeck_factor: moved.stribeck_factor,
        };
        self.move_on::<S, P>(values, acting, innovation, &moving);
    }

    /// A sample in which the model moved, in one direction on the whole.
    #[inline]
    pub(crate) fn move_on<S: UnknownSet<P>, const P: usize>(
        &mut self,
        values: &ModelValues<N>,
        acting: &Acting<N>,
        innovation: &Innovation<N>,
        moving: &MovingStep<N>,
    ) {
        let followed = N::ONE - innovation.position;
        let braked = N::ONE - values.parameters.x;
        each::<Q>(|i| {
            let position = self.position[i];
            let kept = braked * self.velocity[i] - innovation.velocity * position;
            let velocity = match S::UNKNOWNS.get(i) {
                Some(&unknown) => kept + sensitivity(values, unknown, acting, moving),
                None => kept,
            };
            self.position[i] = followed * position + velocity;
            self.velocity[i] = velocity;
        });
    }

    /// A sample in which the model was at rest throughout, so that the tangents have no velocity.
    #[inline]
    pub(crate) fn rest(&mut self, innovation: &Innovation<N>) {
        let followed = N::ONE - innovation.position;
        each::<Q>(|i| self.position[i] = self.position[i] * followed);
    }

    /// A sample in which the model was at rest, stopped or turned.
    #[cold]
    fn advance_through_rest<S: UnknownSet<P>, const P: usize>(
        &mut self,
        values: &ModelValues<N>,
        acting: &Acting<N>,
        innovation: &Innovation<N>,
        moved: &ModelStep<N>,
    ) {
        let kept = match moved.phase {
            FrictionPhase::Turned { slowing, .. } => slowing,
            _ => N::ZERO,
        };
        if matches!(moved.phase, FrictionPhase::Stuck) {
            self.rest(innovation);
        } else {
            let moving = MovingStep {
                displacement: moved.displacement,
                direction: moved.phase.mean_direction(),
                stribeck_factor: moved.stribeck_factor,
            };
            self.move_on::<S, P>(values, acting, innovation, &moving);
        }
        each::<Q>(|i| self.velocity[i] = self.velocity[i] * kept);
    }
}

/// The acceleration per unit of an unknown over a sample. On the whole the model moved in one direction.
#[inline]
pub(crate) fn sensitivity<N: Number>(
    values: &ModelValues<N>,
    unknown: Unknown,
    acting: &Acting<N>,
    moving: &MovingStep<N>,
) -> N {
    match unknown {
        Unknown::A => -moving.displacement,
        Unknown::B => acting.command,
        Unknown::Coulomb => -moving.direction,
        Unknown::Load => N::ONE,
        Unknown::Delay => values.parameters.gain * acting.per_delay,
        Unknown::Asymmetry => -moving.displacement.magnitude(),
        Unknown::LowSpeed => -(moving.direction * moving.stribeck_factor),
        Unknown::GravitySine => acting.waves[0],
        Unknown::GravityCosine => acting.waves[1],
        Unknown::RippleSine => acting.waves[2],
        Unknown::RippleCosine => acting.waves[3],
        Unknown::DeadBand => values.parameters.gain * acting.per_dead_band,
    }
}
