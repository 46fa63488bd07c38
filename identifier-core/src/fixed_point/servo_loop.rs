use fixed::types::I16F16;

use super::arithmetic::Word;
use super::controller::{FixedControlState, FixedController};
use super::identifier::{FixedGradientIdentifier, FixedGradientState};
use crate::constants::{Encode, encode};
use crate::control::ControlSample;
use crate::error::StepError;
use crate::identifier::{Identify, LoopStep, Update};
use crate::measurement::velocity::VelocityEstimate;
use crate::parameters::{ParameterSet, ServoParameters};
use crate::settings::{FromSettings, Settings, SettingsError};

/// Controller and gradient identifier together on words. [`ServoLoop`](crate::identifier::ServoLoop) is the same on
/// numbers.
///
/// A sample is [`FixedServoLoop::process`]. Its two halves are [`FixedServoLoop::control`], then
/// [`FixedServoLoop::learn`], so that the command can go out first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedServoLoop<V, S, const P: usize> {
    controller: FixedController<V>,
    identifier: FixedGradientIdentifier<V, S, P>,
}

encode! {
    [V: Encode, S: ParameterSet<P>, const P: usize] FixedServoLoop<V, S, P> as "FixedServoLoop" {
        controller, identifier,
    }
}

/// State of the loop between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedServoLoopState<F, const P: usize> {
    count: i32,
    control: FixedControlState<F>,
    identification: FixedGradientState<F, P>,
}

impl<V, S, const P: usize> FromSettings for FixedServoLoop<V, S, P>
where
    V: VelocityEstimate<Word>,
    S: ParameterSet<P>,
{
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        Ok(Self {
            controller: settings.build()?,
            identifier: settings.build()?,
        })
    }
}

impl<F, const P: usize> FixedServoLoopState<F, P> {
    /// The count of the last sample.
    #[must_use]
    pub fn count(&self) -> i32 {
        self.count
    }

    /// Puts a loop that has done no sample yet at another count.
    #[inline]
    pub fn begin_at(&mut self, count: i32) {
        self.count = count;
    }

    /// State of the identifier.
    #[must_use]
    pub fn identification(&self) -> &FixedGradientState<F, P> {
        &self.identification
    }

    /// The same, for work in the background.
    pub fn identification_mut(&mut self) -> &mut FixedGradientState<F, P> {
        &mut self.identification
    }
}

impl<V, S, const P: usize> FixedServoLoop<V, S, P>
where
    V: VelocityEstimate<Word>,
    S: ParameterSet<P>,
{
    /// The controller.
    #[must_use]
    pub fn controller(&self) -> &FixedController<V> {
        &self.controller
    }

    /// The identifier.
    #[must_use]
    pub fn identifier(&self) -> &FixedGradientIdentifier<V, S, P> {
        &self.identifier
    }

    /// The estimates, SI.
    #[must_use]
    pub fn estimates(&self, state: &FixedServoLoopState<V::State, P>) -> Option<ServoParameters> {
        self.identifier.estimates(&state.identification)
    }

    /// At rest at a count.
    #[must_use]
    pub fn start(&self, count: i32) -> FixedServoLoopState<V::State, P> {
        FixedServoLoopState {
            count,
            control: self.controller.start(),
            identification: self.identifier.start(),
        }
    }

    /// Bumpless transfer from another controller that has held the servo until a count, as
    /// [`FixedController::take_over`] does. For a state that has run no sample yet, where there is no
    /// time to build a new one.
    pub fn take_over(
        &self,
        state: &mut FixedServoLoopState<V::State, P>,
        count: i32,
        last: &ControlSample<f32>,
    ) {
        state.count = count;
        state.control = self.controller.take_over(last);
        // A cast saturates.
        let increment = self.controller.increment(last.increment as i32);
        self.identifier
            .resume_moving(&mut state.identification, increment);
    }

    /// One sample towards `setpoint` counts plus an `offset`, from the present count. The offset is a fraction of a
    /// count, a moving reference or dither. Counts wrap at 32 bits.
    ///
    /// The command to give to the servo is `control.command` of the answer.
    ///
    /// # Errors
    /// As [`FixedServoLoop::control`].
    #[inline]
    pub fn process(
        &self,
        state: &mut FixedServoLoopState<V::State, P>,
        setpoint: i32,
        offset: I16F16,
        count: i32,
    ) -> Result<LoopStep<Word>, StepError> {
        let control = self.control(state, setpoint, offset, count)?;
        let seen = self.learn(state, &control);
        Ok(LoopStep { control, seen })
    }

    /// The first half: measure and control.
    ///
    /// # Errors
    /// [`StepError::CountJumped`] if the servo moved faster than `max_speed`; the state is untouched,
    /// and the servo should be disabled.
    #[inline]
    pub fn control(
        &self,
        state: &mut FixedServoLoopState<V::State, P>,
        setpoint: i32,
        offset: I16F16,
        count: i32,
    ) -> Result<ControlSample<Word>, StepError> {
        let increment = self.controller.increment(count.wrapping_sub(state.count));
        let error = self.controller.error(setpoint, offset, count);
        let sample = self
            .controller
            .process(&mut state.control, error, increment)?;
        state.count = count;
        Ok(sample)
    }

    /// The second half: learn from the sample that [`FixedServoLoop::control`] gave, its command the
    /// one that acts.
    #[inline]
    pub fn learn(
        &self,
        state: &mut FixedServoLoopState<V::State, P>,
        sample: &ControlSample<Word>,
    ) -> Update<Word> {
        self.identifier
            .update(&mut state.identification, sample.increment, sample.command)
    }

    /// The same if the command that acts differs from the controller's. Something was added to it, or a later stage
    /// limits it.
    ///
    /// # Errors
    /// As [`Identify::learn`].
    #[inline]
    pub fn learn_with(
        &self,
        state: &mut FixedServoLoopState<V::State, P>,
        sample: &ControlSample<Word>,
        command: Word,
    ) -> Result<Update<Word>, StepError> {
        self.identifier
            .learn(&mut state.identification, sample.increment, command)
    }
}
