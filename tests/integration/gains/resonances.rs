//! Resonances that are known, and those that nothing has shown.

use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::{Mode, Resonance, Shown, Tuner, Tuning, TuningSettings};
use integration_tests::Random;
use integration_tests::exact_loop::{ExactLoop, LinearController};
use virtual_servo::Effects;

const COUNT: f64 = std::f64::consts::TAU / 20_000.0;

/// A servo of one mass with its delay, s, and the settings of its tuning.
fn drawn(random: &mut Random) -> (ServoParameters, f64, TuningSettings) {
    let sample_time = 1.0 / random.log_uniform(250.0, 20_000.0);
    let b = random.log_uniform(50.0, 5000.0);
    let servo = ServoParameters::new(random.log_uniform(0.1, 20.0), b, 0.0, 0.0);
    let delay = random.uniform(0.0, 2.0) * sample_time;
    (
        servo,
        delay,
        TuningSettings::new(sample_time, COUNT, 10.0, 0.1),
    )
}

/// A mode of two masses as effects of the servo; with the encoder on the load the share is any.
fn effects(mode: Mode, delay: f64, share_of_load: f64) -> Effects {
    let on_load = mode.ratio < 0.0;
    Effects {
        delay,
        resonance: mode.frequency,
        resonance_damping: Some(mode.damping),
        inertia_ratio: if on_load {
            share_of_load
        } else {
            mode.ratio / (1.0 + mode.ratio)
        },
        encoder_on_load: on_load,
        ..Effects::NONE
    }
}

/// Viscous friction of a motor acts on both modes of its axis.
#[test]
fn the_sensitivity_of_a_known_resonance_is_that_of_the_exact_loop() {
    let mut random = Random::new(40);
    let mut most = 0.0_f64;
    for _ in 0..40 {
        let (servo, delay, settings) = drawn(&mut random);
        let mode = Mode {
            frequency: random.log_uniform(0.02, 2.5) / settings.sample_time,
            damping: random.log_uniform(0.005, 0.1),
            ratio: random.log_uniform(0.1, 5.0),
        };
        let resonance = Resonance {
            mode,
            errors: [0.0; 2],
            friction_on_motor: true,
        };
        let known = IdentifiedServo::known(servo, delay);
        let tuner = Tuner::for_response(&settings, &known, Some(&resonance)).expect("valid");
        let Ok(tuning) = tuner.run(Shown::Nothing) else {
            continue;
        };
        let controller = LinearController::tuned(&tuning, settings.sample_time);
        let effects = effects(mode, delay, 0.0);
        let exact = ExactLoop::new(&servo, &effects, settings.sample_time, controller);
        for place in 1..60 {
            let frequency = 3.0 / settings.sample_time * 0.85_f64.powi(place);
            let [of_tuner, _] = tuner
                .sensitivity(&tuning, frequency)
                .expect("below its half");
            let of_loop = 1.0 / (exact.gain(frequency) + 1.0).power().sqrt();
            most = most.max((of_tuner / of_loop - 1.0).abs());
        }
    }
    assert!(most < 1e-6, "off by {most:e}");
}

/// Every mode of the envelope from a stated frequency on.
#[test]
fn gains_bear_every_resonance_above_a_stated_one() {
    const MOST: f64 = 1.05 * TuningSettings::HIDDEN_SENSITIVITY;
    let mut random = Random::new(integration_tests::environment("SEED").unwrap_or(93));
    let servos = 40 * integration_tests::factor::<u32>();
    let (mut tuned, mut largest, mut fell) = (0, 0.0_f64, 0);
    for number in 0..servos {
        let (servo, delay, mut settings) = drawn(&mut random);
        let lowest = random.log_uniform(0.05, 3.0) / settings.sample_time;
        settings.resonance = Some(lowest);
        let known = IdentifiedServo::known(servo, delay);
        let run = |settings: &TuningSettings| -> Option<Tuning> {
            Tuner::new(settings, &known).ok()?.run(Shown::Nothing).ok()
        };
        let Some(tuning) = run(&settings) else {
            continue;
        };
        tuned += 1;
        let unguarded = run(&TuningSettings {
            resonance: Some(f64::INFINITY),
            ..settings
        });
        let unguarded = unguarded.expect("no slower than the other");
        for _ in 0..20 {
            let highest = 6.0 / settings.sample_time;
            let mode = Mode {
                frequency: random.log_uniform(lowest, highest.max(1.01 * lowest)),
                damping: random.log_uniform(TuningSettings::HIDDEN_DAMPING, 0.2),
                ratio: match random.chance(0.3) {
                    true => Mode::ON_LOAD,
                    false => random.log_uniform(0.02, TuningSettings::HIDDEN_RATIO),
                },
            };
            let effects = effects(mode, delay, random.uniform(0.1, 0.9));
            let exact = |tuning: &Tuning| {
                let controller = LinearController::tuned(tuning, settings.sample_time);
                ExactLoop::new(&servo, &effects, settings.sample_time, controller)
            };
            let sensitivity = exact(&tuning).sensitivity();
            assert!(
                sensitivity < MOST,
                "servo {number}, {mode:?}: {sensitivity}"
            );
            largest = largest.max(sensitivity);
            fell += u32::from(exact(&unguarded).largest_pole() >= 1.0);
        }
    }
    println!(
        "{tuned} of {servos} tuned, largest Ms {largest:.2}; without the guard {fell} loops are unstable"
    );
    assert!(2 * tuned > servos, "{tuned}");
    assert!(
        fell > 20,
        "the modes are ones that gains may not bear: {fell}"
    );
}
