use crate::constants::{Encode, encode};
use crate::control::{ControlSample, ControlState, Controller, Shaping, Unshaped};
use crate::error::StepError;
use crate::identify::{Identify, Update};
use crate::measurement::velocity::{LowPass, LowPassState, VelocityEstimate};
use crate::number::{Arithmetic, Encoded, Number};
use crate::parameters::ServoParameters;

/// Controller and identifier as one loop.
///
/// A sample is [`ServoLoop::process`]. Its two halves are [`ServoLoop::control`], then [`ServoLoop::learn`], so that
/// the command can go out first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoLoop<N: Arithmetic, V, I, S = Unshaped> {
    pub(crate) controller: Controller<N, V, S>,
    pub(crate) identifier: I,
}

encode! {
    [N: Encoded, V: Encode, I: Encode, S: Encode] ServoLoop<N, V, I, S> as "ServoLoop" { controller, identifier }
}

/// State of the loop between samples; H is that of its controller's shaping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoLoopState<N: Arithmetic, F, T, H = ()> {
    count: i32,
    control: ControlState<N, F, H>,
    identification: T,
}

/// The result of one sample of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopStep<N> {
    /// The controller's part.
    pub control: ControlSample<N>,
    /// The identifier's observation.
    pub seen: Update<N>,
}

impl<N: Arithmetic, F: Copy, T, H: Copy> ServoLoopState<N, F, T, H> {
    /// The controller's half of the state.
    pub(crate) fn controlled(&self) -> (i32, ControlState<N, F, H>) {
        (self.count, self.control)
    }

    /// Takes a step of the controller back.
    pub(crate) fn back_to(&mut self, (count, control): (i32, ControlState<N, F, H>)) {
        self.count = count;
        self.control = control;
    }

    /// The count of the last sample.
    #[must_use]
    pub fn count(&self) -> i32 {
        self.count
    }

    /// Sets a loop that has not run yet to another count. It saves the time to build a new state by
    /// [`ServoLoop::start`].
    #[inline]
    pub fn begin_at(&mut self, count: i32) {
        self.count = count;
    }

    /// State of the identifier.
    #[must_use]
    pub fn identification(&self) -> &T {
        &self.identification
    }

    /// The same, for work in the background.
    pub fn identification_mut(&mut self) -> &mut T {
        &mut self.identification
    }
}

impl<N, V, I, S> ServoLoop<N, V, I, S>
where
    N: Arithmetic,
    V: VelocityEstimate<N>,
    I: Identify<N>,
    S: Shaping<N>,
{
    /// The controller.
    #[must_use]
    pub fn controller(&self) -> &Controller<N, V, S> {
        &self.controller
    }

    /// The identifier.
    #[must_use]
    pub fn identifier(&self) -> &I {
        &self.identifier
    }

    /// The estimates, SI; none before there are any.
    #[must_use]
    pub fn estimates(
        &self,
        state: &ServoLoopState<N, V::State, I::State, S::State>,
    ) -> Option<ServoParameters> {
        self.identifier.estimates(&state.identification)
    }

    /// At rest at a count.
    #[must_use]
    pub fn start(&self, count: i32) -> ServoLoopState<N, V::State, I::State, S::State> {
        ServoLoopState {
            count,
            control: ControlState::default(),
            identification: self.identifier.start(),
        }
    }

    /// One sample towards `setpoint` counts plus an `offset`, from the present count. The offset is a fraction of a
    /// count, a moving reference or dither. Counts wrap at 32 bits.
    ///
    /// The command to give to the servo is `control.command` of the answer.
    ///
    /// # Errors
    /// [`StepError`]; the state is untouched, and the servo should be disabled.
    #[inline(always)]
    pub fn process(
        &self,
        state: &mut ServoLoopState<N, V::State, I::State, S::State>,
        setpoint: i32,
        offset: N::Offset,
        count: i32,
    ) -> Result<LoopStep<N>, StepError> {
        let control = self.control(state, setpoint, offset, count)?;
        let seen = self.learn(state, &control);
        Ok(LoopStep { control, seen })
    }

    /// The first half: measure and control.
    ///
    /// # Errors
    /// [`StepError`]; the state is untouched, and the servo should be disabled.
    #[inline(always)]
    pub fn control(
        &self,
        state: &mut ServoLoopState<N, V::State, I::State, S::State>,
        setpoint: i32,
        offset: N::Offset,
        count: i32,
    ) -> Result<ControlSample<N>, StepError> {
        let increment = self.controller.increment(count.wrapping_sub(state.count));
        let error = self.controller.error(setpoint, offset, count);
        let sample = self
            .controller
            .process(&mut state.control, error, increment)?;
        state.count = count;
        Ok(sample)
    }

    /// The second half: learn from the sample that [`ServoLoop::control`] gave, its command the one
    /// that acts.
    #[inline(always)]
    pub fn learn(
        &self,
        state: &mut ServoLoopState<N, V::State, I::State, S::State>,
        sample: &ControlSample<N>,
    ) -> Update<N> {
        self.identifier
            .update(&mut state.identification, sample.increment, sample.command)
    }

    /// The identifier's work in the background: see [`Identify::work`].
    #[inline]
    pub fn work(&self, state: &mut ServoLoopState<N, V::State, I::State, S::State>, budget: u32) {
        self.identifier.work(&mut state.identification, budget);
    }

    /// The same if the command that acts differs from the controller's. Something was added to it, or a later stage
    /// limits it.
    ///
    /// # Errors
    /// As [`Identify::learn`].
    #[inline]
    pub fn learn_with(
        &self,
        state: &mut ServoLoopState<N, V::State, I::State, S::State>,
        sample: &ControlSample<N>,
        command: N,
    ) -> Result<Update<N>, StepError> {
        self.identifier.check(sample.increment, command)?;
        let acted = ControlSample { command, ..*sample };
        Ok(self.learn(state, &acted))
    }
}

impl<N: Number, I: Identify<N>, S: Shaping<N>> ServoLoop<N, LowPass<N>, I, S> {
    /// From rest at a count under the command of `last`, which the first sample continues. For a state that has run no
    /// sample yet, whose identifier starts anew.
    pub fn hold_from(
        &self,
        state: &mut ServoLoopState<N, LowPassState<N>, I::State, S::State>,
        count: i32,
        last: &ControlSample<N>,
    ) {
        state.count = count;
        state.control = self.controller.take_over(last);
    }

    /// Bumpless transfer from another controller that has held the servo until a count; `last` is its
    /// last sample. For a state that has run no sample yet, where there is no
    /// time to build a new one.
    pub fn take_over(
        &self,
        state: &mut ServoLoopState<N, LowPassState<N>, I::State, S::State>,
        count: i32,
        last: &ControlSample<N>,
    ) {
        self.hold_from(state, count, last);
        self.identifier
            .resume_moving(&mut state.identification, last.increment);
    }
}
