//! A commissioning in the background: its study, in slices.

use drive_link::NotAllowed;
use identifier_core::commission::{
    CommissionSettings, CommissionSolver, Decision, IdentifiedServo,
};
use identifier_core::tuning::Tuning;

use crate::channel::BackgroundEnd;
use crate::parts;

/// Blocks of the record of a motion: as many as the simulator's.
pub(crate) const BLOCKS: usize = 256;

pub(crate) type Study = CommissionSolver<f32, BLOCKS>;

/// The background's half of a commissioning.
#[derive(Debug)]
pub(crate) struct Studying {
    memory: &'static mut Option<Study>,
    /// Slices that go with a sample, and those that were done since the background last slept.
    slices: u32,
    done: u32,
    /// What was answered and found no room yet.
    answer: Option<Decision<f32>>,
    servo: Option<IdentifiedServo>,
    tuning: Option<Tuning>,
}

impl Studying {
    pub(crate) fn in_memory(memory: &'static mut Option<Study>) -> Self {
        Self {
            memory,
            slices: 1,
            done: 0,
            answer: None,
            servo: None,
            tuning: None,
        }
    }

    /// Begins a study.
    ///
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn begin(
        &mut self,
        settings: &CommissionSettings,
        slices: u32,
        channel: &mut BackgroundEnd<'_>,
    ) -> Result<(), NotAllowed> {
        let study = Study::new(settings).map_err(|error| parts::not_commissioned(&error))?;
        *self.memory = Some(study);
        self.slices = slices;
        (self.answer, self.servo, self.tuning) = (None, None, None);
        // Nothing is found now: what is still there is of a commissioning before.
        while channel.finding().is_some() {}
        Ok(())
    }

    /// There is nothing to study any more.
    pub(crate) fn end(&mut self) {
        *self.memory = None;
    }

    /// The servo as it is known so far.
    pub(crate) fn servo(&self) -> Option<&IdentifiedServo> {
        self.servo.as_ref()
    }

    /// The gains that it found last.
    pub(crate) fn tuning(&self) -> Option<&Tuning> {
        self.tuning.as_ref()
    }

    /// Takes what was found, does a slice, and hands over what it answers. True if there is more to do
    /// before the next sample; not more at once, for a stop to wait for one slice at most.
    pub(crate) fn work(&mut self, channel: &mut BackgroundEnd<'_>) -> bool {
        let Some(study) = self.memory else {
            return false;
        };
        while let Some(finding) = channel.finding() {
            study.take(&finding);
        }
        if self.answer.is_none() {
            self.answer = study.work();
        }
        if let Some(servo) = self.answer.as_ref().and_then(Decision::servo) {
            self.servo = Some(*servo);
        }
        if let Some(Decision::Tuned(candidate)) = &self.answer {
            self.tuning = Some(candidate.tuning);
        }
        if let Some(answer) = &self.answer
            && channel.answer(answer)
        {
            self.answer = None;
        }
        self.done += 1;
        let more = self.done < self.slices;
        if !more {
            self.done = 0;
        }
        more
    }
}
