use embedded_hal::digital::OutputPin;

use identifier_core::drive::Actuator;

/// An output stage with an enable pin: high while it holds a command, low while disabled. It may have the pin of a holding
/// brake too, high to open it: a disabled stage never leaves the brake open.
#[derive(Debug)]
pub struct Gate<A, E> {
    stage: A,
    enable: E,
    brake: Option<E>,
}

/// Failures of a gated stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum GateError<A, E> {
    /// The stage failed.
    Stage(A),
    /// The pin failed.
    Enable(E),
    /// The pin of the brake failed.
    Brake(E),
}

impl<A, E: OutputPin> Gate<A, E> {
    /// Gates a stage.
    pub fn new(stage: A, enable: E) -> Self {
        Self {
            stage,
            enable,
            brake: None,
        }
    }

    /// The same with the pin of a holding brake.
    #[must_use]
    pub fn with_brake(self, brake: E) -> Self {
        Self {
            brake: Some(brake),
            ..self
        }
    }

    /// Opens or closes the brake, if there is one.
    ///
    /// # Errors
    /// Its pin failed.
    pub fn set_brake(&mut self, open: bool) -> Result<(), E::Error> {
        match &mut self.brake {
            Some(brake) => brake.set_state(open.into()),
            None => Ok(()),
        }
    }
}

impl<A: Actuator<f32>, E: OutputPin> Actuator<f32> for Gate<A, E> {
    type Error = GateError<A::Error, E::Error>;

    /// The command first: an enabled stage would act on the previous one.
    #[inline]
    fn hold(&mut self, command: f32) -> Result<(), Self::Error> {
        self.stage.hold(command).map_err(GateError::Stage)?;
        self.enable.set_high().map_err(GateError::Enable)
    }

    /// The pins first, and the stage even if one fails.
    #[inline]
    fn release(&mut self) -> Result<(), Self::Error> {
        let brake = self.set_brake(false).map_err(GateError::Brake);
        let enable = self.enable.set_low().map_err(GateError::Enable);
        self.stage.release().map_err(GateError::Stage)?;
        enable.and(brake)
    }
}

#[cfg(test)]
mod tests {
    use embedded_hal_mock::eh1::digital::{Mock, State, Transaction};

    use super::*;

    struct Stage(Result<Option<f32>, ()>);

    impl Actuator<f32> for Stage {
        type Error = ();
        fn hold(&mut self, command: f32) -> Result<(), ()> {
            self.0.map(|_| self.0 = Ok(Some(command)))
        }
        fn release(&mut self) -> Result<(), ()> {
            self.0.map(|_| self.0 = Ok(None))
        }
    }

    #[test]
    fn the_pin_is_high_while_a_command_is_held() {
        let pin = Mock::new(&[
            Transaction::set(State::High),
            Transaction::set(State::High),
            Transaction::set(State::Low),
        ]);
        let mut gate = Gate::new(Stage(Ok(None)), pin);
        gate.hold(1.5).expect("held");
        gate.hold(-2.5).expect("held");
        assert_eq!(gate.stage.0, Ok(Some(-2.5)));
        gate.release().expect("released");
        assert_eq!(gate.stage.0, Ok(None));
        gate.enable.done();
    }

    #[test]
    fn the_brake_opens_on_demand_and_closes_with_the_stage() {
        let enable = Mock::new(&[Transaction::set(State::High), Transaction::set(State::Low)]);
        let brake = Mock::new(&[
            Transaction::set(State::High),
            Transaction::set(State::Low),
            Transaction::set(State::Low),
        ]);
        let mut gate = Gate::new(Stage(Ok(None)), enable).with_brake(brake);
        gate.hold(1.5).expect("held");
        gate.set_brake(true).expect("opened");
        gate.set_brake(false).expect("closed");
        gate.release().expect("released");
        gate.enable.done();
        gate.brake.expect("given").done();
    }

    #[test]
    fn a_stage_that_fails_is_not_enabled_and_still_released() {
        let pin = Mock::new(&[Transaction::set(State::Low)]);
        let mut gate = Gate::new(Stage(Err(())), pin);
        assert_eq!(gate.hold(1.0), Err(GateError::Stage(())));
        assert_eq!(gate.release(), Err(GateError::Stage(())));
        gate.enable.done();
    }
}
