//! The recursive law stays near its own first fit.

use crate::support::{Bench, certified};
use identifier_core::control::{ControlState, Controller};
use identifier_core::excitation::Excitation;
use identifier_core::identifier::{GaussNewtonIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{AbLoad, ServoParameters};
use virtual_servo::excitation::BandLimitedWhiteNoise;

#[test]
fn the_recursive_estimator_starts_from_its_first_fit_and_stays_near() {
    let mut settings = certified();
    // The first fit is tried at half of it.
    settings.identifier.start_time = Some(0.6);
    let recursive: GaussNewtonIdentifier<f32, AbLoad, 3> = settings.build().expect("valid");
    let controller: Controller<f32, LowPass<f32>> = settings.build().expect("valid");
    let units = settings.units().expect("valid");
    let servo = ServoParameters::new(0.2174, 257.7, 0.0, 20.0);
    for seed in 100..120 {
        let noise = BandLimitedWhiteNoise::new(&units, 0.005, 0.1, seed).expect("valid");
        let mut reference = Excitation::<f32>::start(&noise);
        let mut bench = Bench::new(&servo, &settings, 0);
        let (mut control, mut state) = (ControlState::default(), recursive.start());
        let mut last = 0;
        for k in 0..10_000 {
            let wanted: f32 = noise.process(&mut reference);
            let count = bench.count();
            let moved = count - std::mem::replace(&mut last, count);
            let command = controller
                .process(&mut control, wanted - count as f32, moved as f32)
                .expect("within reach")
                .command;
            bench.plant.advance(f64::from(command));
            recursive
                .process(&mut state, moved, command)
                .expect("a possible sample");
            recursive.work(&mut state, 100);
            assert!(k < 1000 || recursive.is_running(&state), "seed {seed}");
            if recursive.is_running(&state) {
                let found = recursive.estimates(&state).expect("estimates");
                let off = [(found.b / servo.b - 1.0).abs(), (found.a - servo.a).abs()];
                assert!(
                    off[0] < 0.02 && off[1] < 0.1,
                    "seed {seed}, sample {k}: {found:?}"
                );
            }
        }
    }
}
