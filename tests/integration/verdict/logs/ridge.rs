//! Logs of a motor with 102 counts a turn that do not determine b. None may be called converged.

use std::f64::consts::TAU;

use integration_tests::Random;
use integration_tests::logs::{Controller, LoopSetup, Reference};
use virtual_servo::{Effects, SensorEffects, ServoParameters, distinct_seed};

use super::campaign;
use super::identify::{FIT, FOUR};
use super::judge::{Judgement, judge};
use super::table::count;

/// It follows slow ramps: its command is that which friction takes, so that the record shows the ratio of b and c. Its
/// accelerations, a hundredth of friction, would show their sizes, but a load that wanders by more hides them.
fn slow_motor(random: &mut Random) -> LoopSetup {
    let coulomb = random.log_uniform(20.0, 100.0);
    let b = random.log_uniform(5.0, 30.0);
    let sample_time = random.log_uniform(5e-3, 2e-2);
    let holding = coulomb / b;
    LoopSetup {
        servo: ServoParameters {
            a: random.log_uniform(1.0, 5.0),
            b,
            coulomb,
            load: 0.0,
        },
        effects: Effects {
            load_wander: [0.03 * coulomb, 0.3],
            ..Effects::NONE
        },
        limit: 3.0 * holding,
        controller: Controller::Pid {
            kp: holding * random.log_uniform(0.5, 2.0),
            ki: holding * random.log_uniform(0.5, 2.0),
            kd: holding * random.log_uniform(0.02, 0.1),
        },
        reference: Reference::Trapezoids {
            amplitude: TAU,
            velocity: random.log_uniform(0.2, 0.6),
            acceleration: random.log_uniform(0.1, 0.3),
            pause: 0.5,
        },
        ..motor(random, sample_time)
    }
}

/// Its velocity follows the command within a fifth of a sample or less, so that the record shows b/a and c/a. The lag
/// would show their sizes, but a delay hides it.
fn fast_motor(random: &mut Random) -> LoopSetup {
    let sample_time = random.log_uniform(1e-2, 3e-2);
    let a = random.log_uniform(5.0, 8.0) / sample_time;
    let b = a * random.log_uniform(0.5, 2.0);
    let (speed, bandwidth) = (random.log_uniform(5.0, 20.0), random.log_uniform(2.0, 4.0));
    let limit = speed * a / b;
    LoopSetup {
        servo: ServoParameters {
            a,
            b,
            coulomb: b * limit * random.log_uniform(0.05, 0.2),
            load: 0.0,
        },
        effects: Effects {
            delay: sample_time * random.uniform(0.5, 2.0),
            ..Effects::NONE
        },
        limit,
        controller: Controller::Pid {
            kp: bandwidth * a / b,
            ki: 0.0,
            kd: 0.0,
        },
        reference: Reference::Steps {
            amplitude: 0.5 * speed / bandwidth,
            hold: 4.0 / bandwidth,
        },
        ..motor(random, sample_time)
    }
}

/// Encoder and record of both.
fn motor(random: &mut Random, sample_time: f64) -> LoopSetup {
    LoopSetup {
        seed: random.seed(),
        servo: ServoParameters {
            a: 0.0,
            b: 1.0,
            coulomb: 0.0,
            load: 0.0,
        },
        effects: Effects::NONE,
        sensor: SensorEffects::default(),
        counts_per_rev: 102.0,
        sample_time,
        samples: (40.0 / sample_time) as usize,
        skipped: 0,
        limit: 1.0,
        controller: Controller::Pid {
            kp: 1.0,
            ki: 0.0,
            kd: 0.0,
        },
        cutoff: 20.0,
        bandwidth: 1.0,
        reference: Reference::Steps {
            amplitude: 1.0,
            hold: 1.0,
        },
        shift: 0.0,
        load_steps: Vec::new(),
        present: Vec::new(),
    }
}

#[test]
fn a_log_that_does_not_determine_b_is_not_converged() {
    let (seed, logs) = campaign(3);
    let numbers: Vec<u32> = (0..logs).collect();
    let settings = [FIT, FOUR];
    for (name, setup) in [
        ("slow", slow_motor as fn(&mut Random) -> LoopSetup),
        ("fast", fast_motor),
    ] {
        let judged = judge(&settings, &numbers, |&number| {
            setup(&mut Random::new(distinct_seed(seed, number))).record()
        });
        for (settings, judged) in settings.iter().zip(&judged) {
            let judged: Vec<&Judgement> = judged.iter().collect();
            let off_b: Vec<f64> = judged.iter().filter_map(|j| j.off_b).collect();
            let converged = count(&judged, |j| j.is_converged);
            println!(
                "{name} motor, {}: {converged} of {logs} are converged; b off {off_b:.2?}",
                settings.name
            );
            assert_eq!(converged, 0, "{name} motor, {}", settings.name);
        }
    }
}
