//! Effects on the command: delay, current loop, dead band, hidden limit, another gain in each direction.

use identifier_core::parameters::ServoParameters;
use virtual_servo::Plant;

use crate::{
    DRY, FREE, RUBBING, SAMPLE_TIME, assert_close, assert_moves_as, servo, to_and_fro, with,
};

#[test]
fn a_delay_of_parts_of_a_sample_is_the_exact_response_shifted() {
    for tenths in [0, 4, 10, 24, 37, 640] {
        let delay = f64::from(tenths) * SAMPLE_TIME / 10.0;
        let mut delayed = servo(&RUBBING, &with(|of| of.delay = delay));
        let mut plant = Plant::at_rest(&RUBBING, SAMPLE_TIME / 10.0);
        for sample in 0..1000 {
            delayed.advance(to_and_fro(sample));
            for tenth in 10 * sample..10 * (sample + 1) {
                let given = tenth.checked_sub(tenths);
                plant.advance(given.map_or(0.0, |tenth| to_and_fro(tenth / 10)));
            }
            let about = format!("delay {delay}, sample {sample}");
            assert_close(delayed.position(), plant.position, 1e-11, &about);
            assert_close(delayed.velocity(), plant.velocity, 1e-11, &about);
        }
    }
}

#[test]
fn a_current_loop_makes_it_a_system_of_three_poles() {
    let servo_parameters = ServoParameters { a: 3.0, ..FREE };
    for time_constant in [1e-6, 1e-5, 4e-4, 1e-3, 0.02] {
        let effects = with(|of| of.current_loop = time_constant);
        let mut lagging = servo(&servo_parameters, &effects);
        // The partial fractions of b u/(s² (s + a) (1 + τ s)).
        let (a, l) = (servo_parameters.a, 1.0 / time_constant);
        let amplitude = servo_parameters.b * 0.3;
        for sample in 1..=400 {
            lagging.advance(0.3);
            let t = f64::from(sample) * SAMPLE_TIME;
            let expected = amplitude
                * (t / a - (a + l) / (a * a * l) + l * (-a * t).exp() / (a * a * (l - a))
                    - a * (-l * t).exp() / (a * l * (l - a)));
            let about = format!("time constant {time_constant}, sample {sample}");
            assert_close(lagging.position(), expected, 1e-9, &about);
        }
    }
}

#[test]
fn a_lagging_command_breaks_friction_within_a_sample() {
    // b u (1 − e^(−t/τ)) exceeds c after τ ln 2, and from there drives against it.
    let (time_constant, command) = (2.7e-3, 0.2);
    let effects = with(|of| of.current_loop = time_constant);
    let mut lagging = servo(&DRY, &effects);
    let begins = time_constant * core::f64::consts::LN_2;
    let drive = DRY.b * command;
    let fallen = |t: f64| (-t / time_constant).exp();
    for sample in 1..=50 {
        lagging.advance(command);
        let t = f64::from(sample) * SAMPLE_TIME;
        let velocity = if t < begins {
            0.0
        } else {
            (drive - 10.0) * (t - begins) - drive * time_constant * (fallen(begins) - fallen(t))
        };
        assert_close(lagging.velocity(), velocity, 1e-9, "velocity");
    }
}

#[test]
fn a_dead_band_takes_its_part_of_the_command_behind_the_limit() {
    let effects = with(|of| (of.dead_band, of.hidden_limit) = (0.02, 0.3));
    let mut bridge = servo(&RUBBING, &effects);
    let commands = (0..1000).map(to_and_fro).map(|command| {
        let size = (command.abs().min(0.3) - 0.02).max(0.0);
        [command, size.copysign(command)]
    });
    assert_moves_as(&mut bridge, &RUBBING, 1e-12, commands);
    let mut still = servo(&FREE, &effects);
    for _ in 0..100 {
        still.advance(-0.02);
    }
    assert!(still.position() == 0.0, "within the dead band nothing acts");
}

#[test]
fn a_gain_that_differs_by_direction_is_another_b_for_each_sign_of_the_command() {
    let effects = with(|of| of.gain_asymmetry = 0.1);
    for (command, b) in [(0.4, 110.0), (-0.4, 90.0)] {
        let mut servo = servo(&RUBBING, &effects);
        let plant = ServoParameters { b, ..RUBBING };
        assert_moves_as(
            &mut servo,
            &plant,
            1e-10,
            std::iter::repeat_n([command; 2], 1000),
        );
    }
}
