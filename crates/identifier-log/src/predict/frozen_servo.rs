use identifier_core::error::OutOfRange;
use identifier_core::parameters::{ServoParameters, Unknown};
use identifier_core::replay::{ReplayModel, ReplayState};
use identifier_core::settings::TermSettings;
use identifier_core::units::Units;
use log_fit::fit::Effect;

use crate::found_servo::FoundServo;
use crate::scaled_recording::{servo_of, term};
use crate::scenario::Options;

/// A servo with constant parameters. It is the model of the identifiers with every term and without any correction.
///
/// Every term of the core's own step is here too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrozenServo {
    units: Units,
    servo: ServoParameters,
    model: ReplayModel,
}

/// Where a servo is, how fast, and which commands are still on their way to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Position, rad.
    pub position: f64,
    /// Velocity, rad a sample.
    pub velocity: f64,
    /// Motion in the last sample, rad.
    pub moved: f64,
    replay: ReplayState,
}

impl FrozenServo {
    /// A servo with these parameters and no other terms, in samples of `sample_time`, s. A friction
    /// below zero is none.
    ///
    /// # Errors
    /// A sample time that is not allowed.
    pub fn new(servo: &ServoParameters, sample_time: f64) -> Result<Self, OutOfRange> {
        let units = Units::new(sample_time, 1.0)?;
        let servo = ServoParameters {
            coulomb: servo.coulomb.max(0.0),
            ..*servo
        };
        Ok(Self {
            units,
            servo,
            model: ReplayModel::new(&units, &servo, &TermSettings::NONE, []),
        })
    }

    /// The same servo with what is declared of its terms, and the sizes that were found, SI.
    #[must_use]
    pub fn with_terms(
        self,
        declared: &TermSettings,
        found: impl IntoIterator<Item = (Unknown, f64)>,
    ) -> Self {
        Self {
            model: ReplayModel::new(&self.units, &self.servo, declared, found),
            ..self
        }
    }

    /// A servo that was found, with the effects that are terms of the core's model.
    ///
    /// # Errors
    /// A sample time that is not allowed.
    pub(super) fn of(found: &FoundServo, scenario: &Options) -> Result<Self, OutOfRange> {
        let values = found.values();
        let servo = servo_of(|effect| values.get(effect));
        let declared = TermSettings {
            dead_band: values.get(Effect::DeadBand),
            current_loop: values.get(Effect::CurrentLoop),
            low_speed_velocity: Some(values.get(Effect::LowSpeedVelocity)).filter(|of| *of > 0.0),
            ripple_order: Some(values.orders[1]),
            ..scenario.stated.identifier.terms
        };
        let terms = Effect::ALL.into_iter().filter_map(|effect| {
            let unknown = term(effect).filter(|unknown| unknown.parameter().is_none())?;
            (unknown != Unknown::DeadBand).then(|| (unknown, values.get(effect)))
        });
        Ok(Self::new(&servo, scenario.sample_time())?.with_terms(&declared, terms))
    }

    /// At a position (rad) with a velocity (rad a sample); the command that acts has acted for long.
    #[must_use]
    pub fn start(&self, position: f64, velocity: f64, command: f64) -> State {
        let mut state = State {
            position,
            velocity,
            moved: 0.0,
            replay: self.model.start(position, velocity),
        };
        for _ in 0..=ReplayModel::MAX_DELAY as u32 {
            self.record(&mut state, 0.0, command);
        }
        state
    }

    fn record(&self, state: &mut State, moved: f64, command: f64) {
        let command = self.model.amplify(&mut state.replay, command);
        state.replay.velocity = state.velocity;
        self.model.record(&mut state.replay, moved, command);
    }

    /// One sample of a servo that is where it was measured, rad, with a velocity, rad a sample.
    pub fn follow(&self, state: &mut State, position: f64, velocity: f64, command: f64) {
        let moved = position - state.position;
        self.record(state, moved, command);
        (state.position, state.velocity, state.moved) = (position, velocity, moved);
    }

    /// One sample under a held command.
    pub fn advance(&self, state: &mut State, command: f64) {
        let command = self.model.amplify(&mut state.replay, command);
        // The model is where the servo is.
        (state.replay.error, state.replay.velocity) = (-state.moved, state.velocity);
        self.model.process(&mut state.replay, state.moved, command);
        // The displacement from where it stood.
        state.moved = -state.replay.error;
        state.position += state.moved;
        state.velocity = state.replay.velocity;
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use virtual_servo::{Effects, Servo};

    const SERVO: ServoParameters = ServoParameters::new(0.2174, 257.7, 10.0, 20.0);

    /// How far it is from the servo of the simulator, which was written apart from the core's model.
    fn apart(frozen: &FrozenServo, effects: &Effects, samples: u32) -> f64 {
        let mut state = frozen.start(0.0, 0.0, 0.0);
        let mut servo = Servo::at_rest(&SERVO, effects, 1e-3, 1).expect("valid");
        let mut most: f64 = 0.0;
        for k in 0..samples {
            let command = 0.3 * libm::sin(7e-3 * f64::from(k)) - 0.08;
            frozen.advance(&mut state, command);
            servo.advance(command);
            most = most.max((state.position - servo.position()).abs());
        }
        assert!(servo.position().abs() > 0.1, "{}", servo.position());
        most
    }

    #[test]
    fn it_moves_as_the_simulated_servo_does() {
        let frozen = FrozenServo::new(&SERVO, 1e-3).expect("valid");
        let most = apart(&frozen, &Effects::NONE, 20_000);
        assert!(most < 1e-6, "{most}");
        // A delay is declared or found, and what is found counts.
        let declared = TermSettings {
            delay: 3e-3,
            ..TermSettings::NONE
        };
        for (found, delay) in [(None, 3e-3), (Some((Unknown::Delay, 5e-3)), 5e-3)] {
            let late = Effects {
                delay,
                ..Effects::NONE
            };
            let most = apart(&frozen.with_terms(&declared, found), &late, 5000);
            assert!(most < 1e-6, "{most}");
        }
    }

    /// A command within the dead band gives no current; a lagging current within it would not act.
    #[test]
    fn a_declared_dead_band_comes_before_the_current_loop() {
        let mut declared = TermSettings::NONE;
        (declared.dead_band, declared.current_loop) = (0.1, 5e-3);
        let mut effects = Effects::NONE;
        (effects.dead_band, effects.current_loop) = (0.1, 5e-3);
        let frozen = FrozenServo::new(&SERVO, 1e-3).expect("valid");
        let most = apart(&frozen.with_terms(&declared, []), &effects, 5000);
        assert!(most < 1e-3, "{most}");
    }

    #[test]
    fn gravity_is_of_the_angle_where_the_servo_is() {
        let mass = FrozenServo::new(&ServoParameters::new(0.0, 1.0, 0.0, 0.0), 1e-3);
        let gravity = [(Unknown::GravitySine, -25.0)];
        let hanging = (mass.expect("valid")).with_terms(&TermSettings::NONE, gravity);
        // A pendulum: 5 rad/s for small oscillations about any whole turn.
        let mut state = hanging.start(3.0 * TAU + 0.01, 0.0, 0.0);
        for (periods, place) in [(1.0, 0.01), (0.5, -0.01)] {
            for _ in 0..(periods * TAU / 5.0 / 1e-3) as u32 {
                hanging.advance(&mut state, 0.0);
            }
            let off = state.position - 3.0 * TAU - place;
            assert!(off.abs() < 1e-4, "{state:?}");
        }
    }
}
