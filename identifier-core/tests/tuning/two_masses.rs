//! Gains and promises for servos of two masses, against the virtual servo's two masses.

use std::f64::consts::TAU;

use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::{Mode, Resonance, StepMeasure, Tuner, Tuning, TuningSettings};
use virtual_servo::Effects;

use crate::support::{bench_of, identified, step, worked};

/// Resonances, Hz, with damping and the load's inertia over the motor's.
fn modes() -> impl Iterator<Item = Mode> {
    let shapes = [(0.005, 0.2), (0.02, 1.0), (0.08, 8.0)];
    [12.0, 40.0, 150.0, 500.0]
        .into_iter()
        .flat_map(move |hertz| {
            shapes.map(|(damping, ratio)| Mode {
                frequency: TAU * hertz,
                damping,
                ratio,
            })
        })
}

fn servo(coulomb: f64) -> IdentifiedServo {
    let parameters = ServoParameters::new(0.03, 500.0, coulomb, 0.0);
    identified(parameters, 3e-4, [0.0; 3])
}

fn settings() -> TuningSettings {
    TuningSettings::new(2.5e-4, 1e-4, 10.0, 0.1)
}

/// The tuner of a mode, its gains, and its slices.
fn tuned(mode: Mode, coulomb: f64, settings: &TuningSettings) -> (Tuner, Tuning, u32) {
    let resonance = Resonance {
        mode,
        errors: [0.01, 0.2],
        friction_on_motor: false,
    };
    let tuner = Tuner::for_response(settings, &servo(coulomb), Some(&resonance)).expect("valid");
    let (tuning, slices) = worked(&tuner);
    (tuner, tuning.expect("gains"), slices)
}

/// The loop around a servo that has the mode.
fn bench(
    mode: Mode,
    servo: &IdentifiedServo,
    settings: &TuningSettings,
    tuning: &Tuning,
) -> impl FnMut(f64) -> f64 + use<> {
    let effects = Effects {
        delay: servo.delay,
        resonance: mode.frequency,
        resonance_damping: Some(mode.damping),
        inertia_ratio: mode.ratio / (1.0 + mode.ratio),
        ..Effects::NONE
    };
    bench_of(tuning, settings, &servo.parameters, &effects, 0.0)
}

/// With and without the notch, and never with a reference model.
#[test]
fn gains_for_two_masses_are_found_within_their_slices() {
    let settings = TuningSettings {
        feed_forward: true,
        ..settings()
    };
    let mut most = 0;
    for mode in modes() {
        let (_, tuning, slices) = tuned(mode, 5.0, &settings);
        assert_eq!(tuning.feed_forward, None, "{mode:?}");
        most = slices.max(most);
    }
    println!("{most} slices at most");
    assert!((1000..60_000).contains(&most), "{most}");
}

#[test]
fn the_predicted_step_is_that_of_two_masses() {
    let settings = TuningSettings {
        resolution: 0.0,
        ..settings()
    };
    let (mut twisted, mut exact) = (0.0_f64, 0);
    for mode in modes() {
        let (tuner, tuning, _) = tuned(mode, 0.0, &settings);
        let one_mass = Tuner::new(&settings, &servo(0.0)).expect("valid");
        let [steps, of_one] = [&tuner, &one_mass].map(|by| by.step(&tuning).expect("valid"));
        let mut bench = bench(mode, &servo(0.0), &settings, &tuning);
        let duration = 20.0 / tuning.bandwidth;
        let (mut off, mut off_of_one, mut now) = (0.0_f64, 0.0_f64, 0);
        // Slow loops are predicted with samples of up to 0.025/ω, the others with their own.
        let is_exact = 2.0 * settings.sample_time > 0.025 / tuning.bandwidth;
        let tolerance = if is_exact { 1e-4 } else { 0.01 };
        for (predicted, of_one) in steps.zip(of_one).take_while(|(at, _)| at.time < duration) {
            let sample = (predicted.time / settings.sample_time).round() as u32;
            let mut position = 0.0;
            while now <= sample {
                position = bench(settings.step);
                now += 1;
            }
            off = off.max((predicted.position - position).abs() / settings.step);
            off_of_one = off_of_one.max((of_one.position - position).abs() / settings.step);
        }
        let hertz = mode.frequency / TAU;
        println!("{hertz:.0} Hz, {mode:?}: {off:.5}, of one mass {off_of_one:.5}");
        assert!(off < tolerance, "{mode:?}: {off}");
        exact += u32::from(is_exact);
        twisted = twisted.max(off_of_one);
    }
    assert!(twisted > 0.04 && exact >= 4, "{twisted} {exact}");
}

/// Friction that acts on the motor alone.
#[test]
fn the_prediction_of_two_masses_with_friction_is_kept() {
    let settings = settings();
    for mode in modes() {
        for coulomb in [5.0, 20.0, 50.0] {
            let (_, tuning, _) = tuned(mode, coulomb, &settings);
            let predicted = &tuning.predicted_response;
            let bench = bench(mode, &servo(coulomb), &settings, &tuning);
            let measure: StepMeasure<f64> = step(bench, &settings, 25.0 / tuning.bandwidth);
            let beyond = measure.overshoot() - predicted.overshoot;
            let rise = measure.rise().expect("it rises") * settings.sample_time;
            let rise = rise / predicted.rise_time;
            assert!((rise - 1.0).abs() < 0.15, "{mode:?} {coulomb}: {rise}");
            assert!(beyond < 0.03, "{mode:?} {coulomb}: {beyond}");
        }
    }
}

/// A load at 12 Hz on a motor whose loop is faster: the integral drives its motion, and only friction damps it. The estimate of
/// viscous friction, 2.9 ± 2.1 where 0.2 is true, is not relied on.
#[test]
fn viscous_friction_that_is_uncertain_damps_no_mode() {
    let mode = Mode {
        frequency: TAU * 12.2,
        damping: 0.01,
        ratio: 1.5,
    };
    let truth = ServoParameters::new(0.2, 840.0, 0.0, 0.0);
    let known = identified(ServoParameters { a: 2.9, ..truth }, 2.5e-4, [2.1, 0.0, 0.0]);
    let resonance = Resonance {
        mode,
        errors: [0.005, 0.4],
        friction_on_motor: false,
    };
    let settings = TuningSettings::new(1e-4, 0.0, 10.0, 0.2);
    let tuner = Tuner::for_response(&settings, &known, Some(&resonance)).expect("valid");
    let tuning = worked(&tuner).0.expect("gains");
    let mut bench = bench(
        mode,
        &identified(truth, 2.5e-4, [0.0; 3]),
        &settings,
        &tuning,
    );
    let mut farthest = [0.0_f64; 3];
    for second in &mut farthest {
        for _ in 0..20_000 {
            let off = bench(settings.step) - settings.step;
            *second = second.max(off.abs());
        }
    }
    let [_, first, then] = farthest;
    assert!(then < 1e-4 * settings.step, "{first} {then}");
}
