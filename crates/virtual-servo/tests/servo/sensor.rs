//! The errors of a sensor.

use virtual_servo::{SensorEffects, SensorErrors};

use crate::{SAMPLE_TIME, assert_close};

const fn effects(noise: f64, eccentricity: f64, jitter: f64) -> SensorEffects {
    SensorEffects {
        noise,
        eccentricity,
        jitter,
    }
}

fn errors(effects: &SensorEffects) -> SensorErrors {
    SensorErrors::new(effects, SAMPLE_TIME, 9).expect("these errors are allowed")
}

/// Standard deviation of the readings of a servo at 0.3 rad with a velocity.
fn spread(effects: &SensorEffects, velocity: f64) -> f64 {
    const SAMPLES: u32 = 100_000;
    let mut errors = errors(effects);
    let (mut sum, mut square) = (0.0, 0.0);
    for _ in 0..SAMPLES {
        let error = errors.seen(0.3, velocity) - 0.3;
        sum += error / f64::from(SAMPLES);
        square += error * error / f64::from(SAMPLES);
    }
    (square - sum * sum).sqrt()
}

#[test]
fn without_errors_the_position_is_seen_bit_for_bit() {
    let mut none = errors(&SensorEffects::default());
    for position in [0.0, -0.0, 1.0 / 3.0, -1e6] {
        assert_eq!(none.seen(position, 17.0).to_bits(), f64::to_bits(position));
    }
}

#[test]
fn noise_is_as_large_as_stated() {
    let deviation = spread(&effects(2e-3, 0.0, 0.0), 0.0);
    assert_close(deviation / 2e-3, 1.0, 0.01, "deviation");
}

#[test]
fn the_first_reading_has_no_error() {
    let mut errors = errors(&effects(2e-3, 1e-3, 0.1));
    assert!(errors.seen(0.3, 9.0).to_bits() == f64::to_bits(0.3));
    assert!(errors.seen(0.3, 9.0).to_bits() != f64::to_bits(0.3));
}

#[test]
fn jitter_is_seen_in_motion_only() {
    let effects = effects(0.0, 0.0, 0.1);
    let part = spread(&effects, -40.0) / (40.0 * 0.1 * SAMPLE_TIME);
    assert_close(part, 1.0, 0.01, "deviation");
    assert!(spread(&effects, 0.0) == 0.0);
}

#[test]
fn an_eccentric_disc_errs_once_per_revolution() {
    let mut errors = errors(&effects(0.0, 1e-3, 0.0));
    assert!(errors.seen(0.0, 3.0) == 0.0);
    for tenths in -100..100 {
        let position = f64::from(tenths) / 10.0;
        let seen = errors.seen(position, 3.0);
        assert_close(seen, position + 1e-3 * position.sin(), 1e-15, "seen");
    }
}

#[test]
fn impossible_sensor_errors_are_refused_by_name() {
    for (name, [noise, eccentricity, jitter]) in [
        ("noise", [-1.0, 0.0, 0.0]),
        ("eccentricity", [0.0, f64::NAN, 0.0]),
        ("jitter", [0.0, 0.0, 0.6]),
    ] {
        let refused = SensorErrors::new(&effects(noise, eccentricity, jitter), SAMPLE_TIME, 9);
        assert_eq!(refused.expect_err("out of range").parameter, name);
    }
}
