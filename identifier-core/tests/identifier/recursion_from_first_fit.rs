//! The recursive law stays near its own first fit.

use identifier_core::Settings;
use identifier_core::control::{ControlState, Controller};
use identifier_core::excitation::Excitation;
use identifier_core::identifier::{GaussNewtonIdentifier, Identify};
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::parameters::{AbLoad, ServoParameters};
use identifier_core::settings::ControllerSettings;
use virtual_servo::excitation::{BandLimitedWhiteNoise, BandLimitedWhiteNoiseState};
use virtual_servo::{Encoder, Plant};

const COUNTS: f64 = 10_000.0;

/// The paper's loop, and a first fit from 0.3 s on.
fn settings() -> Settings {
    let mut settings = Settings {
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..Settings::new(1e-3, COUNTS)
    };
    // The first fit is tried at half of it.
    settings.identifier.start_time = Some(0.6);
    settings
}

/// A drive: plant, encoder, controller and reference.
struct Drive {
    controller: Controller<f32, LowPass<f32>>,
    control: ControlState<f32, <LowPass<f32> as VelocityEstimate<f32>>::State>,
    plant: Plant,
    count: i32,
    noise: BandLimitedWhiteNoise,
    reference: BandLimitedWhiteNoiseState<f32>,
}

impl Drive {
    fn new(seed: u32) -> Self {
        let settings = settings();
        let units = settings.units().expect("valid");
        let noise = BandLimitedWhiteNoise::new(&units, 0.005, 0.1, seed).expect("valid");
        let servo = ServoParameters {
            a: 0.2174,
            b: 257.7,
            coulomb: 0.0,
            load: 20.0,
        };
        Self {
            controller: settings.build().expect("valid"),
            control: ControlState::default(),
            plant: Plant::at_rest(&servo, settings.sample_time),
            count: 0,
            reference: noise.start(),
            noise,
        }
    }

    /// A sample: the counts moved since the last, and the command that acts from now on.
    fn sample(&mut self) -> (i32, f32) {
        let wanted: f32 = self.noise.process(&mut self.reference);
        let count = Encoder::new(COUNTS).read(self.plant.position) as i32;
        let moved = count - std::mem::replace(&mut self.count, count);
        let sample = self
            .controller
            .process(&mut self.control, wanted - count as f32, moved as f32)
            .expect("within reach");
        self.plant.advance(f64::from(sample.command));
        (moved, sample.command)
    }

    /// Runs an identifier over the next samples.
    fn show<I: Identify<f32>>(&mut self, identifier: &I, state: &mut I::State, samples: u32) {
        for _ in 0..samples {
            let (moved, command) = self.sample();
            identifier
                .process(state, moved, command)
                .expect("a possible sample");
        }
    }
}

#[test]
fn the_recursive_estimator_starts_from_its_first_fit_and_stays_near() {
    let recursive: GaussNewtonIdentifier<f32, AbLoad, 3> = settings().build().expect("valid");
    for seed in 100..120 {
        let mut drive = Drive::new(seed);
        let mut state = recursive.start();
        for k in 0..10_000 {
            drive.show(&recursive, &mut state, 1);
            recursive.work(&mut state, 100);
            assert!(k < 1000 || recursive.is_running(&state), "seed {seed}");
            if recursive.is_running(&state) {
                let found = recursive.estimates(&state).expect("estimates");
                assert!(
                    (found.b / 257.7 - 1.0).abs() < 0.02,
                    "seed {seed}, sample {k}: {found:?}"
                );
                assert!(
                    (found.a - 0.2174).abs() < 0.1,
                    "seed {seed}, sample {k}: {found:?}"
                );
            }
        }
    }
}
