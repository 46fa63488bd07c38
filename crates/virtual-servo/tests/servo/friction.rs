//! Friction beyond a and c: asymmetry, low speed, the square of the speed, load.

use std::iter::repeat_n;

use identifier_core::parameters::ServoParameters;
use virtual_servo::Servo;

use crate::{DRY, FREE, RUBBING, SAMPLE_TIME, assert_close, assert_moves_as, servo, with};

#[test]
fn asymmetry_is_another_viscous_friction_in_each_direction() {
    let effects = with(|of| of.asymmetry = 0.7);
    for (command, a) in [(0.4, 2.7), (-0.4, 1.3)] {
        let mut servo = servo(&RUBBING, &effects);
        let plant = ServoParameters { a, ..RUBBING };
        assert_moves_as(&mut servo, &plant, 1e-10, repeat_n([command; 2], 1000));
    }
}

/// The first acceleration, of those that grow by 0.01 rad/s² each tenth of a second, that moves a servo.
fn breaks_away_at(servo: &mut Servo, gain: f64) -> f64 {
    for hundredths in 0..10_000 {
        let push = f64::from(hundredths) / 100.0;
        for _ in 0..100 {
            servo.advance(push / gain);
        }
        if servo.velocity() != 0.0 {
            return push;
        }
    }
    panic!("nothing moves it");
}

#[test]
fn it_breaks_away_at_the_whole_friction_of_rest() {
    for low_speed_friction in [6.5, 0.0, -4.0] {
        let effects = with(|of| {
            of.low_speed_friction = low_speed_friction;
            of.low_speed_velocity = if low_speed_friction == 0.0 { 0.0 } else { 0.2 };
        });
        let mut servo = servo(&DRY, &effects);
        let push = breaks_away_at(&mut servo, DRY.b);
        let level = 10.0 + low_speed_friction;
        let beyond = push - level;
        assert!((0.0..0.02).contains(&beyond), "{push} rad/s² for {level}");
    }
}

#[test]
fn at_speed_only_coulomb_friction_is_left_and_below_it_the_curve_of_stribeck() {
    // dv/dt = w − c − s e^(−(v/v_s)²): the time from rest to v is the integral of 1/that.
    let (excess, knee) = (6.0, 0.3);
    let effects = with(|of| (of.low_speed_friction, of.low_speed_velocity) = (excess, knee));
    let mut servo = servo(&DRY, &effects);
    for sample in 1..=200 {
        servo.advance(0.2);
        let slices = 2000;
        let width = servo.velocity() / f64::from(slices);
        let slice = |slice| {
            let velocity = (f64::from(slice) + 0.5) * width;
            width / (20.0 - 10.0 - excess * (-(velocity / knee).powi(2)).exp())
        };
        let time: f64 = (0..slices).map(slice).sum();
        assert_close(time, f64::from(sample) * SAMPLE_TIME, 1e-6, "time");
    }
}

#[test]
fn friction_that_grows_with_speed_from_almost_nothing_lets_it_creep() {
    // Driven by 8 of 10 rad/s², it creeps where friction is 8: v = v_s √(ln(4/2)).
    for knee in [1e-2, 1e-5] {
        let effects = with(|of| (of.low_speed_friction, of.low_speed_velocity) = (-4.0, knee));
        let mut servo = servo(&DRY, &effects);
        for _ in 0..200 {
            servo.advance(0.08);
        }
        let creep = knee * core::f64::consts::LN_2.sqrt();
        let off = servo.velocity() / creep - 1.0;
        assert!(off.abs() < 1e-6, "{knee}: {servo:?}");
    }
}

#[test]
fn drag_slows_a_coasting_servo_by_the_square_of_its_speed() {
    // dv/dt = −κ |v| v: 1/|v| grows by κ t, in either direction.
    let effects = with(|of| of.quadratic_friction = 0.8);
    for push in [0.5, -0.5] {
        let mut servo = servo(&FREE, &effects);
        for _ in 0..300 {
            servo.advance(push);
        }
        let at_first = servo.velocity();
        assert!(at_first * push > 2.0, "it moves: {at_first}");
        for sample in 1..=1000 {
            servo.advance(0.0);
            let time = f64::from(sample) * SAMPLE_TIME;
            let expected = at_first / (1.0 + 0.8 * at_first.abs() * time);
            assert_close(servo.velocity(), expected, 1e-9, "velocity");
        }
    }
}

#[test]
fn a_loaded_gear_rubs_by_a_share_of_the_push() {
    // Driven by p against c + λ p it moves as a plant of c + λ p, and breaks away at c/(1 − λ).
    let effects = with(|of| of.load_dependent_friction = 0.2);
    for command in [0.4, -0.4] {
        let mut loaded = servo(&DRY, &effects);
        let plant = ServoParameters::new(DRY.a, DRY.b, 10.0 + 0.2 * 40.0, 0.0);
        assert_moves_as(&mut loaded, &plant, 1e-10, repeat_n([command; 2], 500));
    }
    let push = breaks_away_at(&mut servo(&DRY, &effects), DRY.b);
    assert!((12.5..12.52).contains(&push), "{push} rad/s²");
}

#[test]
fn energy_falls_with_friction_wherever_gravity_pulls() {
    let rubbing = ServoParameters::new(0.1, 100.0, 1.5, 0.0);
    let effects = with(|of| {
        (
            of.gravity,
            of.low_speed_friction,
            of.low_speed_velocity,
            of.asymmetry,
        ) = ([-30.0, 4.0], 1.0, 0.3, 0.05)
    });
    let mut servo = servo(&rubbing, &effects);
    for _ in 0..150 {
        servo.advance(0.5);
    }
    let energy = |servo: &Servo| {
        let (sin, cos) = servo.position().sin_cos();
        servo.velocity().powi(2) / 2.0 - 30.0 * cos - 4.0 * sin
    };
    let mut before = energy(&servo);
    let at_first = before;
    for _ in 0..8000 {
        servo.advance(0.0);
        let now = energy(&servo);
        assert!(now <= before + 1e-9, "{now} after {before}");
        before = now;
    }
    assert!(before < at_first - 10.0);
    assert!(servo.velocity() == 0.0, "friction holds it in the end");
    let (sin, cos) = servo.position().sin_cos();
    assert!((-30.0 * sin + 4.0 * cos).abs() <= 2.5, "where it can");
}
