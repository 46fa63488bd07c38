use super::{Actuator, PositionSensor};
use crate::control::{ControlSample, Setpoint, Shaping};
use crate::error::StepError;
use crate::identify::Identify;
use crate::measurement::velocity::VelocityEstimate;
use crate::number::Number;
use crate::servo_loop::{ServoLoop, ServoLoopState};

/// Why a step was not taken. The servo was disabled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ControlStepError<S, A> {
    /// The sensor gave no count.
    Sensor(S),
    /// The controller rejected its inputs.
    Step(StepError),
    /// The actuator took no command.
    Actuator(A),
}

impl<N, V, I, H> ServoLoop<N, V, I, H>
where
    N: Number,
    V: VelocityEstimate<N>,
    I: Identify<N>,
    H: Shaping<N>,
{
    /// One control step: measure, control, act.
    ///
    /// The identifier learns from the sample afterwards ([`ServoLoop::learn`]), so that it does not delay the
    /// command. After any fault the actuator is disabled.
    ///
    /// # Errors
    /// [`ControlStepError`]; the actuator is disabled and the state unchanged.
    #[inline]
    pub fn control_step<S: PositionSensor, A: Actuator<N>>(
        &self,
        state: &mut ServoLoopState<N, V::State, I::State, H::State>,
        setpoint: Setpoint<N>,
        sensor: &mut S,
        actuator: &mut A,
    ) -> Result<ControlSample<N>, ControlStepError<S::Error, A::Error>> {
        self.control_step_with(state, setpoint, sensor, actuator, |sample| sample.command)
    }

    /// The same with another command that acts, command units, for each sample of the controller.
    ///
    /// # Errors
    /// As [`control_step`](Self::control_step).
    #[inline]
    pub fn control_step_with<S: PositionSensor, A: Actuator<N>>(
        &self,
        state: &mut ServoLoopState<N, V::State, I::State, H::State>,
        setpoint: Setpoint<N>,
        sensor: &mut S,
        actuator: &mut A,
        acting: impl FnOnce(&ControlSample<N>) -> N,
    ) -> Result<ControlSample<N>, ControlStepError<S::Error, A::Error>> {
        let taken = self.try_step(state, setpoint, sensor, actuator, acting);
        if taken.is_err() {
            // The first fault is reported, even if disabling fails too.
            let _ = actuator.release();
        }
        taken
    }

    #[inline]
    fn try_step<S: PositionSensor, A: Actuator<N>>(
        &self,
        state: &mut ServoLoopState<N, V::State, I::State, H::State>,
        setpoint: Setpoint<N>,
        sensor: &mut S,
        actuator: &mut A,
        acting: impl FnOnce(&ControlSample<N>) -> N,
    ) -> Result<ControlSample<N>, ControlStepError<S::Error, A::Error>> {
        let count = sensor.count().map_err(ControlStepError::Sensor)?;
        let before = state.controlled();
        let sample = self
            .control(state, setpoint.count, setpoint.offset, count)
            .map_err(ControlStepError::Step)?;
        let command = acting(&sample);
        if let Err(error) = actuator.hold(command) {
            state.back_to(before);
            return Err(ControlStepError::Actuator(error));
        }
        Ok(ControlSample { command, ..sample })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gradient::GradientIdentifier;
    use crate::measurement::velocity::BackwardDifference;
    use crate::parameters::{PerParameter, Unknowns};
    use crate::settings::{ControllerSettings, Settings};

    struct Sensor(Result<i32, &'static str>);

    impl PositionSensor for Sensor {
        type Error = &'static str;
        fn count(&mut self) -> Result<i32, &'static str> {
            self.0
        }
    }

    #[derive(Default)]
    struct Motor {
        held: Option<f32>,
        released: u32,
        broken: bool,
    }

    impl Actuator<f32> for Motor {
        type Error = &'static str;
        fn hold(&mut self, command: f32) -> Result<(), &'static str> {
            self.held = Some(command);
            if self.broken { Err("broken") } else { Ok(()) }
        }
        fn release(&mut self) -> Result<(), &'static str> {
            self.held = None;
            self.released += 1;
            Ok(())
        }
    }

    type Loop = ServoLoop<
        f32,
        BackwardDifference,
        GradientIdentifier<f32, BackwardDifference, Unknowns<2>, 2>,
    >;

    fn servo_loop() -> Loop {
        let mut settings = Settings {
            resolution: 1.0,
            controller: Some(ControllerSettings::pid(2.0, 0.1, 0.0).limited(100.0)),
            ..Settings::new(1e-3, 1.0)
        };
        settings.identifier.initial.b = Some(100.0);
        settings.identifier.gamma = Some(PerParameter::new(1.0, 1.0, 0.0, 0.0));
        settings.build().expect("valid")
    }

    #[test]
    fn a_step_measures_controls_and_acts_at_any_count() {
        let servo_loop = servo_loop();
        for start in [0, 1_000_000_007, i32::MAX, i32::MIN] {
            let mut state = servo_loop.start(start);
            let mut motor = Motor::default();
            let setpoint = Setpoint {
                count: start.wrapping_add(7),
                offset: 0.25,
            };
            let sample =
                servo_loop.control_step(&mut state, setpoint, &mut Sensor(Ok(start)), &mut motor);
            assert_eq!(sample.map(|sample| sample.command), Ok(14.5));
            assert_eq!(motor.held, Some(14.5));
        }
    }

    #[test]
    fn every_fault_disables_the_servo_and_leaves_the_state() {
        let servo_loop = servo_loop();
        let mut state = servo_loop.start(0);
        let before = state;
        let mut motor = Motor::default();
        let (mad, jumped) = (StepError::ErrorNotFinite, StepError::CountJumped);
        for (offset, sensor, error) in [
            (0.0, Err("lost"), ControlStepError::Sensor("lost")),
            (f32::NAN, Ok(0), ControlStepError::Step(mad)),
            (0.0, Ok(i32::MAX), ControlStepError::Step(jumped)),
            (1.0, Ok(3), ControlStepError::Actuator("broken")),
        ] {
            motor.broken = offset > 0.5;
            let setpoint = Setpoint { count: 0, offset };
            let done =
                servo_loop.control_step(&mut state, setpoint, &mut Sensor(sensor), &mut motor);
            assert_eq!(done.err(), Some(error));
        }
        assert_eq!((motor.held, motor.released), (None, 4));
        assert!(state == before);
    }
}
