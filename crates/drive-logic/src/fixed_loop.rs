//! The loop in fixed point, between a sensor and an actuator that do not know of it.

use drive_link::Estimates;
use fixed::types::I16F16;
use identifier_core::control::{ControlSample, position_error};
use identifier_core::drive::{Actuator, ControlStepError, PositionSensor, Setpoint};
use identifier_core::fixed_point::{
    FixedControlSample, FixedLowPass, FixedServoLoop, FixedServoLoopState, FixedVelocity, Word,
};
use identifier_core::identifier::{Event, Identify, Update};
use identifier_core::parameters::Ab;
use identifier_core::settings::{Settings, SettingsError};

use crate::held::Held;
use crate::parts;

type State = FixedServoLoopState<<FixedLowPass as FixedVelocity>::State, 2>;

/// Controller and the paper's law on words of 32 bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FixedLoop {
    servo_loop: FixedServoLoop<FixedLowPass, Ab, 2>,
    state: State,
    /// The sample that is to be learnt from.
    sample: FixedControlSample,
    /// What the last bit of a command is, command units; of a velocity, counts per sample; of an output
    /// error, counts.
    command_bit: f32,
    velocity_bit: f32,
    output_error_bit: f32,
}

impl FixedLoop {
    /// # Errors
    /// The setting that is not allowed, or does not fit words.
    pub(crate) fn new(settings: &Settings) -> Result<Self, SettingsError> {
        let servo_loop: FixedServoLoop<FixedLowPass, Ab, 2> = settings.build()?;
        let last_bit = Update {
            output_error: Word::DELTA,
            event: Event::None,
        };
        Ok(Self {
            state: servo_loop.start(0),
            sample: FixedControlSample {
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

    pub(crate) fn start(&mut self, count: i32) {
        self.state.begin_at(count);
    }

    pub(crate) fn take_over(&mut self, held: &Held) {
        let Held { last, count, .. } = held;
        self.servo_loop.take_over(&mut self.state, *count, last);
    }

    pub(crate) fn count(&self) -> i32 {
        self.state.count()
    }

    /// Measure, control, act.
    #[inline]
    pub(crate) fn control<S: PositionSensor, A: Actuator<f32>>(
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
            error: position_error(setpoint.count, setpoint.offset, count),
            increment: moved as f32,
            velocity: sample.velocity.to_bits() as f32 * self.velocity_bit,
            command,
        })
    }

    /// Learns from the sample that [`FixedLoop::control`] took.
    #[inline]
    pub(crate) fn learn(&mut self) -> Update<f32> {
        let seen = self.servo_loop.learn(&mut self.state, &self.sample);
        Update {
            output_error: seen.output_error.to_bits() as f32 * self.output_error_bit,
            event: seen.event,
        }
    }

    #[inline]
    pub(crate) fn learnt(&self) -> <Identifier as Identify<Word>>::Snapshot {
        let identifier = self.servo_loop.identifier();
        identifier.snapshot(self.state.identification())
    }

    pub(crate) fn estimates(&self, learnt: &<Identifier as Identify<Word>>::Snapshot) -> Estimates {
        parts::estimates(self.servo_loop.identifier(), learnt)
    }
}

/// What identifies in it.
pub(crate) type Identifier =
    identifier_core::fixed_point::FixedGradientIdentifier<FixedLowPass, Ab, 2>;
