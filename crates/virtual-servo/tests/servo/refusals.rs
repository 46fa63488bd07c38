//! Effects that no servo can have.

use virtual_servo::{Effects, Servo};

use crate::{RUBBING, SAMPLE_TIME, with};

#[test]
fn each_is_refused_by_its_name() {
    const NONE: Effects = Effects::NONE;
    #[rustfmt::skip]
    let refused = [
        ("delay", Effects { delay: -1e-3, ..NONE }),
        ("delay", Effects { delay: 0.0641, ..NONE }),
        ("current_loop", Effects { current_loop: 1.1, ..NONE }),
        ("current_loop", Effects { current_loop: 9e-7, ..NONE }),
        ("asymmetry", Effects { asymmetry: -2.1, ..NONE }),
        ("low_speed_friction", Effects { low_speed_friction: -10.1, low_speed_velocity: 0.1, ..NONE }),
        ("low_speed_friction", Effects { low_speed_friction: 3.0, ..NONE }),
        ("low_speed_velocity", Effects { low_speed_velocity: 0.1, ..NONE }),
        ("low_speed_velocity", Effects { low_speed_friction: 3.0, low_speed_velocity: 2.9e-6, ..NONE }),
        ("gravity", Effects { gravity: [0.0, f64::NAN], ..NONE }),
        ("ripple", Effects { ripple: [1.0, 0.0], ..NONE }),
        ("ripple", Effects { ripple: [2e6, 0.0], ripple_order: 7, ..NONE }),
        ("ripple_order", Effects { ripple_order: 7, ..NONE }),
        ("ripple_order", Effects { ripple: [1.0, 0.0], ripple_order: 10_001, ..NONE }),
        ("quadratic_friction", Effects { quadratic_friction: -0.1, ..NONE }),
        ("load_dependent_friction", Effects { load_dependent_friction: 0.91, ..NONE }),
        ("torque_ripple", Effects { torque_ripple: [0.1, 0.0], ..NONE }),
        ("torque_ripple", Effects { torque_ripple: [0.7, 0.7], torque_ripple_order: 6, ..NONE }),
        ("torque_ripple_order", Effects { torque_ripple_order: 6, ..NONE }),
        ("inertia_variation", Effects { inertia_variation: [0.0, 0.95], inertia_order: 1, ..NONE }),
        ("inertia_order", Effects { inertia_order: 1, ..NONE }),
        ("gain_asymmetry", Effects { gain_asymmetry: -0.95, ..NONE }),
        ("dead_band", Effects { dead_band: -0.1, ..NONE }),
        ("resonance", Effects { resonance: 500.0, ..NONE }),
        ("resonance", Effects { resonance: 2e5, inertia_ratio: 0.5, ..NONE }),
        ("inertia_ratio", Effects { inertia_ratio: 0.5, ..NONE }),
        ("inertia_ratio", Effects { resonance: 500.0, inertia_ratio: 1.0, ..NONE }),
        ("inertia_ratio", Effects { resonance: 500.0, inertia_ratio: 1e-4, ..NONE }),
        ("resonance_damping", Effects { resonance_damping: Some(0.1), ..NONE }),
        ("resonance_damping", Effects { resonance: 500.0, inertia_ratio: 0.5, resonance_damping: Some(1.1), ..NONE }),
        ("backlash", Effects { backlash: f64::INFINITY, ..NONE }),
        ("gain_drift", Effects { gain_drift: 0.2, ..NONE }),
        ("friction_drift", Effects { friction_drift: -0.2, ..NONE }),
        ("hidden_limit", Effects { hidden_limit: -1.0, ..NONE }),
        ("load_wander", Effects { load_wander: [1.0, 0.0], ..NONE }),
        ("load_wander", Effects { load_wander: [-1.0, 1.0], ..NONE }),
    ];
    for (name, effects) in refused {
        let error = Servo::at_rest(&RUBBING, &effects, SAMPLE_TIME, 1).expect_err(name);
        assert_eq!(error.parameter(), name, "{error}");
        assert!(error.to_string().starts_with(name), "{error}");
    }
}

#[test]
fn effects_too_fast_to_integrate_are_refused_and_a_plain_servo_never_is() {
    let mut sticky = RUBBING;
    sticky.a = 1.1e6;
    let gravity = with(|of| of.gravity = [1.0, 0.0]);
    let error = Servo::at_rest(&sticky, &gravity, SAMPLE_TIME, 1).expect_err("too sticky");
    assert_eq!(error.parameter(), "a");
    assert!(Servo::at_rest(&sticky, &Effects::NONE, SAMPLE_TIME, 1).is_ok());
}

#[test]
fn a_delay_may_be_a_tenth_of_a_second_where_that_is_few_samples() {
    for (delay, time, is_allowed) in [(0.1, 0.01, true), (0.1, 1e-3, false), (0.11, 0.01, false)] {
        let effects = with(|of| of.delay = delay);
        let servo = Servo::at_rest(&RUBBING, &effects, time, 1);
        assert_eq!(servo.is_ok(), is_allowed, "{delay} {time}");
    }
}

#[test]
fn on_another_servo_friction_keeps_its_proportions() {
    let effects = with(|of| {
        (
            of.asymmetry,
            of.low_speed_friction,
            of.low_speed_velocity,
            of.delay,
        ) = (-1.0, -5.0, 0.1, 1e-3)
    });
    let mut other = RUBBING;
    (other.a, other.coulomb) = (0.2, 0.5);
    let carried = effects.carried_over(&RUBBING, &other);
    assert!((carried.asymmetry + 0.1).abs() < 1e-15);
    assert!((carried.low_speed_friction + 0.25).abs() < 1e-15);
    assert!(carried.check(&other, SAMPLE_TIME).is_ok());
    assert!(carried.delay.to_bits() == effects.delay.to_bits());
    other.coulomb = 0.0;
    let carried = effects.carried_over(&RUBBING, &other);
    assert!(carried.low_speed_friction == 0.0);
    assert!(carried.check(&other, SAMPLE_TIME).is_ok());
    let stribeck = Effects {
        low_speed_friction: 5.0,
        ..effects
    };
    let carried = stribeck.carried_over(&other, &RUBBING);
    assert!(carried.low_speed_friction.to_bits() == f64::to_bits(5.0));
}
