//! Resonances that are known, and those that nothing has shown.

use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::{Goal, Mode, Resonance, Shown, Tuner, Tuning, TuningSettings};
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

/// What becomes of gains with modes of the envelope, drawn from a frequency on.
#[derive(Default)]
struct Tally {
    loops: u32,
    unstable: u32,
    /// Beyond the sensitivity that the tuner promises for them.
    above: u32,
    /// Bandwidths over those without a resonance.
    bandwidths: Vec<f64>,
}

/// A rule that keeps gains away from hidden resonances, by what it makes of settings whose bandwidth without them is
/// known.
type Rule = (&'static str, fn(TuningSettings, f64) -> TuningSettings);

/// The poles so many times below: the crossover is at about twice their ω.
fn below(settings: TuningSettings, free: f64, crossovers: f64) -> TuningSettings {
    let lowest = settings.resonance.expect("stated");
    TuningSettings {
        goal: Goal::Bandwidth(free.min(lowest / (2.0 * crossovers))),
        resonance: Some(f64::INFINITY),
        ..settings
    }
}

const RULES: [Rule; 4] = [
    ("each mode", |settings, _| settings),
    ("4 crossovers", |settings, free| below(settings, free, 4.0)),
    ("8 crossovers", |settings, free| below(settings, free, 8.0)),
    ("none", |settings, free| below(settings, free, 0.0)),
];

/// Each rule against the same modes.
fn tallies(seed: u32, servos: u32) -> [Tally; RULES.len()] {
    let mut random = Random::new(seed);
    let mut tallies = RULES.map(|_| Tally::default());
    for _ in 0..servos {
        let (servo, delay, mut settings) = drawn(&mut random);
        let lowest = random.log_uniform(0.05, 3.0) / settings.sample_time;
        settings.resonance = Some(lowest);
        let highest = (6.0 / settings.sample_time).max(1.01 * lowest);
        let modes: Vec<(Mode, f64)> = (0..20)
            .map(|_| {
                let ratio = match random.chance(0.3) {
                    true => Mode::ON_LOAD,
                    false => random.log_uniform(0.02, TuningSettings::HIDDEN_RATIO),
                };
                let mode = Mode {
                    frequency: random.log_uniform(lowest, highest),
                    damping: random.log_uniform(TuningSettings::HIDDEN_DAMPING, 0.2),
                    ratio,
                };
                (mode, random.uniform(0.1, 0.9))
            })
            .collect();
        let known = IdentifiedServo::known(servo, delay);
        let run = |settings: &TuningSettings| -> Option<Tuning> {
            Tuner::new(settings, &known).ok()?.run(Shown::Nothing).ok()
        };
        let free = run(&TuningSettings {
            resonance: Some(f64::INFINITY),
            ..settings
        });
        let free = free.expect("gains for one mass").bandwidth;
        for ((_, rule), tally) in RULES.iter().zip(&mut tallies) {
            let Some(tuning) = run(&rule(settings, free)) else {
                continue;
            };
            tally.bandwidths.push(tuning.bandwidth / free);
            for (mode, share) in &modes {
                let effects = effects(*mode, delay, *share);
                let controller = LinearController::tuned(&tuning, settings.sample_time);
                let exact = ExactLoop::new(&servo, &effects, settings.sample_time, controller);
                let sensitivity = exact.sensitivity();
                tally.loops += 1;
                tally.unstable += u32::from(sensitivity.is_infinite());
                tally.above += u32::from(sensitivity > 1.05 * TuningSettings::HIDDEN_SENSITIVITY);
            }
        }
    }
    for ((name, _), tally) in RULES.iter().zip(&mut tallies) {
        tally.bandwidths.sort_by(f64::total_cmp);
        let part = |of: usize| tally.bandwidths[of * tally.bandwidths.len() / 100];
        println!(
            "{name:12} {} of {servos} servos, bandwidth at 10, 50 % {:.2} {:.2}; of {} modes {} unstable, {} above Ms 2.4",
            tally.bandwidths.len(),
            part(10),
            part(50),
            tally.loops,
            tally.unstable,
            tally.above
        );
    }
    tallies
}

/// Every mode of the envelope from a stated frequency on. A fixed distance is no such guard.
#[test]
fn gains_bear_every_resonance_above_a_stated_one() {
    let servos = 12 * integration_tests::factor::<u32>();
    let seed = integration_tests::environment("SEED").unwrap_or(93);
    let [each, _, _, none] = tallies(seed, servos);
    assert_eq!(each.unstable + each.above, 0);
    assert!(
        10 * each.bandwidths.len() as u32 > 9 * servos,
        "{}",
        each.bandwidths.len()
    );
    assert!(
        none.unstable > 5,
        "modes that gains may not bear: {}",
        none.unstable
    );
}
