use super::GaussNewtonRecursion;
use super::fitted::{B, FirstFitSolution};
use super::interrupt::GaussNewtonRecursionState;
use super::recursion::{Mode, Recursion};
use crate::fit::place_of;
use crate::identify::{Event, Update};
use crate::linalg::Factors;
use crate::model::{Acting, IdentifiableSet, ModelValues, ObserverModel};
use crate::number::Number;
use crate::parameters::Unknown;

impl<N, S, const P: usize, const W: usize> GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// The recursion that starts from a fit result, and keeps the terms that have entered `before`.
    pub(super) fn recursion(
        &self,
        result: &FirstFitSolution<N>,
        before: &Recursion<N, S, P>,
        velocity: N,
    ) -> Recursion<N, S, P> {
        let omega = self.bandwidth_of(result);
        let places = S::UNKNOWNS.map(place_of);
        let estimates = places.map(|place| {
            let found = place.and_then(|place| result.estimates.get(place));
            found.copied().unwrap_or(N::ZERO)
        });
        let parameters = ModelValues::from_values::<S, P>(&estimates).parameters;
        let covariance = Factors::placed(&result.covariance, &places);
        let mut law = self.law.start_from(&estimates, covariance, result.noise);
        if S::HAS_TERMS {
            self.keep_terms(&mut law, before, omega, result.acceleration);
        }
        let lacks = self.bandwidth.is_none() && result.unexplained > self.max_square * result.noise;
        Recursion {
            model: ObserverModel::alongside(velocity),
            omega: if lacks {
                self.max_unexplained_omega
            } else {
                omega
            },
            measured: omega,
            correction_omega: self.joining_omega,
            scale: result.acceleration,
            trusted_gain: parameters.gain,
            per_noise: result.per_noise,
            remaining: self.joining_samples,
            mode: Mode::Joining,
            ..Recursion::new(
                law,
                before.inputs,
                before.entered,
                self.step.step.response(parameters.x),
                self.load_step
                    .start(result.unexplained * result.per_noise * result.per_noise),
            )
        }
    }

    fn bandwidth_of(&self, result: &FirstFitSolution<N>) -> N {
        self.bandwidth.unwrap_or_else(|| {
            (N::from_f64(Self::BANDWIDTH) * result.bandwidth)
                .limited(self.min_omega, self.max_omega)
        })
    }

    /// A sample that is recorded too, for a fit.
    #[cold]
    #[inline(never)]
    pub(super) fn record(
        &self,
        state: &mut GaussNewtonRecursionState<N, S, P>,
        increment: N,
        acting: &Acting<N>,
    ) -> Update<N> {
        state
            .recorder
            .push(&self.blocking, increment, acting.command);
        let mut event = Event::None;
        if let Some(fitted) = state.fitted.take() {
            match &fitted.explained {
                Some(result) if self.is_due(state, result) => {
                    let velocity = state.recorder.velocity();
                    state.recursion = self.recursion(result, &state.recursion, velocity);
                    state.usual = result.unexplained;
                    state.recording = false;
                    let _ = self.run(&mut state.recursion, N::ZERO, acting);
                    return Update {
                        output_error: N::ZERO,
                        event: Event::Started,
                    };
                }
                _ if !state.is_uncertain => state.recording = false,
                Some(_) => {
                    // So far blocks were weighted as if the model were complete.
                    state.recursion.lacking = true;
                    state.recursion.trusted_gain = self.values(&state.recursion).parameters.gain;
                    self.law.settle_anew(&mut state.recursion.law);
                    state.recording = false;
                }
                None if state.recursion.mode == Mode::Recording => event = Event::FirstFitOverdue,
                None => event = Event::NotFollowing,
            }
        }
        if state.recursion.mode == Mode::Recording {
            return Update {
                output_error: N::ZERO,
                event,
            };
        }
        let seen = self.run(&mut state.recursion, increment, acting);
        Update {
            output_error: seen.output_error,
            event: match seen.event {
                Event::Restarted if state.is_uncertain => Event::None,
                Event::Restarted => {
                    state.record_anew();
                    state.is_uncertain = true;
                    Event::Restarted
                }
                event => event,
            },
        }
    }

    /// True if the recursion is to start from a fit result: it does not run yet, or it has diverged.
    fn is_due(
        &self,
        state: &mut GaussNewtonRecursionState<N, S, P>,
        result: &FirstFitSolution<N>,
    ) -> bool {
        state.recursion.mode == Mode::Recording || self.corrects(state, result)
    }

    /// True if the recursion must continue from a new fit. If the estimates are uncertain, the fit must explain the
    /// servo, or leave less than half of the residual of the fit before. If the fit only checks them, it must confirm
    /// another b, or be more certain than they are. A fit to motion in one direction covers half of the friction. It
    /// always explains that motion better than the estimates explain all data, so its b must differ too.
    fn corrects(
        &self,
        state: &mut GaussNewtonRecursionState<N, S, P>,
        result: &FirstFitSolution<N>,
    ) -> bool {
        /// The relative difference from which b counts as different.
        const MIN_GAIN_DIFFERENCE: f64 = 0.2;
        let better = result.unexplained < self.unexplained_variance * result.noise
            || result.unexplained + result.unexplained < state.usual;
        let gain = self.values(&state.recursion).parameters.gain;
        let difference = (result.estimates[B] - gain).magnitude();
        let apart = difference > N::from_f64(MIN_GAIN_DIFFERENCE) * gain;
        let confirms = Self::confirms(state, result, apart.then_some(difference));
        if state.is_uncertain {
            better && (apart || !result.one_way)
        } else {
            confirms || self.knows_better(state, result)
        }
    }

    /// True if a fit contradicts the estimate of b for certain, and the fit before it did so with the same b. `apart`
    /// is the difference of b. One fit is not enough: a fit in a wrong minimum is certain too.
    fn confirms(
        state: &mut GaussNewtonRecursionState<N, S, P>,
        result: &FirstFitSolution<N>,
        apart: Option<N>,
    ) -> bool {
        /// The standard errors of the fit from which b is another for certain.
        const CERTAIN: f64 = 5.0;
        /// The relative difference up to which two fits agree.
        const AGREEMENT: f64 = 0.1;
        let least = N::from_f64(CERTAIN * CERTAIN) * result.covariance.variance(B);
        let contradicts = !result.one_way && apart.is_some_and(|by| by * by > least);
        let found = result.estimates[B];
        let now = if contradicts { found } else { N::ZERO };
        let before = core::mem::replace(&mut state.contradiction, now);
        contradicts && (found - before).magnitude() < N::from_f64(AGREEMENT) * found
    }

    /// True if a fit that checks the estimates has a quarter of their standard errors of b and friction. After it has
    /// followed a change, the recursion does not know its own accuracy.
    fn knows_better(
        &self,
        state: &GaussNewtonRecursionState<N, S, P>,
        result: &FirstFitSolution<N>,
    ) -> bool {
        /// The ratio of the variances.
        const RATIO: f64 = 16.0;
        let own = &state.recursion.law;
        let knows = |(i, unknown): (usize, &Unknown)| match place_of(*unknown) {
            Some(place) if place == B || i == self.friction => {
                N::from_f64(RATIO) * result.covariance.variance(place) < own.factors.variance(i)
            }
            _ => true,
        };
        !result.one_way && S::UNKNOWNS.iter().enumerate().all(knows)
    }
}
