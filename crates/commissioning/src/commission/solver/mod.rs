mod gains;
mod order;
mod planning;
mod rounds;
mod servo;
mod trial_step;

use super::message::{DecisionKind, EventKind};
use super::response::{LineMeasurement, MeasuredResponse, ResponseFit};
use super::{
    CommissionError, CommissionSettings, Decision, Limits, MotionRecord, RecordEvent, RoughModel,
    ServoFit, ServoFitter,
};
use identifier_core::fit::Block;
use identifier_core::number::Number;
use identifier_core::reason::Reason;
use identifier_core::tuning::{
    AxisForces, Goal, MeasuredLine, Resonance, Shown, Tuner, TunerState,
};
use order::{Evidence, Step};
use planning::Planning;

/// The background's half of a commissioning: it fits, measures and tunes, a slice at a time. W is the number of blocks of
/// its record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommissionSolver<N: Number, const W: usize = 256> {
    settings: CommissionSettings,
    record: MotionRecord<N, W>,
    response: MeasuredResponse<N>,
    evidence: Evidence,
    /// The step that gains are looked for with, rad.
    step: f64,
    work: Work<N>,
}

/// The work under way. What begins and takes each has a stack of its own, which is free again.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap here, and a program holds one solver"
)]
enum Work<N: Number> {
    /// The interrupt moves the servo, or all is over.
    Nothing,
    /// The next step of the order is looked up.
    Decide,
    Fit(ServoFit<N>),
    /// Frequency-response motions are planned.
    Plan(Planning<N>),
    /// The response is measured from the sums of the motions.
    Lines(LineMeasurement),
    /// One mass and two are fitted to the measured lines.
    Masses(ResponseFit),
    /// The search for gains begins, for a goal with a step (rad), and whether that was chosen for the bandwidth.
    Tune(Goal, f64, bool),
    Gains {
        tuner: Tuner,
        state: TunerState,
        /// True if the step was already chosen for the bandwidth that was found.
        fitted: bool,
    },
    /// The next slice gives this decision.
    Decided(DecisionKind<N>),
}

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// Of no commissioning yet, in which one can [begin](Self::begin).
    #[must_use]
    #[inline]
    pub fn idle() -> Self {
        Self {
            settings: CommissionSettings::new(0.0, 0.0, Limits::new([0.0; 2], 0.0, [0.0; 2])),
            record: MotionRecord::EMPTY,
            response: MeasuredResponse::none(),
            evidence: Evidence::default(),
            step: 0.0,
            work: Work::Nothing,
        }
    }

    /// For a commissioning with these settings.
    ///
    /// # Errors
    /// As [`CommissionIsr::new`](super::CommissionIsr::new).
    pub fn new(settings: &CommissionSettings) -> Result<Self, CommissionError> {
        let mut solver = Self::idle();
        solver.begin(settings)?;
        Ok(solver)
    }

    /// Begins a commissioning with these settings where the solver is: a copy of it would take 12 kB of stack.
    ///
    /// # Errors
    /// As [`new`](Self::new), and the solver is as it was.
    pub fn begin(&mut self, settings: &CommissionSettings) -> Result<(), CommissionError> {
        settings.check()?;
        self.settings = settings.in_units_of_noise();
        self.record.clear();
        self.response.restart(&self.settings);
        self.evidence = Evidence::default();
        self.step = 0.0;
        self.work = Work::Nothing;
        Ok(())
    }

    /// Takes an event of the interrupt.
    pub fn take(&mut self, finding: &RecordEvent<N>) {
        match &finding.0 {
            EventKind::Begins => {
                self.evidence = Evidence::default();
                self.work = Work::Nothing;
                self.record.clear();
            }
            EventKind::Block(block) => {
                // A missing one shows when the motion has ended.
                let _ = self.record.take(block);
            }
            EventKind::Balance(balance) => self.response.take_balance(balance),
            EventKind::Line(sums) => self.response.take(sums),
            EventKind::Ended { .. } if self.evidence.rounds > 0 => {
                self.work = Work::Lines(self.response.begin_lines());
            }
            EventKind::Ended {
                moved,
                is_cut,
                broke_away,
            } => {
                self.evidence.broke_away = broke_away
                    .map(|broke_away| broke_away.to_f64())
                    .or(self.evidence.broke_away);
                self.take_motion(moved, *is_cut);
            }
        }
    }

    /// Takes a motion that has ended, of a servo that moved like this.
    fn take_motion(&mut self, moved: &RoughModel<N>, is_cut: bool) {
        let is_complete = self.record.is_complete();
        let rough = self.roughly(moved);
        let evidence = &mut self.evidence;
        (evidence.is_recorded, evidence.is_cut) = (is_complete, is_cut);
        if is_cut || !is_complete {
            evidence.unexplained_reason = Some(Reason::TooLittleEvidence);
        }
        evidence.fitted = rough;
        self.work = Work::Decide;
    }

    /// The record of the last probing motion: its blocks, the samples of each, and the position of a count in it, rad.
    #[must_use]
    pub fn motion_record(&self) -> (&[Block<N>], u16, f64) {
        let samples = self.record.samples().whole() as u16;
        (self.record.blocks(), samples, self.settings.resolution)
    }

    /// The frequency response that was measured, by frequency; empty before there were any.
    #[must_use]
    pub fn response(&self) -> &[MeasuredLine] {
        self.response.lines()
    }

    /// The forces beside the five numbers, as the first motion shows them, from where it began.
    #[must_use]
    pub fn forces(&self) -> &AxisForces {
        &self.evidence.forces
    }

    /// The resonance in the response, if the servo is one of two masses. None if the lines leave the gain open.
    #[must_use]
    pub fn resonance(&self) -> Option<&Resonance> {
        let masses = self
            .evidence
            .masses
            .as_ref()
            .filter(|masses| masses.is_known());
        masses?.resonance.as_ref()
    }

    /// A slice of work. It is up to a block of a pass, a line of a plan, a model or a point of the frequency response, or a
    /// sample of a predicted step. Returns an answer when there is one.
    pub fn work(&mut self) -> Option<Decision<N>> {
        self.decide().map(Decision)
    }

    fn decide(&mut self) -> Option<DecisionKind<N>> {
        match &mut self.work {
            Work::Nothing => None,
            Work::Decided(decision) => {
                let decision = *decision;
                self.work = Work::Nothing;
                Some(decision)
            }
            Work::Decide => self.proceed(Step::after(&self.evidence)),
            Work::Fit(fit) => {
                let fitted = ServoFitter::new(&self.settings).work(fit, &self.record)?;
                self.take_servo(fitted)
            }
            Work::Plan(_) => self.plan(),
            Work::Lines(measuring) => {
                if self.response.measure(measuring) {
                    self.respond();
                }
                None
            }
            Work::Masses(fit) => {
                let masses = fit.work(self.response.lines())?;
                self.take_masses(masses);
                None
            }
            Work::Tune(goal, step, fitted) => {
                let (goal, step, fitted) = (*goal, *step, *fitted);
                self.tune(goal, step, fitted);
                None
            }
            Work::Gains {
                tuner,
                state,
                fitted,
            } => {
                let is_explained = self.evidence.shows_one_mass();
                let tuned =
                    tuner.work_with(state, Shown::Lines(self.response.lines(), is_explained))?;
                let fitted = *fitted;
                self.take_tuning(tuned, fitted)
            }
        }
    }

    fn proceed(&mut self, step: Step) -> Option<DecisionKind<N>> {
        match step {
            Step::Fit => {
                self.fit();
                None
            }
            Step::FitWaves => {
                self.fit_waves();
                None
            }
            Step::FrequencyResponse | Step::MoreLines => {
                self.measure();
                None
            }
            Step::Gains => {
                self.tune_next(self.settings.goal, self.first_step(), false);
                self.publish(DecisionKind::Verified)
            }
            Step::End => {
                self.work = Work::Nothing;
                Some(DecisionKind::Failed(self.evidence.outcome(), None))
            }
        }
    }
}
