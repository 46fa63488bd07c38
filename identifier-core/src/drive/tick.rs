use super::{Actuator, PositionSensor};
use crate::control::{ControlSample, ControlState, Controller};
use crate::error::StepError;
use crate::measurement::origin::Origin;
use crate::measurement::velocity::VelocityEstimate;
use crate::number::Number;

/// One control step: measure, control, act.
///
/// What learns from the sample comes after it, so that nothing delays the command. A fault of any
/// kind lets the servo go.
///
/// The controller is best the identifier's own, as
/// [`GradientIdentifier::controller`](crate::identifier::GradientIdentifierWith::controller) gives
/// it: then real loop and model loop cannot differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick<'a, N, V> {
    controller: &'a Controller<N, V>,
}

/// What a step remembers until the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TickState<N: Number, F> {
    control: ControlState<N, F>,
    origin: Origin,
}

/// What a step did.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ticked<N> {
    /// The sample, for an identifier.
    pub sample: ControlSample<N>,
    /// The count that was measured.
    pub count: i64,
    /// By how much the origin moved before the sample, counts; whatever else is measured from it
    /// must follow.
    pub moved: Option<N>,
}

/// Why a step was not taken. The servo was let go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TickError<S, A> {
    /// The sensor gave no count.
    Sensor(S),
    /// The controller refused its inputs.
    Step(StepError),
    /// The actuator took no command.
    Actuator(A),
}

impl<N: Number, F: Default> TickState<N, F> {
    /// At rest at a count, which is where positions are measured from.
    #[must_use]
    pub fn at_rest(count: i64) -> Self {
        Self {
            control: ControlState::at_rest(N::ZERO),
            origin: Origin::new(count),
        }
    }
}

impl<'a, N: Number, V: VelocityEstimate<N>> Tick<'a, N, V> {
    /// The step of a controller.
    #[inline]
    #[must_use]
    pub fn new(controller: &'a Controller<N, V>) -> Self {
        Self { controller }
    }

    /// One step towards a reference, counts from the origin that [`TickState::at_rest`] set and
    /// [`Ticked::moved`] tells of.
    ///
    /// # Errors
    /// [`TickError`]; the actuator was released and the state is as before.
    #[inline]
    pub fn step<S: PositionSensor, A: Actuator<N>>(
        &self,
        state: &mut TickState<N, V::State>,
        reference: N,
        sensor: &mut S,
        actuator: &mut A,
    ) -> Result<Ticked<N>, TickError<S::Error, A::Error>> {
        let taken = self.try_step(state, reference, sensor, actuator);
        if taken.is_err() {
            // The fault itself says more than a release that fails as well.
            let _ = actuator.release();
        }
        taken
    }

    #[inline]
    fn try_step<S: PositionSensor, A: Actuator<N>>(
        &self,
        state: &mut TickState<N, V::State>,
        reference: N,
        sensor: &mut S,
        actuator: &mut A,
    ) -> Result<Ticked<N>, TickError<S::Error, A::Error>> {
        let count = sensor.count().map_err(TickError::Sensor)?;
        let mut next = *state;
        let moved = next.origin.follow::<N>(count);
        let mut wanted = reference;
        if let Some(moved) = moved {
            next.control.shift_origin(moved);
            wanted = wanted - moved;
        }
        let position = next.origin.position(count);
        let sample = self
            .controller
            .process(&mut next.control, wanted, position)
            .map_err(TickError::Step)?;
        actuator.hold(sample.command).map_err(TickError::Actuator)?;
        *state = next;
        Ok(Ticked {
            sample,
            count,
            moved,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{CommandLimit, Gains, Pid};
    use crate::measurement::velocity::BackwardDifference;
    use crate::units::Units;

    struct Sensor(Result<i64, &'static str>);

    impl PositionSensor for Sensor {
        type Error = &'static str;
        fn count(&mut self) -> Result<i64, &'static str> {
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

    fn controller() -> Controller<f32, BackwardDifference> {
        let units = Units::new(1e-3, 1.0).expect("valid");
        let gains = Gains::new(2.0, 0.0, 0.0).expect("valid");
        let limit = CommandLimit::symmetric(100.0).expect("valid");
        Controller {
            pid: Pid::new(&units, &gains, &limit),
            velocity: BackwardDifference,
        }
    }

    #[test]
    fn a_step_measures_controls_and_acts() {
        let controller = controller();
        let tick = Tick::new(&controller);
        let mut state = TickState::at_rest(1_000_000_000_000);
        let mut motor = Motor::default();
        let mut sensor = Sensor(Ok(1_000_000_000_003));
        let ticked = tick
            .step(&mut state, 8.0, &mut sensor, &mut motor)
            .expect("no fault");
        assert_eq!(motor.held, Some(10.0));
        assert_eq!(ticked.count, 1_000_000_000_003);
        assert_eq!(ticked.moved, None);
    }

    #[test]
    fn far_away_the_origin_moves_and_the_error_stays() {
        let controller = controller();
        let tick = Tick::new(&controller);
        let mut state = TickState::at_rest(0);
        let mut motor = Motor::default();
        let far = 70_000;
        let ticked = tick
            .step(&mut state, 70_004.5, &mut Sensor(Ok(far)), &mut motor)
            .expect("no fault");
        assert_eq!(ticked.moved, Some(70_000.0));
        assert_eq!(motor.held, Some(9.0));
    }

    #[test]
    fn every_fault_lets_the_servo_go_and_leaves_the_state() {
        let controller = controller();
        let tick = Tick::new(&controller);
        let mut state = TickState::at_rest(0);
        let before = state;
        let mut motor = Motor::default();
        let lost = tick.step(&mut state, 0.0, &mut Sensor(Err("lost")), &mut motor);
        assert_eq!(lost, Err(TickError::Sensor("lost")));
        let mad = tick.step(&mut state, f32::NAN, &mut Sensor(Ok(0)), &mut motor);
        assert_eq!(mad, Err(TickError::Step(StepError::ReferenceNotFinite)));
        motor.broken = true;
        let broken = tick.step(&mut state, 1.0, &mut Sensor(Ok(0)), &mut motor);
        assert_eq!(broken, Err(TickError::Actuator("broken")));
        assert_eq!((motor.held, motor.released), (None, 3));
        assert!(state == before);
    }
}
