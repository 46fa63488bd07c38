use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;

use identifier_core::drive::Actuator;
use identifier_core::error::{Allowed, OutOfRange};

/// Failures of a bridge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BridgeError<P, D> {
    /// The PWM did not take its duty.
    Pwm(P),
    /// The direction pin did not take its level.
    Direction(D),
}

/// A command as a fraction of its full scale, within ±1; zero for what is no number.
#[inline]
fn fraction(command: f32, per_unit: f32) -> f32 {
    let fraction = command * per_unit;
    if fraction.abs() < 1.0 {
        fraction
    } else {
        limited(fraction)
    }
}

/// A fraction that is not within ±1.
#[cold]
fn limited(fraction: f32) -> f32 {
    if fraction.is_nan() {
        0.0
    } else {
        fraction.signum()
    }
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
        let full_scale = f64::from(full_scale);
        Allowed::Above(0.0).check("full_scale", full_scale)?;
        Ok(Self {
            pwm,
            direction,
            // A configuration value: divided once.
            per_unit: (1.0 / full_scale) as f32,
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

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use embedded_hal_mock::eh1::digital::{Mock as Pin, State, Transaction as Level};
    use embedded_hal_mock::eh1::pwm::{Mock as Pwm, Transaction as Duty};
    use proptest::prelude::*;

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
    fn a_full_scale_of_nothing_is_refused() {
        let list = RefCell::default();
        let bridge = PwmDirection::new(Listed(&list), Listed(&list), 0.0);
        let error = bridge.map(drop).expect_err("no scale");
        assert_eq!(error.parameter, "full_scale");
    }

    proptest! {
        #[test]
        fn a_fraction_is_one(command in any::<f32>()) {
            let fraction = fraction(command, 0.1);
            prop_assert!((-1.0..=1.0).contains(&fraction));
        }
    }
}
