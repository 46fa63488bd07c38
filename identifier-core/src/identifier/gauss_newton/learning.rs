use super::super::identify::{Event, Seen};
use super::GaussNewtonRecursion;
use super::recursion::{Mode, Recursion};
use crate::adaptation::GaussNewtonStep;
use crate::model::{Innovation, ListeningModel, Phase, Tangents};
use crate::number::Number;
use crate::parameters::{ModelParameters, Parameter, ParameterSet};

impl<N, S, const P: usize, const W: usize> GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// One sample of a running recursion.
    #[inline]
    pub(super) fn run(&self, state: &mut Recursion<N, P>, increment: N, command: N) -> Seen<N> {
        state.model.observe(increment);
        let output_error = state.model.error;
        if state.mode != Mode::Learning {
            let event = self.run_aside(state, increment, command);
            return Seen {
                output_error,
                event,
            };
        }
        let correction = Innovation::critically_damped(state.quick);
        let parameters = ModelParameters::of_set::<S, P>(&state.law.estimates());
        let slid = state
            .model
            .slide::<S, P>(&state.response, &parameters, command, &correction);
        if let Some((way, direction)) = slid {
            state
                .tangents
                .slide::<S, P>(parameters.x, command, &correction, way, direction);
        } else if let Some(event) = self.run_through_rest(state, increment, command) {
            return Seen {
                output_error,
                event,
            };
        }
        Seen {
            output_error,
            event: self.learn_from(state, output_error),
        }
    }

    /// The law's share of a sample, and what goes with it once a block.
    #[inline]
    fn learn_from(&self, state: &mut Recursion<N, P>, output_error: N) -> Event {
        let (omega, scale) = (state.measured, state.scale);
        let step = self.law.update(
            &mut state.law,
            output_error,
            &state.tangents.position,
            &state.tangents.velocity,
            state.model.velocity,
            |estimates| Self::most(omega, scale, estimates),
        );
        match step {
            GaussNewtonStep::Working => {}
            GaussNewtonStep::Moved(steps) => {
                state.follow(&steps);
                let x = ModelParameters::of_set::<S, P>(&state.law.estimates()).x;
                state.response = self.step.step.response(x);
            }
            GaussNewtonStep::Ready => {
                state.straight = state.straight.saturating_add(1);
                state.quick = state.narrowed(self.block_narrowing);
                return self.keep_in_reach(state);
            }
            GaussNewtonStep::Gathered { mean, predicted } => {
                let inflated = state.law.inflated();
                if self.has_load
                    && self
                        .load_step
                        .suspects(&mut state.suspicion, mean, predicted, inflated)
                {
                    return self.search(state);
                }
                if self.in_trouble(state, mean) {
                    return Event::Restarted;
                }
            }
        }
        Event::None
    }

    /// The largest variances that forgetting may lead to: of a from the bandwidth, of b from a factor,
    /// of friction and load from the acceleration that the command gives.
    #[inline]
    pub(super) fn most(omega: N, scale: N, estimates: &[N; P]) -> [N; P] {
        let model = ModelParameters::of_set::<S, P>(estimates);
        S::PARAMETERS.map(|parameter| {
            let deviation = match parameter {
                Parameter::A => omega + omega + model.x + model.x,
                Parameter::B => model.gain + model.gain,
                Parameter::Coulomb | Parameter::Load => scale,
            };
            deviation * deviation
        })
    }

    /// Moves the model and its tangents through any sample.
    #[inline(never)]
    pub(super) fn advance(
        &self,
        state: &mut Recursion<N, P>,
        command: N,
        correction: &Innovation<N>,
    ) -> Phase<N> {
        let parameters = ModelParameters::of_set::<S, P>(&state.law.estimates());
        let (way, phase) = state.model.advance::<S, P>(
            &self.step,
            &state.response,
            &parameters,
            command,
            correction,
        );
        state
            .tangents
            .advance::<S, P>(parameters.x, command, correction, way, phase);
        phase
    }

    /// A model that diverged is restarted. Within a block it cannot leave the range of the number
    /// format.
    #[inline]
    pub(super) fn keep_in_reach(&self, state: &mut Recursion<N, P>) -> Event {
        // NaN fails the comparison too.
        let near = state.model.error.magnitude() + state.model.velocity.magnitude() <= N::REACH;
        if near {
            Event::None
        } else {
            self.rejoin(state, N::ZERO);
            Event::Restarted
        }
    }

    /// Whether the output error has exceeded the encoder's for so long that a new fit is due. If the
    /// last one was no better, the model lacks an effect, and the correction is made faster.
    #[inline]
    fn in_trouble(&self, state: &mut Recursion<N, P>, mean: N) -> bool {
        if state.alarm > 0 {
            state.alarm -= 1;
            return false;
        }
        // Bounded, so that a single peak does not count.
        let square = (mean * mean).limited(N::ZERO, self.bounded);
        state.mean_square += self.second * (square - state.mean_square);
        if state.mean_square > self.unexplained {
            if !state.lacking {
                return true;
            }
            if state.omega < self.widest && self.bandwidth.is_none() {
                state.omega += state.omega * self.widening;
                if state.quick < state.omega {
                    state.quick = state.omega;
                }
            }
        } else if state.mean_square < self.explained && state.omega > state.measured {
            state.omega = state.omega - state.omega * self.widening;
            state.quick = state.omega;
        }
        false
    }

    /// The model restarts alongside the servo; estimates are kept.
    #[cold]
    pub(super) fn rejoin(&self, state: &mut Recursion<N, P>, velocity: N) {
        state.model = ListeningModel::alongside(velocity);
        state.tangents = Tangents::NONE;
        state.law.drop_block();
        state.quick = self.first;
        state.mode = Mode::Joining;
        state.left = self.alongside;
    }
}
