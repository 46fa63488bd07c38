//! Effects of the angle: gravity, ripple of cogging and torque, inertia.

use core::f64::consts::TAU;

use virtual_servo::{Effects, Servo};

use crate::{FREE, SAMPLE_TIME, assert_close, servo, with};

/// Pushed for a moment, then left alone; the inertia and the potential are functions of the angle. The result is the least and
/// the largest speed.
fn keeps_its_energy(effects: &Effects, push: f64, of: impl Fn(f64) -> [f64; 2]) -> [f64; 2] {
    let mut servo = servo(&FREE, effects);
    for _ in 0..20 {
        servo.advance(push);
    }
    let energy = |servo: &Servo| {
        let [inertia, potential] = of(servo.position());
        inertia * servo.velocity().powi(2) / 2.0 + potential
    };
    let at_first = energy(&servo);
    let (mut farthest, mut speeds) = (0.0_f64, [f64::INFINITY, 0.0]);
    for _ in 0..10_000 {
        servo.advance(0.0);
        assert_close(energy(&servo), at_first, 1e-7, "energy");
        farthest = farthest.max(servo.position().abs());
        let speed = servo.velocity().abs();
        speeds = [speeds[0].min(speed), speeds[1].max(speed)];
    }
    assert!(farthest > 0.3, "it moves: {farthest}");
    speeds
}

#[test]
fn gravity_keeps_the_energy_of_a_free_pendulum_below_and_over_the_top() {
    let effects = with(|of| of.gravity = [-20.0, 3.0]);
    let potential = |q: f64| [1.0, -20.0 * q.cos() - 3.0 * q.sin()];
    keeps_its_energy(&effects, 1.5, potential);
    keeps_its_energy(&effects, 8.0, potential);
}

#[test]
fn ripple_keeps_the_energy_of_a_free_servo() {
    let effects = with(|of| (of.ripple, of.ripple_order) = ([5.0, -2.0], 24));
    keeps_its_energy(&effects, 2.0, |q| {
        [
            1.0,
            (5.0 * (24.0 * q).cos() + 2.0 * (24.0 * q).sin()) / 24.0,
        ]
    });
}

#[test]
fn torque_ripple_under_a_held_command_keeps_the_energy_of_its_potential() {
    // b u (1 + t_s sin Nq + t_c cos Nq) is the slope of b u (q − (t_s cos Nq − t_c sin Nq)/N).
    let effects = with(|of| (of.torque_ripple, of.torque_ripple_order) = ([0.3, -0.1], 6));
    let mut servo = servo(&FREE, &effects);
    for _ in 0..1000 {
        servo.advance(0.5);
        let q = servo.position();
        let work = 50.0 * (q - (0.3 * (6.0 * q).cos() + 0.1 * (6.0 * q).sin()) / 6.0 + 0.05);
        assert_close(servo.velocity().powi(2) / 2.0, work, 1e-9, "energy");
    }
    assert!(servo.position() > TAU, "{}", servo.position());
}

#[test]
fn a_body_whose_inertia_goes_with_the_angle_keeps_its_energy() {
    let effects = with(|of| {
        (of.inertia_variation, of.inertia_order, of.gravity) = ([0.3, 0.2], 2, [-20.0, 3.0])
    });
    let [least, most] = keeps_its_energy(&effects, 3.0, |q| {
        let inertia = 1.0 + 0.3 * (2.0 * q).sin() + 0.2 * (2.0 * q).cos();
        [inertia, -20.0 * q.cos() - 3.0 * q.sin()]
    });
    assert!(most > 1.5 * least, "its speed changes: {least} to {most}");
}

#[test]
fn a_hanging_pendulum_oscillates_at_the_root_of_gravity() {
    let effects = with(|of| of.gravity = [-36.0, 0.0]);
    let mut servo = servo(&FREE, &effects);
    servo.advance(0.05);
    let mut upward = Vec::new();
    let mut before = servo.position();
    for sample in 1..20_000 {
        servo.advance(0.0);
        let now = servo.position();
        if before < 0.0 && now >= 0.0 {
            let share = before / (before - now);
            upward.push((f64::from(sample - 1) + share) * SAMPLE_TIME);
        }
        before = now;
    }
    let periods = (upward.len() - 1) as f64;
    let period = (upward[upward.len() - 1] - upward[0]) / periods;
    assert!(periods > 15.0);
    assert_close(period, TAU / 6.0, 1e-5, "period");
}
