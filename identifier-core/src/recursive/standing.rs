use super::GaussNewtonRecursion;
use super::recursion::Recursion;
use crate::identify::Event;
use crate::model::{Acting, FrictionPhase, IdentifiableSet, Innovation, ObserverModel, Tangents};
use crate::number::Number;
use crate::parameters::Unknown;

impl<N, S, const P: usize, const W: usize> GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// The model's part of a sample in which it may rest, stop or turn. If it stops or turns, nothing is learnt, and
    /// the estimator's work is left to the next sample. Returns the event of that sample.
    #[cold]
    #[inline(never)]
    pub(super) fn run_through_rest(
        &self,
        state: &mut Recursion<N, S, P>,
        increment: N,
        acting: &Acting<N>,
    ) -> Option<Event> {
        let correction = Innovation::critically_damped(state.correction_omega);
        let values = self.values(state);
        if state.model.rest::<S, P>(&values, acting, &correction) {
            state.tangents.rest(&correction);
            state.watch(increment);
            return self
                .stand(state, increment)
                .then_some(Event::FrictionLowered);
        }
        state.clear_hold();
        match self.advance(state, acting, &correction) {
            FrictionPhase::Moving { .. } | FrictionPhase::Stuck => None,
            FrictionPhase::Stopped { .. } | FrictionPhase::Turned { .. } => {
                state.blocks_in_motion = 0;
                state.samples_at_rest = 0;
                Some(Event::None)
            }
        }
    }

    /// A sample in which friction held the model. The servo's counts decide on standstill. If the servo is at
    /// standstill too, the model is set to its position. If the servo moves, the estimated friction is too large. It is
    /// lowered, since a model at rest cannot correct it. Returns whether it was lowered.
    #[inline]
    pub(super) fn stand(&self, state: &mut Recursion<N, S, P>, increment: N) -> bool {
        if state.samples_at_rest >= self.standstill_samples {
            state.model.error = N::ZERO;
            state.tangents = Tangents::NONE;
            state.clear_hold();
            return false;
        }
        state.samples_held += 1;
        state.moving += increment;
        state.samples_held >= self.max_held_samples && self.free_model(state)
    }

    #[cold]
    fn free_model(&self, state: &mut Recursion<N, S, P>) -> bool {
        /// Counts that the servo must have moved meanwhile. They rise by the ratio of its noise to the rounding.
        const MIN_TRAVEL_COUNTS: f64 = 4.0;
        /// The factor on the friction.
        const FRICTION_FACTOR: f64 = 0.7;
        let moving = state.moving;
        let held = core::mem::take(&mut state.samples_held);
        state.moving = N::ZERO;
        if moving.magnitude() * state.per_noise < N::from_f64(MIN_TRAVEL_COUNTS) {
            return false;
        }
        for (i, unknown) in S::UNKNOWNS.iter().enumerate() {
            if *unknown == Unknown::Coulomb {
                let lowered = state.law.estimates()[i] * N::from_f64(FRICTION_FACTOR);
                state.law.replace(i, lowered);
            }
        }
        let most = self.most(state.measured, state.scale, &state.law.estimates());
        state.law.factors.grow(N::from_f64(4.0), &most);
        state.model =
            ObserverModel::alongside(moving * N::from_count(i32::from(held)).reciprocal());
        state.tangents = Tangents::NONE;
        true
    }
}
