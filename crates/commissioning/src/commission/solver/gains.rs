//! The search for gains.

use super::super::message::{Candidate, DecisionKind};
use super::super::noise::QUANTISATION_SIGMA;
use super::order::Evidence;
use super::{CommissionSolver, Work};
use identifier_core::number::Number;
use identifier_core::reason::Reason;
use identifier_core::tuning::{Cap, Goal, Tuner, Tuning, TuningError, TuningSettings};

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// The factor on the next step where friction holds the servo through one.
    const GROWTH: f64 = 4.0;

    /// The part of the command that the encoder's rounding may make up.
    const NOISE: f64 = 0.02;

    /// The same of an axis of which no line was measured, or whose lines may hide a resonance. Its motions hide a load on
    /// a spring that oscillates by less than half a count: β b Δu/ω² under a push Δu of half of the command. The loop
    /// bears it at a damping ratio ζ of 0.003 if b C β/(2 ζ ω²) is at most a half, which is a gain C of 2 ζ Δu a count.
    const UNSEEN: f64 = 0.003 * QUANTISATION_SIGMA;

    /// Friction at rest beyond Coulomb friction, at most, as a part of that.
    const MOST_AT_REST: f64 = 1.5;

    /// Has the next slice begin to look for gains.
    pub(super) fn tune_next(&mut self, goal: Goal, step: f64, fitted: bool) {
        self.work = Work::Tune(goal, step, fitted);
    }

    /// Begins to look for gains.
    #[inline(never)]
    pub(super) fn tune(&mut self, goal: Goal, step: f64, fitted: bool) {
        let step = step.min(self.most_room());
        self.step = step;
        let begun = self
            .evidence
            .servo()
            .ok_or(TuningError::NotKnown)
            .and_then(|servo| {
                let settings = TuningSettings {
                    goal,
                    max_noise: if self.evidence.may_hide_a_resonance() {
                        Self::UNSEEN
                    } else {
                        Self::NOISE
                    },
                    ..self.settings.tuning(self.command(&servo), step)
                };
                let resonance = self.designed_resonance();
                let tuner = Tuner::for_response(&settings, &servo, resonance.as_ref())?;
                let [start, _] = Candidate::<N>::start_and_step(step, &self.settings.limits);
                let mut forces = self.evidence.forces;
                forces = forces.at_phase(forces.order * start);
                if resonance.is_none() {
                    let coulomb = servo.parameters.coulomb;
                    let at_rest = (self.evidence.broke_away).map_or(2.0 * coulomb, |broke_away| {
                        broke_away.friction(&servo.parameters)
                    });
                    forces.most_low_speed = (at_rest - coulomb)
                        .min(Self::MOST_AT_REST * coulomb)
                        .max(0.0);
                }
                Ok(tuner.with_forces(forces))
            });
        self.work = match begun {
            Ok(tuner) => Work::Gains {
                state: tuner.start(),
                tuner,
                fitted,
            },
            // The largest step that the travel has room for is too few counts of the encoder.
            Err(TuningError::OutOfRange(error)) if error.parameter == "step" => {
                Work::Decided(DecisionKind::Failed(Reason::TooLittleEvidence, None))
            }
            Err(error) => Work::Decided(DecisionKind::Failed(Reason::NoGains, Some(error))),
        };
    }

    /// Takes what the search has found.
    #[inline(never)]
    pub(super) fn take_tuning(
        &mut self,
        tuned: Result<Tuning, TuningError>,
        fitted: bool,
    ) -> Option<DecisionKind<N>> {
        let is_largest = self.step >= self.most_room();
        let found = match &tuned {
            Ok(tuning) => tuning.cap.zip(Some(tuning.bandwidth)),
            Err(TuningError::TooFast { most, cap, .. }) => Some((*cap, *most)),
            // Uncertain lines may hold the gains below those that move it.
            Err(TuningError::DoesNotArrive) if is_largest => Some((Cap::UnseenResonance, 0.0)),
            Err(_) => None,
        };
        if let Some((Cap::UnseenResonance, bandwidth)) = found
            && self.evidence.rounds < Evidence::MAX_ROUNDS
        {
            self.look_closer(bandwidth, (tuned, fitted));
            return None;
        }
        self.settle(tuned, fitted)
    }

    /// Goes on with what the search has found.
    #[inline(never)]
    pub(super) fn settle(
        &mut self,
        tuned: Result<Tuning, TuningError>,
        fitted: bool,
    ) -> Option<DecisionKind<N>> {
        match tuned {
            Ok(tuning) => self.offer(tuning, fitted),
            Err(TuningError::DoesNotArrive) if self.step < self.most_room() => {
                // Friction holds the servo through so small a step.
                self.tune_next(self.settings.goal, Self::GROWTH * self.step, false);
                None
            }
            Err(error) => {
                self.work = Work::Nothing;
                Some(DecisionKind::Failed(Reason::NoGains, Some(error)))
            }
        }
    }

    /// Gains with the step that is to try them, which is chosen for them.
    fn offer(&mut self, tuning: Tuning, fitted: bool) -> Option<DecisionKind<N>> {
        let servo = self.evidence.servo()?;
        let step = self.step_for(&tuning, &servo);
        let other = libm::fabs(step - tuning.predicted_response.step) > 1e-3 * step;
        if !fitted && other {
            self.tune_next(Goal::Bandwidth(tuning.bandwidth), step, true);
            return None;
        }
        self.work = Work::Nothing;
        Some(match Candidate::new(&tuning, &servo, &self.settings) {
            Ok(candidate) => DecisionKind::Tuned(candidate),
            Err(_) => DecisionKind::Failed(Reason::NoGains, None),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::{CommissionSettings, Limits};
    use super::*;

    /// Lines in between leave less of a resonance that the gains must bear.
    #[test]
    fn the_largest_step_that_does_not_arrive_asks_for_lines_in_between() {
        let limits = Limits::new([-0.2, 0.2], 10.0, [-10.0, 10.0]);
        let settings = CommissionSettings::new(1e-3, 1e-3, limits);
        for (part, rounds, expected) in [
            (0.5, 1, "a larger step"),
            (1.0, 1, "lines"),
            (1.0, Evidence::MAX_ROUNDS, "the end"),
        ] {
            let mut solver = CommissionSolver::<f64>::new(&settings).expect("valid");
            solver.evidence.rounds = rounds;
            solver.step = part * solver.most_room();
            let decision = solver.take_tuning(Err(TuningError::DoesNotArrive), true);
            let next = match (&solver.work, decision) {
                (Work::Tune(..), None) => "a larger step",
                (Work::Plan(_), None) => "lines",
                (Work::Nothing, Some(DecisionKind::Failed(Reason::NoGains, _))) => "the end",
                _ => "another",
            };
            assert_eq!(next, expected, "{part} {rounds}");
        }
    }
}
