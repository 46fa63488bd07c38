//! Γ where none is stated: for servos of a range and motions that it knows nothing of.

use crate::support::{Bench, Draw, on_all_cores, quantile};
use identifier_core::excitation::{Excitation, Prbs};
use identifier_core::parameters::ServoParameters;
use identifier_core::{GradientLoop, Settings};

/// Errors of b after a minute, relative, of servos whose dither has an amplitude, rad, and their command a limit.
fn errors(sample_time: f64, amplitude: f64, limit: f64) -> Vec<f64> {
    let settings = Settings::new(sample_time, 10_000.0)
        .with_pid(9.0, 0.19, 4.0, limit)
        .with_servo_range([0.0, 50.0], [110.0, 1000.0]);
    on_all_cores(12, |seed| {
        let mut draw = Draw::new(5000 + seed);
        let truth = ServoParameters::new(
            draw.uniform(0.0, 50.0),
            draw.between(110.0, 1000.0),
            draw.uniform(0.0, 20.0) * amplitude.min(1.0),
            draw.uniform(-40.0, 40.0) * limit.min(1.0),
        );
        let servo_loop: GradientLoop = settings.build().expect("certified");
        let prbs = Prbs::new(&settings.units().expect("valid"), amplitude, 0.1, 9).expect("valid");
        let (mut state, mut dither) = (servo_loop.start(0), Excitation::<f32>::start(&prbs));
        let mut servo = Bench::new(&truth, &settings, 0);
        for _ in 0..(60.0 / sample_time) as u32 {
            let offset = prbs.process(&mut dither);
            let step = servo_loop.process(&mut state, 0, offset, servo.count());
            let command = step.expect("possible").control.command;
            servo.plant.advance(command.into());
            servo_loop.work(&mut state, 1);
        }
        let found = servo_loop.estimates(&state).expect("estimates");
        (found.b / truth.b - 1.0).abs()
    })
}

#[test]
fn the_chosen_gamma_finds_servos_of_the_range() {
    // Sample time, s; amplitude of the dither, rad; limit; the largest median and the largest error of b. A small motion
    // under a wide limit is learnt from slowly.
    for (sample_time, amplitude, limit, middle, most) in [
        (1e-3, 0.1, 10.0, 0.03, 0.15),
        (1e-3, 0.3, 10.0, 0.002, 0.01),
        (1e-3, 1.0, 10.0, 0.002, 0.01),
        (1e-3, 0.1, 1.0, 0.005, 0.02),
        (1e-3, 0.03, 1.0, 0.01, 0.04),
        (2.5e-4, 1.0, 10.0, 0.002, 0.01),
        (5e-5, 0.3, 10.0, 0.005, 0.05),
    ] {
        let errors = errors(sample_time, amplitude, limit);
        let found = [0.5, 1.0].map(|part| quantile(&errors, part));
        println!("{sample_time} s, amplitude {amplitude}, limit {limit}: {found:?}");
        assert!(found[0] < middle && found[1] < most, "{found:?}");
    }
}
