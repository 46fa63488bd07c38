//! Gains and promises for servos of two masses, against the virtual servo's two masses.

use std::f64::consts::TAU;

use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::{Mode, Resonance, StepMeasure, Tuner, Tuning, TuningSettings};
use virtual_servo::Effects;

use crate::support::{Bench, identified, step};

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
    };
    let tuner = Tuner::for_response(settings, &servo(coulomb), Some(&resonance)).expect("valid");
    let (mut state, mut slices) = (tuner.start(), 0);
    loop {
        slices += 1;
        if let Some(tuning) = tuner.work(&mut state) {
            return (tuner, tuning.expect("gains"), slices);
        }
    }
}

/// The loop around a servo that has the mode.
fn bench(mode: Mode, coulomb: f64, settings: &TuningSettings, tuning: &Tuning) -> Bench {
    let IdentifiedServo {
        parameters, delay, ..
    } = servo(coulomb);
    let effects = Effects {
        delay,
        resonance: mode.frequency,
        resonance_damping: Some(mode.damping),
        inertia_ratio: mode.ratio / (1.0 + mode.ratio),
        ..Effects::NONE
    };
    Bench::of(tuning, settings, &parameters, &effects, 0.0)
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
        let mut bench = bench(mode, 0.0, &settings, &tuning);
        let duration = 20.0 / tuning.bandwidth;
        let (mut off, mut off_of_one, mut now) = (0.0_f64, 0.0_f64, 0);
        // Slow loops are predicted with samples of up to 0.025/ω, the others with their own.
        let is_exact = 2.0 * settings.sample_time > 0.025 / tuning.bandwidth;
        let tolerance = if is_exact { 1e-4 } else { 0.01 };
        for (predicted, of_one) in steps.zip(of_one).take_while(|(at, _)| at.time < duration) {
            let sample = (predicted.time / settings.sample_time).round() as u32;
            let mut position = 0.0;
            while now <= sample {
                position = bench.advance(settings.step).0;
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
            let predicted_response = &tuning.predicted_response;
            let mut bench = bench(mode, coulomb, &settings, &tuning);
            let measure: StepMeasure<f64> = step(&mut bench, &settings, 25.0 / tuning.bandwidth);
            let rise = measure.rise().map(|rise| rise * settings.sample_time);
            println!(
                "{:.0} Hz ratio {} c {coulomb}: rise {rise:?} of {:.4}, overshoot {:.3} of {:.3}",
                mode.frequency / TAU,
                mode.ratio,
                predicted_response.rise_time,
                measure.overshoot(),
                predicted_response.overshoot
            );
            assert!(
                measure.overshoot() < predicted_response.overshoot + 0.03,
                "{mode:?}"
            );
            let rise = rise.expect("it rises") / predicted_response.rise_time;
            assert!((rise - 1.0).abs() < 0.15, "{mode:?} {coulomb}: {rise}");
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
    };
    let settings = TuningSettings::new(1e-4, 0.0, 10.0, 0.2);
    let tuner = Tuner::for_response(&settings, &known, Some(&resonance)).expect("valid");
    let mut state = tuner.start();
    let tuning = core::iter::repeat_with(|| tuner.work(&mut state)).find_map(|found| found);
    let tuning = tuning.expect("it ends").expect("gains");
    let effects = Effects {
        delay: known.delay,
        resonance: mode.frequency,
        resonance_damping: Some(mode.damping),
        inertia_ratio: 0.6,
        ..Effects::NONE
    };
    let mut bench = Bench::of(&tuning, &settings, &truth, &effects, 0.0);
    let mut farthest = [0.0_f64; 3];
    for second in &mut farthest {
        for _ in 0..20_000 {
            let off = bench.advance(settings.step).0 - settings.step;
            *second = second.max(off.abs());
        }
    }
    let [_, first, then] = farthest;
    println!(
        "{:.1} rad/s, {first:.6} and then {then:.6}",
        tuning.bandwidth
    );
    assert!(then < 1e-4 * settings.step, "{first} {then}");
}
