//! The background's half of a mode, in slices. It is Gauss–Newton's first fit, during which the interrupt keeps
//! recording, or the solver of a commissioning.

use commissioning::{CommissionSettings, CommissionSolver};
use drive_link::{Estimator, LoopSettings, MotionRecord, NotAllowed};
use identifier_core::identifier::{GaussNewtonFitter, GaussNewtonFitterState};
use identifier_core::parameters::{IdentifiedServo, Unknowns};
use identifier_core::reason::Reason;
use identifier_core::tuning::Tuning;

use crate::built::Part;
use crate::channel::{BackgroundEnd, Recorded, Solution};
use crate::closed_loop::BLOCKS;

/// Blocks of the record of a commissioning's motion: as many as the simulator's.
const MOTION_BLOCKS: usize = 256;

/// Blocks of the record of a run that one turn of the background goes through.
const SLICE: u32 = 8;

pub(super) type CommissioningSolver = CommissionSolver<f32, MOTION_BLOCKS>;

/// Makes the first fit of a run.
pub(super) type Fitter = GaussNewtonFitter<f32, Unknowns<4>, 4, BLOCKS>;
type FitterState = GaussNewtonFitterState<f32, BLOCKS>;

/// The background's half of a mode.
#[derive(Debug)]
pub(super) struct Solver {
    /// The first fit of a run, if its estimator needs one.
    first_fit: Option<(Fitter, FitterState)>,
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
            first_fit: None,
            commissioning,
            is_commissioning: false,
            slices: 1,
            done: 0,
            pending: None,
            servo: None,
            tuning: None,
        }
    }

    /// The fitter of a run with these settings, if its estimator needs a first fit.
    #[inline(never)]
    pub(super) fn fitter(settings: &LoopSettings) -> Option<Fitter> {
        let needs_fit = settings.law == Estimator::GaussNewton;
        settings.core.build().ok().filter(|_| needs_fit)
    }

    /// Begins a run with this fitter.
    #[inline(never)]
    pub(super) fn begin_run(&mut self, fitter: Option<Fitter>) {
        self.first_fit = fitter.map(|fitter| (fitter, fitter.start()));
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
        let (fitter, state) = self.first_fit.as_ref()?;
        fitter.rejection_reason(state)
    }

    /// Standard deviation of the encoder's noise by a run's first fit, counts.
    pub(super) fn noise(&self) -> Option<f64> {
        let (fitter, state) = self.first_fit.as_ref()?;
        fitter.noise(state)
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
        if self.first_fit.is_none() && !self.is_commissioning {
            return false;
        }
        while let Some(piece) = channel.recorded() {
            match piece {
                Recorded::Block(block) => {
                    if let Some((fitter, state)) = &mut self.first_fit {
                        fitter.take(state, &block);
                    }
                }
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

    fn slice(&mut self) -> Option<Solution> {
        let Some(solver) = self.under_way() else {
            let (fitter, state) = self.first_fit.as_mut()?;
            return fitter.work(state, SLICE).map(Solution::Fit);
        };
        let decision = solver.work()?;
        self.servo = decision.servo().copied().or(self.servo);
        self.tuning = decision.tuning().copied().or(self.tuning);
        Part::of(decision).map(Solution::Decision)
    }
}
