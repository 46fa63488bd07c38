//! The slides that measure the response: once, or again where they did not show enough.

use super::super::Phase;
use super::super::message::DecisionKind;
use super::super::response::ResponseEstimate;
use super::super::sliding::{Lines, SlidePlan};
use super::{CommissionSolver, Early, Then, Work};
use identifier_core::number::Number;
use identifier_core::reason::Reason;
use identifier_core::tuning::Mode;

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// Surveys, and those after which an uncertain servo shows no second mass.
    const MAX_SURVEYS: u32 = 3;
    const MAX_CHECKS: u32 = 2;

    /// The largest ratio between the gain of the response and that of the motions of one mass.
    const ALIKE: f64 = 1.25;

    /// The lowest frequency of lines between the others over the bandwidth: twice its crossover.
    const ABOVE: f64 = 4.0;

    /// A resonance below this is looked for with low lines, rad/s.
    const LOW: f64 = 45.0 * core::f64::consts::TAU;

    /// True if the first motion is not explained, and the servo has not slid yet.
    pub(super) fn is_first_doubt(&self) -> bool {
        let is_first = matches!(self.motion, Phase::ReleasedCheck | Phase::Probing);
        is_first && self.early == Early::NotYet && self.servo.is_some()
    }

    /// Slides before any further motion, which one mass would not explain either.
    pub(super) fn slide_early(&mut self, reason: Reason) -> Option<DecisionKind<N>> {
        self.early = Early::UnderWay;
        self.then(Then::Slide(Some(reason)))
    }

    /// Goes on as if the servo had not slid, as the response does not show two masses.
    pub(super) fn settle_early(&mut self) -> Option<DecisionKind<N>> {
        self.early = Early::Over { shown: self.masses };
        (self.motion, self.servo, self.masses) = (Phase::Probing, None, None);
        self.work = Work::Fitting(self.fitter.begin(&self.record, None));
        None
    }

    /// Begins to measure the response of a servo whose motions one mass does not explain. The reason is given if there
    /// is one.
    pub(super) fn survey(&mut self, doubt: Option<Reason>) -> Option<DecisionKind<N>> {
        self.doubt = doubt;
        (self.masses, self.surveys) = (None, 0);
        if doubt.is_none() && self.settings.slide_rounds == 0 {
            return self.then(Then::Settle);
        }
        let lines = Lines::survey(self.settings.sample_time);
        self.response.begin(&lines);
        self.slide(None, &lines)
    }

    /// True if further slides may show more of an uncertain servo, until two masses are within tolerance.
    pub(super) fn is_to_slide_again(&self, masses: &ResponseEstimate) -> bool {
        match masses.resonance {
            _ if self.doubt.is_none() => false,
            Some(_) => self.surveys < Self::MAX_SURVEYS && !masses.are_known_well(),
            // The antiresonance may be below the lines, or a narrow resonance between two of them.
            None => self.surveys < Self::MAX_CHECKS && !self.is_as_it_moved(masses),
        }
    }

    /// True if one mass explains the response, with the gain of the motions. The unexplained part of these is then no
    /// resonance.
    fn is_as_it_moved(&self, masses: &ResponseEstimate) -> bool {
        let gain = self
            .servo
            .map_or(0.0, |servo| masses.gain / servo.parameters.b);
        masses.is_one_mass() && (1.0 / Self::ALIKE..=Self::ALIKE).contains(&gain)
    }

    /// Slides once more. The estimate of an uncertain servo is from now on that of the earlier slides.
    pub(super) fn slide_again(&mut self) -> Option<DecisionKind<N>> {
        let time = self.settings.sample_time;
        let mode = self.improve();
        let is_low = mode.is_none_or(|mode| mode.frequency < Self::LOW);
        let is_clear = self.masses.is_some_and(|masses| masses.is_explained());
        let lines = if is_low && (is_clear || self.surveys > 1) {
            Lines::low(time)
        } else {
            Lines::survey(time)
        };
        self.response.begin_below(&lines);
        self.slide(mode.as_ref(), &lines)
    }

    /// Measures the frequency response a last time, with lines between the others. The reason is a resonance that these
    /// show in part and that prevents gains at this bandwidth (rad/s). None if there is no room for it.
    pub(super) fn look_closer(&mut self, bandwidth: f64) -> Option<DecisionKind<N>> {
        if self.surveys >= Self::MAX_SURVEYS {
            return None;
        }
        let (time, servo) = (self.settings.sample_time, self.servo.as_ref()?);
        let lines = Lines::between(time, Self::ABOVE * bandwidth);
        let mode = self.designed_resonance().map(|resonance| resonance.mode);
        let plan = SlidePlan::new(&self.settings, servo, false, mode.as_ref(), &lines)?;
        self.surveys = Self::MAX_SURVEYS;
        self.response.begin_more(&lines);
        (self.work, self.motion) = (Work::Nothing, Phase::Slide);
        Some(DecisionKind::Slide(plan))
    }

    /// Goes on without lines: slides that the servo did not follow are done again.
    pub(super) fn miss_lines(&mut self) -> Option<DecisionKind<N>> {
        match self.masses {
            _ if self.louder.is_some() => self.fail(Reason::LacksResonance),
            _ if self.doubt.is_some() && self.surveys < Self::MAX_SURVEYS => self.slide_again(),
            Some(masses) => self.take_masses(masses),
            None => self.then(Then::Settle),
        }
    }

    /// Has the servo be as its response shows it, friction included, and returns the mode of two masses.
    fn improve(&mut self) -> Option<Mode> {
        let servo = self.servo.as_mut()?;
        if let Some(masses) = self.masses {
            masses.improve(servo);
        }
        if let Some([coulomb, load]) = self.response.friction(&servo.parameters) {
            (servo.parameters.coulomb, servo.parameters.load) = (coulomb, load);
        }
        Some(self.designed_resonance()?.mode)
    }

    /// Has the servo slide with these lines; what was measured before must do where there is no room.
    fn slide(&mut self, mode: Option<&Mode>, lines: &Lines) -> Option<DecisionKind<N>> {
        let is_doubted = self.doubt.is_some() && self.surveys == 0;
        let servo = self.servo.as_ref();
        let plan =
            servo.and_then(|servo| SlidePlan::new(&self.settings, servo, is_doubted, mode, lines));
        let Some(plan) = plan else {
            return self.then(Then::Settle);
        };
        self.work = Work::Nothing;
        self.surveys += 1;
        self.motion = Phase::Slide;
        Some(DecisionKind::Slide(plan))
    }
}
