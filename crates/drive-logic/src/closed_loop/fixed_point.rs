//! The loop in fixed point, between a sensor and an actuator in single precision.

use drive_link::{Estimates, Law, LoopSettings, NotAllowed, Why};
use fixed::types::I16F16;
use identifier_core::control::{ControlSample, Setpoint};
use identifier_core::drive::{Actuator, ControlStepError, PositionSensor};
use identifier_core::fixed_point::{
    FixedGradientIdentifier, FixedServoLoop, FixedServoLoopState, Word,
};
use identifier_core::identifier::{Event, ExpectedMotion, Identify, NumberedBlock, Update};
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::parameters::{Ab, IdentifiedServo, ServoParameters};

use super::{Fitted, Handover, StepMonitor, check};
use crate::conversion;

/// State of the identifier, machine units; [`ClosedLoop::estimates`] converts it to SI.
pub(crate) type Learnt =
    <FixedGradientIdentifier<LowPass<Word>, Ab, 2> as Identify<Word>>::Snapshot;

/// No estimates: the gradient has no standard errors.
pub(crate) type Settled = core::convert::Infallible;

type State = FixedServoLoopState<<LowPass<Word> as VelocityEstimate<Word>>::State, 2>;

/// Controller and the paper's law in fixed point of 32 bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClosedLoop {
    servo_loop: FixedServoLoop<LowPass<Word>, Ab, 2>,
    state: State,
    /// The sample that is to be learnt from.
    sample: ControlSample<Word>,
    /// The last bit of a command, command units; of a velocity, counts per sample; of an output error, counts.
    command_bit: f32,
    velocity_bit: f32,
    output_error_bit: f32,
}

impl ClosedLoop {
    /// A loop at rest at count zero.
    ///
    /// # Errors
    /// The setting that is not allowed, or does not fit the format.
    pub(crate) fn new(settings: &LoopSettings) -> Result<Self, NotAllowed> {
        check(settings)?;
        if settings.law != (Law::Gradient { friction: false }) {
            return Err(conversion::refusal("law", Why::NotHere));
        }
        let servo_loop: FixedServoLoop<LowPass<Word>, Ab, 2> =
            settings.core.build().map_err(conversion::not_allowed)?;
        let last_bit = Update {
            output_error: Word::DELTA,
            event: Event::None,
        };
        Ok(Self {
            state: servo_loop.start(0),
            sample: ControlSample {
                error: Word::ZERO,
                increment: Word::ZERO,
                velocity: Word::ZERO,
                command: Word::ZERO,
            },
            command_bit: servo_loop.controller().command(Word::DELTA) as f32,
            velocity_bit: servo_loop.controller().velocity(Word::DELTA) as f32,
            output_error_bit: servo_loop.identifier().output_error(&last_bit) as f32,
            servo_loop,
        })
    }

    /// Puts a loop that has done no sample yet at another count.
    pub(crate) fn start(&mut self, count: i32) {
        self.state.begin_at(count);
    }

    /// The same, holding a servo that another controller has held until then.
    pub(crate) fn take_over(&mut self, Handover { last, count, .. }: &Handover) {
        self.servo_loop.take_over(&mut self.state, *count, last);
    }

    /// A sample: measure, control, act; have the step checked, with its count; then learn, while the command acts.
    ///
    /// # Errors
    /// The monitor ended the run.
    #[inline]
    pub(crate) fn sample<S: PositionSensor, A: Actuator<f32>, M: StepMonitor>(
        &mut self,
        setpoint: Setpoint<f32>,
        sensor: &mut S,
        actuator: &mut A,
        monitor: M,
    ) -> Result<(ControlSample<f32>, Update<f32>), M::End> {
        let step = self.control(setpoint, sensor, actuator);
        let sample = monitor.check::<S, A>(step.map(|sample| (sample, self.state.count())))?;
        let update = self.servo_loop.learn(&mut self.state, &self.sample);
        let update = Update {
            output_error: update.output_error.to_bits() as f32 * self.output_error_bit,
            event: update.event,
        };
        Ok((sample, update))
    }

    /// Measure, control, act.
    #[inline]
    fn control<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        setpoint: Setpoint<f32>,
        sensor: &mut S,
        actuator: &mut A,
    ) -> Result<ControlSample<f32>, ControlStepError<S::Error, A::Error>> {
        /// 2 to the fraction bits of an offset.
        const FRACTION: f32 = (1_u32 << I16F16::FRAC_NBITS) as f32;
        let count = sensor.count().map_err(ControlStepError::Sensor)?;
        let moved = count.wrapping_sub(self.state.count());
        // A cast saturates.
        let offset = I16F16::from_bits((setpoint.offset * FRACTION) as i32);
        let sample = self
            .servo_loop
            .control(&mut self.state, setpoint.count, offset, count)
            .map_err(ControlStepError::Step)?;
        let command = sample.command.to_bits() as f32 * self.command_bit;
        actuator.hold(command).map_err(ControlStepError::Actuator)?;
        self.sample = sample;
        Ok(ControlSample {
            // Not the word, which saturates: what watches over the loop sees the whole of it.
            error: setpoint.error(count),
            increment: moved as f32,
            velocity: sample.velocity.to_bits() as f32 * self.velocity_bit,
            command,
        })
    }

    /// The state of its identifier.
    #[inline]
    pub(crate) fn learnt(&self) -> Learnt {
        let identifier = self.servo_loop.identifier();
        identifier.snapshot(self.state.identification())
    }

    /// Estimates, SI.
    pub(crate) fn estimates(&self, learnt: &Learnt) -> Option<Estimates> {
        Some(conversion::estimates(self.servo_loop.identifier(), learnt))
    }

    /// The same, now: the gradient has no standard errors.
    pub(crate) fn all_estimates(&self) -> Option<Estimates> {
        self.estimates(&self.learnt())
    }

    /// The gradient starts as always, from its initial estimates.
    pub(crate) fn know(&mut self, _: &IdentifiedServo, _: &ExpectedMotion) {}

    /// The gradient has no standard errors.
    pub(crate) fn examine(&mut self) -> Option<Settled> {
        None
    }

    /// Of another law.
    pub(crate) fn settled_in(&self, settled: &Settled) -> Option<[ServoParameters; 2]> {
        match *settled {}
    }

    /// The gradient has no record to fit.
    pub(crate) fn exchange<'a>(
        &mut self,
        _: impl FnOnce(NumberedBlock<f32>) -> Option<&'a Fitted>,
    ) -> bool {
        false
    }
}
