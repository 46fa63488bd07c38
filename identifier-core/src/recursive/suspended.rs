use super::GaussNewtonRecursion;
use super::recursion::{Mode, Recursion};
use crate::identify::Event;
use crate::model::{Acting, FrictionPhase, IdentifiableSet, Innovation, ObserverModel, Tangents};
use crate::number::Number;

impl<N, S, const P: usize, const W: usize> GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// A sample in which nothing is learnt, except possibly the load.
    #[cold]
    #[inline(never)]
    pub(super) fn run_suspended(
        &self,
        state: &mut Recursion<N, S, P>,
        increment: N,
        acting: &Acting<N>,
    ) -> Event {
        state.watch(increment);
        let mut event = Event::None;
        let correction = match state.mode {
            Mode::Searching
                if state.remaining == 1
                    && state.samples_at_rest >= self.search_standstill_samples =>
            {
                // The load cannot be identified at standstill.
                event = self.wait(state);
                Innovation::critically_damped(state.correction_omega)
            }
            Mode::Searching => self.seek(state),
            Mode::Waiting => self.stay(state),
            _ => self.approach(state),
        };
        match self.advance(state, acting, &correction) {
            FrictionPhase::Stuck if self.stand(state, increment) => event = Event::FrictionLowered,
            FrictionPhase::Stuck => {}
            _ => state.clear_hold(),
        }
        match self.keep_in_reach(state) {
            Event::None => event,
            restarted => restarted,
        }
    }

    /// The load has changed in a step. If it does so repeatedly, the cause is not the load. The servo does not follow
    /// the command.
    #[cold]
    pub(super) fn search(&self, state: &mut Recursion<N, S, P>) -> Event {
        if state.alarm == 0 {
            state.trusted_load = last(&state.law.estimates());
        }
        state.alarm = state.alarm.saturating_add(self.alarm_blocks);
        if state.alarm > 4 * self.alarm_blocks {
            return self.wait(state);
        }
        // Right after a reversal too large or too small a friction looks like a step of the load.
        state.ambiguous = self.has_friction && state.blocks_in_motion < self.reversal_blocks;
        state.mode = Mode::Searching;
        state.remaining = self.search_samples;
        state.samples_at_rest = 0;
        state.correction_omega = self.joining_omega;
        state.load_step_detector.sought_from = last(&state.law.estimates());
        state.law.drop_block();
        state.law.cancel_inflation();
        Event::LoadStep
    }

    #[cold]
    fn wait(&self, state: &mut Recursion<N, S, P>) -> Event {
        state.law.replace_last(state.trusted_load, N::ZERO);
        state.law.drop_block();
        state.mode = Mode::Waiting;
        state.remaining = self.waiting_samples;
        state.samples_at_rest = 0;
        state.correction_omega = self.joining_omega;
        Event::NotFollowing
    }

    /// A sample of waiting: until the servo moves, and then for a set time.
    fn stay(&self, state: &mut Recursion<N, S, P>) -> Innovation<N> {
        if state.samples_at_rest >= self.standstill_samples {
            state.model = ObserverModel::alongside(N::ZERO);
        } else if state.is_over() {
            state.mode = Mode::Joining;
            state.remaining = self.joining_samples;
        }
        Innovation::critically_damped(state.correction_omega)
    }

    /// A sample of the search for the load. The gains on position, velocity and load are 2ω, 2ω², ω³, with all three
    /// poles at ω. The bandwidth ω narrows from sample to sample as a growing memory does.
    fn seek(&self, state: &mut Recursion<N, S, P>) -> Innovation<N> {
        let omega = state.correction_omega;
        let square = omega * omega;
        state.law.add_to_last(square * omega * state.model.error);
        state.correction_omega = state.narrowed(self.narrowing);
        if state.is_over() {
            let load = last(&state.law.estimates());
            let moved = (load - state.load_step_detector.sought_from) * N::from_f64(0.25);
            state.law.replace_last(load, moved * moved);
            if state.ambiguous {
                state.law.factors.raise(self.friction, moved * moved);
            }
            self.resume(state);
        }
        Innovation {
            position: omega + omega,
            velocity: square + square,
        }
    }

    /// A sample in which the model joins the servo's motion.
    fn approach(&self, state: &mut Recursion<N, S, P>) -> Innovation<N> {
        let omega = state.correction_omega;
        state.correction_omega = state.narrowed(self.narrowing);
        if state.is_over() {
            self.resume(state);
        }
        Innovation::critically_damped(omega)
    }

    fn resume(&self, state: &mut Recursion<N, S, P>) {
        state.mode = Mode::Learning;
        state.tangents = Tangents::NONE;
        state.law.drop_block();
        state.load_step_detector.clear();
    }
}

fn last<N: Number, const P: usize>(values: &[N; P]) -> N {
    values.last().copied().unwrap_or(N::ZERO)
}
