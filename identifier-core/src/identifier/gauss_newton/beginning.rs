use super::super::fit::Found;
use super::super::identify::{Event, Seen};
use super::super::settings::place;
use super::recursion::{Mode, Recursion};
use super::start::Start;
use super::{GaussNewtonIdentifier, GaussNewtonIdentifierState};
use crate::model::{ListeningModel, Tangents};
use crate::number::Number;
use crate::parameters::{ModelParameters, Parameter, ParameterSet};

impl<N, S, const P: usize, const W: usize> GaussNewtonIdentifier<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// The recursion from what a fit has found.
    fn recursion(&self, found: &Found<N>, velocity: N) -> Recursion<N, P> {
        /// The fit's covariance counts this many times: it was found far from the truth, and not
        /// from white noise.
        const DOUBT: f64 = 4.0;
        let places = S::PARAMETERS.map(place);
        let estimates = places.map(|i| found.parameters[i]);
        let scale = found.acceleration.to_f64();
        // Of a motion in one direction only d − c sign(q̇) is known, not which of the two it is.
        let ambiguity = |i: usize| match S::PARAMETERS[i] {
            Parameter::Coulomb => scale * 0.5,
            Parameter::Load => scale * 0.5 * found.only_direction.to_f64(),
            Parameter::A | Parameter::B => 0.0,
        };
        let one_way = S::HAS_COULOMB && found.only_direction != N::ZERO;
        let covariance: [[f64; P]; P] = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let known = DOUBT * found.covariance[places[i]][places[j]].to_f64();
                if one_way && self.free[i] && self.free[j] {
                    known + ambiguity(i) * ambiguity(j)
                } else {
                    known
                }
            })
        });
        let omega = self.bandwidth_of(found);
        Recursion {
            model: ListeningModel::alongside(velocity),
            tangents: Tangents::NONE,
            law: self.law.start(&estimates, &covariance),
            response: self.step.step.response(found.parameters[0]),
            omega: if self.bandwidth.is_none() && found.unexplained > self.bounded {
                self.widest
            } else {
                omega
            },
            measured: omega,
            quick: self.first,
            scale: found.acceleration,
            suspicion: self.load_step.start(found.unexplained),
            mean_square: N::ZERO,
            trusted_load: N::ZERO,
            last_move: N::ZERO,
            slid: N::ZERO,
            held: 0,
            still: 0,
            alarm: 0,
            left: self.alongside,
            straight: 0,
            mode: Mode::Joining,
            lacking: false,
            ambiguous: false,
        }
    }

    fn bandwidth_of(&self, found: &Found<N>) -> N {
        self.bandwidth.unwrap_or_else(|| {
            (N::from_f64(Self::BANDWIDTH) * found.bandwidth).limited(self.slowest, self.fastest)
        })
    }

    /// A sample that is recorded too, for a fit.
    #[cold]
    #[inline(never)]
    pub(super) fn record(
        &self,
        state: &mut GaussNewtonIdentifierState<N, P, W>,
        increment: N,
        command: N,
    ) -> Seen<N> {
        let GaussNewtonIdentifierState { recursion, start } = state;
        let event = start.record(&self.blocking, increment, command);
        if let Some(found) = start.take_found() {
            if recursion.mode == Mode::Recording || self.corrects(recursion, start, &found) {
                *recursion = self.recursion(&found, start.velocity(&self.blocking));
                start.go_on(&found);
                let _ = self.run(recursion, N::ZERO, command);
                return Seen {
                    output_error: N::ZERO,
                    event: Event::Started,
                };
            }
            start.stop();
            recursion.lacking = true;
        }
        if recursion.mode == Mode::Recording {
            return Seen {
                output_error: N::ZERO,
                event,
            };
        }
        let seen = self.run(recursion, increment, command);
        Seen {
            output_error: seen.output_error,
            event: match seen.event {
                Event::Restarted => Event::None,
                event => event,
            },
        }
    }

    /// Whether a new fit shows that the estimates have gone astray: it explains the servo, or at least
    /// twice as much as the fit before. One over a motion one way sees half of the friction, and always
    /// explains that better than the estimates explain all that they have seen: it must find another b.
    fn corrects(&self, state: &Recursion<N, P>, start: &Start<N, W>, found: &Found<N>) -> bool {
        /// The part of b by which it is another.
        const APART: f64 = 0.2;
        let better = found.unexplained < self.unexplained || start.is_better(found);
        let gain = ModelParameters::of_set::<S, P>(&state.law.estimates()).gain;
        let apart = (found.parameters[1] - gain).magnitude() > N::from_f64(APART) * gain;
        better && (apart || found.only_direction == N::ZERO)
    }
}
