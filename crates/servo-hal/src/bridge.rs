use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;

use crate::{fraction, reciprocal};
use identifier_core::drive::Actuator;
use identifier_core::error::OutOfRange;

/// Failures of a bridge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BridgeError<P, D> {
    /// A PWM did not take its duty.
    Pwm(P),
    /// The direction pin, or the second PWM, did not take its level.
    Direction(D),
}

/// The duty of a magnitude from 0 to 1, to the nearest step.
#[inline]
fn duty(magnitude: f32, most: u16) -> u16 {
    // A cast to 32 bits saturates in one instruction, and what is at most `most` needs no other.
    (magnitude * f32::from(most) + 0.5) as u32 as u16
}

/// A bridge with a PWM for how much and a pin for which way, high for positive.
#[derive(Debug)]
pub struct PwmDirection<P, D> {
    pwm: P,
    direction: D,
    per_unit: f32,
}

impl<P: SetDutyCycle, D: OutputPin> PwmDirection<P, D> {
    /// `full_scale` is the command that asks for the whole duty, command units.
    ///
    /// # Errors
    /// `full_scale` must be above zero.
    pub fn new(pwm: P, direction: D, full_scale: f32) -> Result<Self, OutOfRange> {
        Ok(Self {
            pwm,
            direction,
            per_unit: reciprocal(full_scale)?,
        })
    }
}

impl<P: SetDutyCycle, D: OutputPin> Actuator<f32> for PwmDirection<P, D> {
    type Error = BridgeError<P::Error, D::Error>;

    #[inline]
    fn hold(&mut self, command: f32) -> Result<(), Self::Error> {
        let fraction = fraction(command, self.per_unit);
        // The direction first: so the old duty acts in the new direction for less time than the new duty would in the
        // old one. A pin that changes with the period waits for its duty.
        self.direction
            .set_state((fraction >= 0.0).into())
            .map_err(BridgeError::Direction)?;
        let duty = duty(fraction.abs(), self.pwm.max_duty_cycle());
        self.pwm.set_duty_cycle(duty).map_err(BridgeError::Pwm)
    }

    fn release(&mut self) -> Result<(), Self::Error> {
        self.pwm
            .set_duty_cycle_fully_off()
            .map_err(BridgeError::Pwm)
    }
}

/// A bridge whose two sides one PWM switches against each other: one half is standstill.
#[derive(Debug)]
pub struct LockedAntiphase<P> {
    pwm: P,
    per_unit: f32,
}

impl<P: SetDutyCycle> LockedAntiphase<P> {
    /// `full_scale` is the command that asks for the whole duty, command units.
    ///
    /// # Errors
    /// `full_scale` must be above zero.
    pub fn new(pwm: P, full_scale: f32) -> Result<Self, OutOfRange> {
        Ok(Self {
            pwm,
            per_unit: reciprocal(full_scale)?,
        })
    }
}

impl<P: SetDutyCycle> Actuator<f32> for LockedAntiphase<P> {
    type Error = P::Error;

    #[inline]
    fn hold(&mut self, command: f32) -> Result<(), Self::Error> {
        let half = 0.5 + 0.5 * fraction(command, self.per_unit);
        let duty = duty(half, self.pwm.max_duty_cycle());
        self.pwm.set_duty_cycle(duty)
    }

    /// One half: a bridge of this kind cannot coast without its enable pin.
    fn release(&mut self) -> Result<(), Self::Error> {
        self.hold(0.0)
    }
}

/// Two half bridges, one for each direction.
#[derive(Debug)]
pub struct HalfBridges<P, Q> {
    positive: P,
    negative: Q,
    per_unit: f32,
}

impl<P: SetDutyCycle, Q: SetDutyCycle> HalfBridges<P, Q> {
    /// `full_scale` is the command that asks for the whole duty, command units.
    ///
    /// # Errors
    /// `full_scale` must be above zero.
    pub fn new(positive: P, negative: Q, full_scale: f32) -> Result<Self, OutOfRange> {
        Ok(Self {
            positive,
            negative,
            per_unit: reciprocal(full_scale)?,
        })
    }
}

impl<P: SetDutyCycle, Q: SetDutyCycle> Actuator<f32> for HalfBridges<P, Q> {
    type Error = BridgeError<P::Error, Q::Error>;

    /// The side that is to rest is put to rest first, so that never both are on.
    #[inline]
    fn hold(&mut self, command: f32) -> Result<(), Self::Error> {
        let fraction = fraction(command, self.per_unit);
        if fraction >= 0.0 {
            let duty = duty(fraction, self.positive.max_duty_cycle());
            self.negative
                .set_duty_cycle_fully_off()
                .map_err(BridgeError::Direction)?;
            self.positive.set_duty_cycle(duty).map_err(BridgeError::Pwm)
        } else {
            let duty = duty(-fraction, self.negative.max_duty_cycle());
            self.positive
                .set_duty_cycle_fully_off()
                .map_err(BridgeError::Pwm)?;
            self.negative
                .set_duty_cycle(duty)
                .map_err(BridgeError::Direction)
        }
    }

    /// Both sides off, the second even if the first does not answer.
    fn release(&mut self) -> Result<(), Self::Error> {
        let negative = self.negative.set_duty_cycle_fully_off();
        self.positive
            .set_duty_cycle_fully_off()
            .map_err(BridgeError::Pwm)?;
        negative.map_err(BridgeError::Direction)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use embedded_hal_mock::eh1::digital::{Mock as Pin, State, Transaction as Level};
    use embedded_hal_mock::eh1::pwm::{Mock as Pwm, Transaction as Duty};

    use core::cell::RefCell;
    use core::convert::Infallible;
    use std::vec::Vec;

    fn pwm(duties: &[u16]) -> Pwm {
        let expected: Vec<Duty> = duties
            .iter()
            .flat_map(|&duty| [Duty::max_duty_cycle(1000), Duty::set_duty_cycle(duty)])
            .collect();
        Pwm::new(&expected)
    }

    #[test]
    fn pwm_and_direction_follow_the_command() {
        let mut pwm = pwm(&[250, 500, 1000, 0]);
        let mut pin = Pin::new(&[
            Level::set(State::High),
            Level::set(State::Low),
            Level::set(State::Low),
            Level::set(State::High),
        ]);
        let mut bridge = PwmDirection::new(pwm.clone(), pin.clone(), 10.0).expect("valid");
        for command in [2.5, -5.0, -99.0, f32::NAN] {
            bridge.hold(command).expect("no fault");
        }
        pwm.done();
        pin.done();
    }

    /// A PWM and a direction that write what they are set to into one list.
    struct Listed<'a>(&'a RefCell<Vec<u16>>);

    impl embedded_hal::pwm::ErrorType for Listed<'_> {
        type Error = Infallible;
    }

    impl SetDutyCycle for Listed<'_> {
        fn max_duty_cycle(&self) -> u16 {
            1000
        }

        fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
            self.0.borrow_mut().push(duty);
            Ok(())
        }
    }

    impl embedded_hal::digital::ErrorType for Listed<'_> {
        type Error = Infallible;
    }

    impl OutputPin for Listed<'_> {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.set_duty_cycle(LOW)
        }

        fn set_high(&mut self) -> Result<(), Infallible> {
            self.set_duty_cycle(HIGH)
        }
    }

    const LOW: u16 = u16::MAX - 1;
    const HIGH: u16 = u16::MAX;

    #[test]
    fn the_direction_is_set_before_its_duty() {
        let list = RefCell::default();
        let mut bridge = PwmDirection::new(Listed(&list), Listed(&list), 10.0).expect("valid");
        for command in [2.5, -5.0] {
            bridge.hold(command).expect("no fault");
        }
        assert_eq!(*list.borrow(), [HIGH, 250, LOW, 500]);
    }

    #[test]
    fn one_half_is_standstill() {
        let mut pwm = pwm(&[500, 750, 0, 500]);
        let mut bridge = LockedAntiphase::new(pwm.clone(), 10.0).expect("valid");
        for command in [0.0, 5.0, -10.0] {
            bridge.hold(command).expect("no fault");
        }
        bridge.release().expect("no fault");
        pwm.done();
    }

    #[test]
    fn the_other_half_bridge_rests_first_and_release_rests_both() {
        let off = Duty::set_duty_cycle(0);
        let mut positive = Pwm::new(&[
            Duty::max_duty_cycle(1000),
            Duty::set_duty_cycle(300),
            off.clone(),
            off.clone(),
        ]);
        let mut negative = Pwm::new(&[
            off.clone(),
            Duty::max_duty_cycle(1000),
            Duty::set_duty_cycle(700),
            off,
        ]);
        let mut bridges =
            HalfBridges::new(positive.clone(), negative.clone(), 10.0).expect("valid");
        bridges.hold(3.0).expect("no fault");
        bridges.hold(-7.0).expect("no fault");
        bridges.release().expect("no fault");
        positive.done();
        negative.done();
    }

    #[test]
    fn a_full_scale_of_nothing_is_refused() {
        let mut pwm = Pwm::new(&[]);
        let error = LockedAntiphase::new(pwm.clone(), 0.0).expect_err("no scale");
        assert_eq!(error.parameter, "full_scale");
        pwm.done();
    }
}
