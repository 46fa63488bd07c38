//! The windowed law: its work can be cut into any slices, and the recursive law stays near its own first
//! fit.

use identifier_core::control::{ControlState, Controller};
use identifier_core::excitation::Excitation;
use identifier_core::identifier::{GaussNewtonIdentifier, Identify, WindowIdentifier};
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::parameters::{AbLoad, ServoParameters};
use identifier_core::{ControllerSettings, Settings};
use virtual_servo::excitation::{BandLimitedWhiteNoise, BandLimitedWhiteNoiseState};
use virtual_servo::{Encoder, Plant};

const COUNTS: f64 = 10_000.0;

/// Blocks of a window.
const BLOCKS: usize = 50;

/// Samples of a window: three to a block.
const SAMPLES: u32 = 150;

type Window = WindowIdentifier<f32, AbLoad, 3, BLOCKS>;

/// The paper's loop, and a window of [`SAMPLES`].
fn settings() -> Settings {
    let mut settings = Settings {
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..Settings::new(1e-3, COUNTS)
    };
    settings.identifier.start_time = Some(f64::from(SAMPLES) * settings.sample_time);
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

/// A window that has been filled from rest, and the drive afterwards.
fn filled(seed: u32) -> (Window, <Window as Identify<f32>>::State, Drive) {
    let mut drive = Drive::new(seed);
    let window: Window = settings().build().expect("valid");
    let mut state = window.start();
    // A command shows its effect in the next sample.
    drive.show(&window, &mut state, SAMPLES + 1);
    (window, state, drive)
}

#[test]
fn slices_of_any_size_give_the_same_bits() {
    let (window, state, _) = filled(7);
    let fit = |budget: u32| {
        let mut state = state;
        let mut slices = 0;
        loop {
            window.work(&mut state, budget);
            slices += 1;
            if !window.is_fitting(&state) {
                break;
            }
        }
        assert_eq!(window.fits(&state), 1);
        (state, slices)
    };
    let (whole, once) = fit(u32::MAX);
    assert_eq!(once, 1);
    let found = window.estimates(&whole);
    assert!((found.b / 257.7 - 1.0).abs() < 0.01, "{found:?}");
    for budget in [1, 7, 64] {
        let (sliced, slices) = fit(budget);
        assert!(sliced == whole, "budget {budget}");
        // A look at the record, a linear pass and at most twelve passes from each of three starts,
        // with a judgement after each.
        let most = (2 + 3 * 12) * (BLOCKS as u32 + 1) + 3;
        assert!(
            slices <= most.div_ceil(budget),
            "{slices} slices of {budget}"
        );
    }
}

#[test]
fn a_record_under_fit_is_not_changed_by_new_samples() {
    for samples in [SAMPLES, 3 * SAMPLES / 4] {
        let mut drive = Drive::new(7);
        let window: Window = settings().build().expect("valid");
        let mut state = window.start();
        drive.show(&window, &mut state, samples + 1);
        let mut undisturbed = state;
        window.work(&mut undisturbed, u32::MAX);

        window.work(&mut state, 1);
        while window.is_fitting(&state) {
            // Nothing that a servo would do.
            window.process(&mut state, 1000, -10.0).expect("possible");
            window.work(&mut state, 10);
        }
        assert_eq!(window.fits(&state), 1);
        assert_eq!(window.estimates(&state), window.estimates(&undisturbed));
        assert_eq!(
            window.standard_errors(&state),
            window.standard_errors(&undisturbed)
        );
    }
}

#[test]
fn a_full_window_waits_for_the_fit_and_then_begins_anew() {
    let (window, mut state, mut drive) = filled(7);
    window.work(&mut state, 10);
    for _ in 0..40 {
        drive.show(&window, &mut state, 1);
        window.work(&mut state, 10);
    }
    while window.is_fitting(&state) {
        window.work(&mut state, 10);
    }
    assert_eq!(window.fits(&state), 1);
    // In motion now: the new window has an initial state to find.
    drive.show(&window, &mut state, SAMPLES);
    window.work(&mut state, u32::MAX);
    assert_eq!(window.fits(&state), 2);
    let found = window.estimates(&state);
    assert!((found.b / 257.7 - 1.0).abs() < 0.02, "{found:?}");
}

#[test]
fn the_recursive_law_starts_from_its_first_fit_and_stays_near() {
    let mut settings = settings();
    // The first fit is tried at half of it.
    settings.identifier.start_time = Some(0.6);
    let recursive: GaussNewtonIdentifier<f32, AbLoad, 3> = settings.build().expect("valid");
    for seed in 100..120 {
        let mut drive = Drive::new(seed);
        let mut state = recursive.start();
        for k in 0..10_000 {
            drive.show(&recursive, &mut state, 1);
            recursive.work(&mut state, 100);
            assert!(k < 1000 || recursive.is_running(&state), "seed {seed}");
            if recursive.is_running(&state) {
                let found = recursive.estimates(&state);
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
