//! Changes with time: drift, and a load that wanders.

use identifier_core::parameters::ServoParameters;
use virtual_servo::{Plant, Servo};

use crate::{FREE, RUBBING, SAMPLE_TIME, assert_close, servo, with};

#[test]
fn gain_and_friction_change_by_their_share_of_a_second() {
    let effects = with(|of| (of.gain_drift, of.friction_drift) = (-0.05, 0.08));
    let mut drifting = servo(&RUBBING, &effects);
    let mut plant = Plant::at_rest(&RUBBING, SAMPLE_TIME);
    for sample in 0..4000 {
        let time = f64::from(sample) * SAMPLE_TIME;
        let now = ServoParameters {
            a: RUBBING.a * (1.0 + 0.08 * time),
            b: RUBBING.b * (1.0 - 0.05 * time),
            coulomb: RUBBING.coulomb * (1.0 + 0.08 * time),
            load: RUBBING.load,
        };
        let (position, velocity) = (plant.position, plant.velocity);
        plant = Plant::at_rest(&now, SAMPLE_TIME);
        (plant.position, plant.velocity) = (position, velocity);
        plant.advance(0.4);
        drifting.advance(0.4);
        assert_close(drifting.position(), plant.position, 1e-9, "position");
    }
}

#[test]
fn a_wandering_load_is_that_of_its_seed() {
    let effects = with(|of| of.load_wander = [4.0, 0.5]);
    let of_seed = |seed| {
        let mut servo = Servo::at_rest(&FREE, &effects, SAMPLE_TIME, seed).expect("allowed");
        for _ in 0..1000 {
            servo.advance(0.0);
        }
        servo.position()
    };
    assert_eq!(of_seed(3).to_bits(), of_seed(3).to_bits());
    assert!((of_seed(3) - of_seed(4)).abs() > 1e-3);
    assert!(of_seed(3).abs() < 8.0, "a second of some 4 rad/s²");
}
