//! A servo with whatever effects it has.

use identifier_core::parameters::ServoParameters;

use crate::front_end::{FrontEnd, Held};
use crate::motion::Motion;
use crate::{EffectError, Effects, Plant};

/// A servo, moved from sample to sample. Without effects it is a [`Plant`], bit for bit.
#[derive(Debug, Clone)]
pub struct Servo {
    front_end: Option<FrontEnd>,
    mechanics: Mechanics,
    backlash: Option<Backlash>,
    sample_time: f64,
    /// Its load and Coulomb friction when nothing disturbs it, rad/s².
    undisturbed: [f64; 2],
}

/// The computation of its motion.
#[derive(Debug, Clone)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap here, and servos are few"
)]
enum Mechanics {
    ClosedForm(Plant),
    Integrated(Motion),
}

impl Servo {
    /// At rest at position zero, to be moved in steps of `sample_time` (s). Random effects follow
    /// from the seed.
    ///
    /// # Errors
    /// As [`Effects::check`].
    pub fn at_rest(
        parameters: &ServoParameters,
        effects: &Effects,
        sample_time: f64,
        seed: u32,
    ) -> Result<Self, EffectError> {
        effects.check(parameters, sample_time)?;
        let mechanics = if effects.change_the_motion() {
            Mechanics::Integrated(Motion::at_rest(parameters, effects, sample_time, seed))
        } else {
            Mechanics::ClosedForm(Plant::at_rest(parameters, sample_time))
        };
        let front_end = effects.change_the_command();
        Ok(Self {
            front_end: front_end.then(|| FrontEnd::new(effects, sample_time)),
            mechanics,
            backlash: (effects.backlash > 0.0 && !effects.are_two_masses())
                .then(|| Backlash::new(effects.backlash)),
            sample_time,
            undisturbed: [parameters.load, parameters.coulomb],
        })
    }

    /// The same after this command was held for long. It also acts in the first samples, for the delay of commands.
    #[must_use]
    pub fn held_by(mut self, command: f64) -> Self {
        let mut acting = command;
        if let Some(front_end) = &mut self.front_end {
            front_end.hold(command);
            acting = front_end.last();
        }
        if let Mechanics::Integrated(motion) = &mut self.mechanics {
            motion.hold(acting);
        }
        self
    }

    /// Adds a load and Coulomb friction to its own from the next sample on, rad/s².
    pub fn disturb(&mut self, load: f64, coulomb: f64) {
        let [own_load, own_coulomb] = self.undisturbed;
        let (load, coulomb) = (own_load + load, own_coulomb + coulomb);
        match &mut self.mechanics {
            Mechanics::ClosedForm(plant) => plant.disturb(load, coulomb),
            Mechanics::Integrated(motion) => motion.disturb(load, coulomb),
        }
    }

    /// Moves one sample, at whose beginning this command is given.
    #[inline]
    pub fn advance(&mut self, command: f64) {
        if let Mechanics::Integrated(motion) = &mut self.mechanics {
            motion.begin_sample();
        }
        let Some(front_end) = &mut self.front_end else {
            self.move_under(&Held {
                command,
                time: self.sample_time,
            });
            return;
        };
        let parts = front_end.process(command);
        for held in parts.iter().filter(|held| held.time > 0.0) {
            self.move_under(held);
        }
    }

    /// Stands for one sample, at whose beginning this command is given: a closed brake holds the motor.
    pub fn stand(&mut self, command: f64) {
        if let Some(front_end) = &mut self.front_end {
            front_end.process(command);
        }
        match &mut self.mechanics {
            Mechanics::ClosedForm(plant) => plant.velocity = 0.0,
            Mechanics::Integrated(motion) => motion.stand(),
        }
    }

    /// Moves for the time of a held command.
    fn move_under(&mut self, held: &Held) {
        match &mut self.mechanics {
            Mechanics::ClosedForm(plant) => plant.advance_for(held.time, held.command),
            Mechanics::Integrated(motion) => motion.advance(held),
        }
        if let Some(backlash) = &mut self.backlash {
            backlash.follow(motor(&self.mechanics)[0]);
        }
    }

    /// Position at the encoder, rad.
    #[inline]
    #[must_use]
    pub fn position(&self) -> f64 {
        match &self.backlash {
            Some(backlash) => backlash.position(),
            None => motor(&self.mechanics)[0],
        }
    }

    /// Velocity at the encoder, rad/s.
    #[inline]
    #[must_use]
    pub fn velocity(&self) -> f64 {
        let [_, velocity] = motor(&self.mechanics);
        match &self.backlash {
            Some(backlash) => backlash.velocity(velocity),
            None => velocity,
        }
    }
}

/// Position and velocity of the motor.
fn motor(mechanics: &Mechanics) -> [f64; 2] {
    match mechanics {
        Mechanics::ClosedForm(plant) => [plant.position, plant.velocity],
        Mechanics::Integrated(motion) => [motion.position(), motion.velocity()],
    }
}

/// The load is at standstill while the motor is within the backlash. The end of the backlash at the motor takes it
/// along (in mathematics the play operator of hysteresis).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Backlash {
    half: f64,
    position: f64,
    taken_along: bool,
}

impl Backlash {
    /// So much from end to end, rad, the motor in the middle.
    pub(crate) fn new(width: f64) -> Self {
        Self {
            half: 0.5 * width,
            position: 0.0,
            taken_along: false,
        }
    }

    /// Follows the motor to a position, rad.
    pub(crate) fn follow(&mut self, motor: f64) {
        let (low, high) = (motor - self.half, motor + self.half);
        self.taken_along = self.position < low || self.position > high;
        self.position = self.position.clamp(low, high);
    }

    /// Position of the load, rad.
    pub(crate) fn position(&self) -> f64 {
        self.position
    }

    /// The load's velocity when this is the motor's.
    pub(crate) fn velocity(&self, motor: f64) -> f64 {
        if self.taken_along { motor } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_servo_that_is_held_stays_however_late_its_commands_are() {
        const TIME: f64 = 1e-3;
        let servo = ServoParameters::new(0.5, 200.0, 0.0, 50.0);
        let cases = [[0.0; 3], [2.4e-3, 0.0, 0.0], [1e-3, 5e-4, 0.03]];
        for [delay, current_loop, dead_band] in cases {
            let effects = Effects {
                delay,
                current_loop,
                dead_band,
                ..Effects::NONE
            };
            let command = -50.0 / 200.0 - effects.dead_band;
            let at_rest = Servo::at_rest(&servo, &effects, TIME, 1).expect("allowed");
            let mut held = at_rest.clone().held_by(command);
            let mut released = at_rest;
            for _ in 0..20 {
                held.advance(command);
                released.advance(command);
            }
            assert!(held.position().abs() < 1e-12, "{effects:?}");
            let is_late = effects.delay > 0.0;
            assert_eq!(released.position() > 1e-5, is_late, "{effects:?}");
        }
    }
}
