//! Servos with one effect at a time, against closed forms.

mod angle;
mod command;
mod drift;
mod faults;
mod friction;
mod refusals;
mod sensor;
mod two_masses;

use identifier_core::parameters::ServoParameters;
use virtual_servo::{Effects, Servo};

/// S.
const SAMPLE_TIME: f64 = 1e-3;

/// Without friction and load.
const FREE: ServoParameters = ServoParameters::new(0.0, 100.0, 0.0, 0.0);

/// With friction alone.
const DRY: ServoParameters = ServoParameters::new(0.0, 100.0, 10.0, 0.0);

/// With every parameter of the closed form.
const RUBBING: ServoParameters = ServoParameters::new(2.0, 100.0, 10.0, -5.0);

/// No effects but what is changed.
fn with(change: impl FnOnce(&mut Effects)) -> Effects {
    let mut effects = Effects::NONE;
    change(&mut effects);
    effects
}

fn servo(parameters: &ServoParameters, effects: &Effects) -> Servo {
    Servo::at_rest(parameters, effects, SAMPLE_TIME, 1).expect("these effects are allowed")
}

/// A command that moves a servo to and fro, now and then too weakly to move it.
fn to_and_fro(sample: u32) -> f64 {
    let time = f64::from(sample) * SAMPLE_TIME;
    (4.0 * time).sin() * (0.4 * (17.0 * time).sin() + 0.2 * (61.0 * time).cos())
}

fn assert_close(found: f64, expected: f64, precision: f64, about: &str) {
    let part = (found - expected).abs() / (1.0 + expected.abs());
    assert!(part <= precision, "{about}: {found} for {expected}");
}

/// A servo under commands moves as a plant under other ones.
fn assert_moves_as(
    servo: &mut Servo,
    plant: &ServoParameters,
    precision: f64,
    commands: impl Iterator<Item = [f64; 2]>,
) {
    let mut plant = virtual_servo::Plant::at_rest(plant, SAMPLE_TIME);
    for [command, acting] in commands {
        servo.advance(command);
        plant.advance(acting);
        assert_close(servo.position(), plant.position, precision, "position");
    }
}

#[test]
fn without_effects_it_is_the_plant_bit_for_bit() {
    let mut plant = virtual_servo::Plant::at_rest(&RUBBING, SAMPLE_TIME);
    let mut servo = servo(&RUBBING, &Effects::default());
    for sample in 0..2000 {
        let command = to_and_fro(sample);
        plant.advance(command);
        servo.advance(command);
        assert_eq!(servo.position().to_bits(), plant.position.to_bits());
        assert_eq!(servo.velocity().to_bits(), plant.velocity.to_bits());
    }
}

#[test]
fn the_integrator_agrees_with_the_plant_through_stops_and_reversals() {
    let mut plant = virtual_servo::Plant::at_rest(&RUBBING, SAMPLE_TIME);
    // It changes nothing but that the motion is integrated in steps: in no run of a second is the drift as large as the
    // rounding of 1.
    let mut servo = servo(&RUBBING, &with(|of| of.gain_drift = 1e-17));
    let (mut turns, mut stops, mut before) = (0, 0, 0.0_f64);
    for sample in 0..2000 {
        let command = to_and_fro(sample);
        plant.advance(command);
        servo.advance(command);
        assert_close(servo.position(), plant.position, 1e-10, "position");
        assert_close(servo.velocity(), plant.velocity, 1e-9, "velocity");
        turns += u32::from(before * plant.velocity < 0.0);
        stops += u32::from(before != 0.0 && plant.velocity == 0.0);
        before = plant.velocity;
    }
    assert!(turns > 3 && stops > 1, "{turns} turns, {stops} stops");
}
