//! The background's half of a mode, in slices. It is Gauss–Newton's first fit, during which the interrupt keeps
//! recording, the gradient's memory, or the solver of a commissioning.

use commissioning::{CommissionSettings, CommissionSolver};
use drive_link::{Estimator, LoopSettings, MotionRecord, NotAllowed};
use identifier_core::identifier::{
    GaussNewtonFitter, GaussNewtonFitterState, GradientMemory, GradientMemoryState,
};
use identifier_core::parameters::{IdentifiedServo, ServoParameters, Unknowns};
use identifier_core::reason::Reason;
use identifier_core::tuning::Tuning;

use crate::built::Part;
use crate::channel::{BackgroundEnd, Recorded, Solution};
use crate::closed_loop::{BLOCKS, ClosedLoop, Learning, MotionPart};

/// Blocks of the record of a commissioning's motion: as many as the simulator's.
const MOTION_BLOCKS: usize = 256;

/// Blocks of the record of a run that one turn of the background goes through.
const SLICE: u32 = 8;

pub(super) type CommissioningSolver = CommissionSolver<f32, MOTION_BLOCKS>;

/// Makes the first fit of a run.
type Fitter = GaussNewtonFitter<f32, Unknowns<4>, 4, BLOCKS>;
type FitterState = GaussNewtonFitterState<f32, BLOCKS>;

/// The background's half of a run's estimator.
#[derive(Debug, Clone, Copy)]
pub(super) enum Learner {
    FirstFit(Fitter),
    Memory(GradientMemory<f32>),
}

/// The same with its state.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "one is kept, in a static place, and either may follow"
)]
enum Learns {
    FirstFit(Fitter, FitterState),
    Memory(GradientMemory<f32>, GradientMemoryState<f32>),
}

/// The background's half of a mode.
#[derive(Debug)]
pub(super) struct Solver {
    /// That of a run's estimator.
    run: Option<Learns>,
    /// The solver of a commissioning, and whether that is under way. The record of one that is over is kept for the
    /// host.
    commissioning: &'static mut Option<Part<CommissioningSolver>>,
    is_commissioning: bool,
    /// Slices of a commissioning that go with a sample, and those that were done since the background last slept.
    slices: u32,
    done: u32,
    /// A solution that found no room yet.
    pending: Option<Solution>,
    servo: Option<IdentifiedServo>,
    tuning: Option<Tuning>,
}

impl Solver {
    pub(super) fn in_memory(commissioning: &'static mut Option<Part<CommissioningSolver>>) -> Self {
        Self {
            run: None,
            commissioning,
            is_commissioning: false,
            slices: 1,
            done: 0,
            pending: None,
            servo: None,
            tuning: None,
        }
    }

    /// The background's half of a run with these settings and this loop.
    #[inline(never)]
    pub(super) fn learner(settings: &LoopSettings, closed_loop: &ClosedLoop) -> Option<Learner> {
        match settings.law {
            Estimator::GaussNewton => settings.core.build().ok().map(Learner::FirstFit),
            Estimator::Gradient { .. } => closed_loop.memory().map(Learner::Memory),
        }
    }

    /// Begins a run.
    #[inline(never)]
    pub(super) fn begin_run(&mut self, learner: Option<Learner>) {
        self.run = learner.map(|learner| match learner {
            Learner::FirstFit(fitter) => Learns::FirstFit(fitter, fitter.start()),
            Learner::Memory(memory) => Learns::Memory(memory, memory.start()),
        });
        self.pending = None;
    }

    /// Begins a commissioning.
    ///
    /// # Errors
    /// The setting that is not allowed.
    #[inline(never)]
    pub(super) fn begin_commissioning(
        &mut self,
        settings: &CommissionSettings,
        slices: u32,
    ) -> Result<(), NotAllowed> {
        if let Some(solver) = self.commissioning {
            solver.begin(settings)?;
        }
        self.is_commissioning = true;
        self.slices = slices;
        (self.servo, self.tuning) = (None, None);
        Ok(())
    }

    /// A commissioning is over.
    pub(super) fn end_commissioning(&mut self) {
        self.is_commissioning = false;
        // A fit may still be for the run in whose place it was ordered.
        if matches!(self.pending, Some(Solution::Decision(_))) {
            self.pending = None;
        }
    }

    /// The record of the last motion of a commissioning that is over, from a block on.
    pub(super) fn motion_record(&self, first: u16) -> MotionRecord {
        let over = self
            .commissioning
            .as_ref()
            .filter(|_| !self.is_commissioning);
        let record = over.map(|solver| solver.motion_record());
        let record = record.filter(|(blocks, ..)| !blocks.is_empty());
        record.map_or(MotionRecord::NONE, |record| {
            MotionRecord::from(record, first)
        })
    }

    /// The solver of the commissioning under way.
    fn under_way(&mut self) -> Option<&mut Part<CommissioningSolver>> {
        let solver = self.commissioning.as_mut();
        solver.filter(|_| self.is_commissioning)
    }

    /// Why a run's estimator has no first fit after a second of motion.
    pub(super) fn rejection_reason(&self) -> Option<Reason> {
        let Some(Learns::FirstFit(fitter, state)) = &self.run else {
            return None;
        };
        fitter.rejection_reason(state)
    }

    /// Standard deviation of the encoder's noise by a run's first fit, counts.
    pub(super) fn noise(&self) -> Option<f64> {
        let Some(Learns::FirstFit(fitter, state)) = &self.run else {
            return None;
        };
        fitter.noise(state)
    }

    /// Standard errors of the estimates of a run's gradient, SI.
    #[inline(never)]
    pub(super) fn standard_errors(&self) -> Option<ServoParameters> {
        let Some(Learns::Memory(memory, state)) = &self.run else {
            return None;
        };
        memory.report(state).errors_of_parameters()
    }

    /// The servo as a commissioning knows it so far.
    pub(super) fn servo(&self) -> Option<&IdentifiedServo> {
        self.servo.as_ref()
    }

    /// The gains that a commissioning found last.
    pub(super) fn tuning(&self) -> Option<&Tuning> {
        self.tuning.as_ref()
    }

    /// Takes in the record, does a slice, and hands over what it finds. True if there is more to do before the next
    /// sample. It does one slice at a time, so that a stop waits for one slice only.
    #[inline(never)]
    pub(super) fn work(&mut self, channel: &mut BackgroundEnd<'_>) -> bool {
        if self.run.is_none() && !self.is_commissioning {
            return false;
        }
        while let Some(piece) = channel.recorded() {
            match piece {
                Recorded::Motion(part) => self.learn(&part),
                Recorded::Event(event) => {
                    if let Some(solver) = self.under_way() {
                        solver.take(&event);
                    }
                }
            }
        }
        if self.pending.is_none()
            && let Some(solution) = self.slice()
        {
            self.pending = Some(solution);
        }
        if let Some(solution) = &self.pending
            && channel.hand_over(solution)
        {
            self.pending = None;
        }
        self.done += 1;
        let more = self.is_commissioning && self.done < self.slices;
        if !more {
            self.done = 0;
        }
        more
    }

    /// Takes in a part of the motion of a run.
    fn learn(&mut self, part: &MotionPart) {
        match (&mut self.run, part) {
            (Some(Learns::FirstFit(fitter, state)), MotionPart::Block(block)) => {
                fitter.take(state, block);
            }
            (Some(Learns::Memory(memory, state)), MotionPart::Piece(piece, estimates)) => {
                if let Some(found) = memory.process(state, piece, estimates) {
                    // It takes the place of one that was not handed over.
                    self.pending = Some(Solution::Run(Learning::Correction(found)));
                }
            }
            // What is left of a run before.
            _ => {}
        }
    }

    fn slice(&mut self) -> Option<Solution> {
        let Some(solver) = self.under_way() else {
            let Some(Learns::FirstFit(fitter, state)) = &mut self.run else {
                return None;
            };
            let fitted = fitter.work(state, SLICE)?;
            return Some(Solution::Run(Learning::Fit(fitted)));
        };
        let decision = solver.work()?;
        self.servo = decision.servo().copied().or(self.servo);
        self.tuning = decision.tuning().copied().or(self.tuning);
        Part::of(decision).map(Solution::Decision)
    }
}
