//! The proof of gains for two masses: the servo slides under them.

use super::super::message::DecisionKind;
use super::super::sliding::{Lines, SlidePlan};
use super::super::{CommissionSettings, Phase};
use super::{CommissionSolver, Work};
use identifier_core::number::Number;
use identifier_core::reason::Reason;
use identifier_core::tuning::{Resonance, Tuning};

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// Gains that slides may disprove, of which each is followed by others.
    const MAX_DISPROVED: u32 = 2;

    /// The largest sensitivity's excess over 1 that disproves gains, relative to the one for every possible servo.
    const DISPROVING: f64 = 4.0 / 3.0;

    /// True if gains for two masses are to be proved.
    pub(super) fn is_thorough(&self) -> bool {
        self.settings.slide_rounds >= CommissionSettings::THOROUGH
    }

    /// The resonance that gains are looked for with.
    pub(super) fn designed_resonance(&self) -> Option<Resonance> {
        self.masses.and_then(|masses| masses.resonance)
    }

    /// Has the servo slide under the gains that were tried, with lines about their crossover and the resonance.
    pub(super) fn prove(&mut self) -> Option<DecisionKind<N>> {
        let (tuning, mode) = (self.tried?, self.designed_resonance()?.mode);
        let lines = Lines::proof(self.settings.sample_time, tuning.crossover(), &mode);
        let plan = SlidePlan::new(
            &self.settings,
            self.servo.as_ref()?,
            false,
            Some(&mode),
            &lines,
        );
        let Some(plan) = plan else {
            return self.fail(Reason::TooLittleEvidence);
        };
        self.response.begin_more(&lines);
        self.motion = Phase::Slide;
        Some(DecisionKind::Slide(plan))
    }

    /// Judges gains by all measured lines, before and under the gains.
    pub(super) fn judge_proof(&mut self, tuning: &Tuning) -> Option<DecisionKind<N>> {
        let most = 1.0 + Self::DISPROVING * (self.settings.max_sensitivity - 1.0);
        let sample_time = self.settings.sample_time;
        let mut lines = self.response.lines().iter();
        if !lines.any(|line| line.disproves(tuning, sample_time, most)) {
            self.work = Work::Nothing;
            return Some(DecisionKind::Proved);
        }
        self.tried = None;
        self.disproved += 1;
        if self.disproved > Self::MAX_DISPROVED {
            self.work = Work::Nothing;
            return self.fail_by_second_mass();
        }
        self.work = self.respond();
        None
    }
}
