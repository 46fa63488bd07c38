use super::GaussNewtonRecursion;
use super::law::GaussNewtonStep;
use super::recursion::{Mode, Recursion};
use crate::identify::{Event, Update};
use crate::model::{
    Acting, FrictionPhase, IdentifiableSet, Innovation, KnownInputs, ModelValues, ObserverModel,
    Tangents,
};
use crate::number::Number;
use crate::parameters::PerQuantity;
use crate::unrolled::from_fn;

impl<N, S, const P: usize, const W: usize> GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// One sample of a running recursion.
    #[inline]
    pub(super) fn run(
        &self,
        state: &mut Recursion<N, S, P>,
        increment: N,
        acting: &Acting<N>,
    ) -> Update<N> {
        state.model.observe(increment);
        let output_error = state.model.error;
        if state.mode != Mode::Learning {
            let event = self.run_suspended(state, increment, acting);
            return Update {
                output_error,
                event,
            };
        }
        let correction = Innovation::critically_damped(state.correction_omega);
        let values = self.values(state);
        let moving = state
            .model
            .move_on::<S, P>(&state.response, &values, acting, &correction);
        if let Some(moving) = moving {
            state
                .tangents
                .move_on::<S, P>(&values, acting, &correction, &moving);
        } else if let Some(event) = self.run_through_rest(state, increment, acting) {
            return Update {
                output_error,
                event,
            };
        }
        Update {
            output_error,
            event: self.learn_from(state, output_error),
        }
    }

    /// The inputs from this sample to the next.
    #[inline]
    pub(super) fn acting(
        &self,
        state: &mut Recursion<N, S, P>,
        increment: N,
        command: N,
    ) -> Acting<N> {
        let terms = self.values(state).terms;
        state.inputs.take(
            &self.angle,
            &terms,
            increment,
            command,
            state.model.velocity,
        )
    }

    /// The estimates as those of a model.
    #[inline]
    pub(super) fn values(&self, state: &Recursion<N, S, P>) -> ModelValues<N> {
        let mut values = ModelValues::from_values::<S, P>(&state.law.estimates());
        values.terms.per_low_speed_velocity = self.per_low_speed_velocity;
        values
    }

    /// The estimator's share of a sample, and its work once a block.
    #[inline]
    fn learn_from(&self, state: &mut Recursion<N, S, P>, output_error: N) -> Event {
        let (omega, scale) = (state.measured, state.scale);
        let step = self.law.update(
            &mut state.law,
            output_error,
            &state.tangents.position,
            &state.tangents.velocity,
            state.model.velocity,
            |estimates| self.most(omega, scale, estimates),
        );
        match step {
            GaussNewtonStep::Working => {}
            GaussNewtonStep::Moved(steps) => {
                state.follow(&steps);
                state.response = self.step.step.response(self.values(state).parameters.x);
            }
            GaussNewtonStep::Ready => {
                state.blocks_in_motion = state.blocks_in_motion.saturating_add(1);
                state.correction_omega = state.narrowed(self.block_narrowing);
                return self.keep_in_reach(state);
            }
            GaussNewtonStep::Gathered { mean, predicted } => {
                let inflation = state.law.inflation;
                let relative = mean * state.per_noise;
                let predicted = predicted * state.per_noise * state.per_noise;
                if self.has_load
                    && self.load_step.detects(
                        &mut state.load_step_detector,
                        relative,
                        predicted,
                        inflation,
                    )
                {
                    return self.search(state);
                }
                if S::HAS_TERMS && self.count_motion(state) {
                    return Event::TermEntered;
                }
                if self.in_trouble(state, relative) {
                    return Event::Restarted;
                }
            }
        }
        Event::None
    }

    /// The largest variances that forgetting may lead to. That of a follows from the bandwidth, that of b from a
    /// factor. Those of friction, load and other accelerations follow from the acceleration by the command.
    #[inline]
    pub(super) fn most(&self, omega: N, scale: N, estimates: &[N; P]) -> [N; P] {
        let model = ModelValues::from_values::<S, P>(estimates).parameters;
        let most = PerQuantity {
            rate: omega + omega + model.x + model.x,
            gain: model.gain + model.gain,
            acceleration: scale,
            time: self.max_delay_deviation,
            command: N::REACH,
        };
        from_fn(N::ZERO, |i| {
            let deviation = most.get(S::UNKNOWNS[i]);
            deviation * deviation
        })
    }

    /// Moves the model and its tangents through any sample.
    #[inline(never)]
    pub(super) fn advance(
        &self,
        state: &mut Recursion<N, S, P>,
        acting: &Acting<N>,
        correction: &Innovation<N>,
    ) -> FrictionPhase<N> {
        let values = self.values(state);
        let moved =
            state
                .model
                .advance::<S, P>(&self.step, &state.response, &values, acting, correction);
        state
            .tangents
            .advance::<S, P>(&values, acting, correction, &moved);
        moved.phase
    }

    /// A model that diverged is restarted. Within a block it cannot leave the range of the number
    /// format.
    #[inline]
    pub(super) fn keep_in_reach(&self, state: &mut Recursion<N, S, P>) -> Event {
        // NaN fails the comparison too.
        let near = state.model.error.magnitude() + state.model.velocity.magnitude() <= N::REACH;
        if near {
            Event::None
        } else {
            self.rejoin(state, N::ZERO);
            Event::Restarted
        }
    }

    /// True if a new fit is needed. The output error has exceeded the encoder's for too long, or b is far from the
    /// fitted one. If the last fit was no better, the model lacks an effect, and the correction is made faster.
    #[inline]
    fn in_trouble(&self, state: &mut Recursion<N, S, P>, mean: N) -> bool {
        /// The factor to either side.
        const MAX_GAIN_FACTOR: f64 = 4.0;
        let far = N::from_f64(MAX_GAIN_FACTOR);
        let gain = self.values(state).parameters.gain;
        if gain * far < state.trusted_gain || gain > far * state.trusted_gain {
            return true;
        }
        if state.alarm > 0 {
            state.alarm -= 1;
            return false;
        }
        // Bounded, so that a single peak does not count.
        let square = (mean * mean).limited(N::ZERO, self.max_square);
        state.mean_square += self.mean_square_weight * (square - state.mean_square);
        if state.mean_square > self.unexplained_variance {
            if !state.lacking {
                return true;
            }
            if state.omega < self.max_unexplained_omega && self.bandwidth.is_none() {
                state.omega += state.omega * self.widening;
                // An unmodelled effect shows as ω⁻² in errors and in sensitivities.
                state.law.forget_peak(N::from_f64(4.0) * self.widening);
                if state.correction_omega < state.omega {
                    state.correction_omega = state.omega;
                }
            }
        } else if state.mean_square < self.explained_variance && state.omega > state.measured {
            state.omega = state.omega - state.omega * self.widening;
            state.correction_omega = state.omega;
        }
        false
    }

    /// The model restarts alongside the servo; estimates are kept.
    #[cold]
    pub(super) fn rejoin(&self, state: &mut Recursion<N, S, P>, velocity: N) {
        state.model = ObserverModel::alongside(velocity);
        state.tangents = Tangents::NONE;
        state.law.drop_block();
        state.correction_omega = self.joining_omega;
        state.mode = Mode::Joining;
        state.remaining = self.joining_samples;
    }
}
