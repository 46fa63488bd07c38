//! The background's half of a commissioning: its solver, in slices.

use drive_link::NotAllowed;
use identifier_core::commission::{
    CommissionSettings, CommissionSolver, Decision, IdentifiedServo,
};
use identifier_core::tuning::Tuning;

use crate::channel::BackgroundEnd;
use crate::conversion;

/// Blocks of the record of a motion: as many as the simulator's.
const BLOCKS: usize = 256;

pub(super) type Solver = CommissionSolver<f32, BLOCKS>;

/// The background's half of a commissioning.
#[derive(Debug)]
pub(super) struct Solving {
    memory: &'static mut Option<Solver>,
    /// Slices that go with a sample, and those that were done since the background last slept.
    slices: u32,
    done: u32,
    /// A decision that found no room yet.
    decision: Option<Decision<f32>>,
    servo: Option<IdentifiedServo>,
    tuning: Option<Tuning>,
}

impl Solving {
    pub(super) fn in_memory(memory: &'static mut Option<Solver>) -> Self {
        Self {
            memory,
            slices: 1,
            done: 0,
            decision: None,
            servo: None,
            tuning: None,
        }
    }

    /// Begins a commissioning.
    ///
    /// # Errors
    /// The setting that is not allowed.
    pub(super) fn begin(
        &mut self,
        settings: &CommissionSettings,
        slices: u32,
        channel: &mut BackgroundEnd<'_>,
    ) -> Result<(), NotAllowed> {
        let solver = Solver::new(settings).map_err(|error| conversion::not_commissioned(&error))?;
        *self.memory = Some(solver);
        self.slices = slices;
        (self.decision, self.servo, self.tuning) = (None, None, None);
        // Events of a commissioning before.
        while channel.record_event().is_some() {}
        Ok(())
    }

    /// The commissioning is over.
    pub(super) fn end(&mut self) {
        *self.memory = None;
    }

    /// The servo as it is known so far.
    pub(super) fn servo(&self) -> Option<&IdentifiedServo> {
        self.servo.as_ref()
    }

    /// The gains that it found last.
    pub(super) fn tuning(&self) -> Option<&Tuning> {
        self.tuning.as_ref()
    }

    /// Takes the events of the record, does a slice, and hands its decision over. True if there is more to do before the
    /// next sample; not more at once, for a stop to wait for one slice at most.
    pub(super) fn work(&mut self, channel: &mut BackgroundEnd<'_>) -> bool {
        let Some(solver) = self.memory else {
            return false;
        };
        while let Some(event) = channel.record_event() {
            solver.take(&event);
        }
        if self.decision.is_none() {
            self.decision = solver.work();
        }
        if let Some(servo) = self.decision.as_ref().and_then(Decision::servo) {
            self.servo = Some(*servo);
        }
        if let Some(tuning) = self.decision.as_ref().and_then(Decision::tuning) {
            self.tuning = Some(*tuning);
        }
        if let Some(decision) = &self.decision
            && channel.decide(decision)
        {
            self.decision = None;
        }
        self.done += 1;
        let more = self.done < self.slices;
        if !more {
            self.done = 0;
        }
        more
    }
}
