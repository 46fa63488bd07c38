//! No false alarm.

use std::vec::Vec;

use crate::watch::Use;
use identifier_core::parameters::ServoParameters;
use virtual_servo::SplitMix64;
use virtual_servo::faults::{FaultKind, InjectedFault};

use super::support::{Axis, Drive, Knowledge, Run, STEP};

fn log_uniform(random: &mut SplitMix64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.next_uniform())
}

fn axis(random: &mut SplitMix64) -> Axis {
    let sample_time = 1.0 / random.one_of(&[250.0, 1e3, 4e3, 10e3, 20e3]);
    let b = log_uniform(random, 50.0, 2000.0);
    let limit = 10.0 / log_uniform(random, 1.0, 10.0);
    let delay = random.uniform(0.0, 2.0);
    let bandwidth = log_uniform(random, 10.0, 60.0).min(0.06 / sample_time);
    Axis {
        servo: ServoParameters::new(
            random.uniform(0.0, 5.0),
            b,
            b * limit * random.uniform(0.0, 0.2),
            b * limit * random.uniform(-0.3, 0.3),
        ),
        counts_per_rev: random.one_of(&[1000.0, 4096.0, 10_000.0, 65_536.0, 131_072.0]),
        sample_time,
        limit,
        delay,
        bandwidth,
    }
}

/// Runs of a second: the alarms among those that are drawn so.
fn alarms<'f>(seed: u64, draw: impl Fn(&mut SplitMix64, Axis) -> (Run<'f>, Vec<InjectedFault>)) {
    const RUNS: usize = 2000;
    let mut random = SplitMix64::new(seed);
    let (mut samples, mut alarms) = (0, Vec::new());
    for _ in 0..RUNS {
        let axis = axis(&mut random);
        let (run, faults) = draw(&mut random, axis);
        let run = Run {
            faults: &faults,
            amplitude: log_uniform(&mut random, 0.02, 0.4).max(30.0 * run.axis.units()),
            ..run
        };
        samples += (run.duration / run.axis.sample_time) as u64;
        if let Some(found) = run.run() {
            alarms.push(format!("{found:?} {run:?}"));
        }
    }
    assert!(samples > 1_000_000, "{samples}");
    let count = alarms.len();
    assert!(alarms.is_empty(), "{count} of {RUNS}: {alarms:#?}");
}

/// The servo as it is known in a share of the runs.
fn known(random: &mut SplitMix64, share: f64, factors: [f64; 3]) -> Knowledge {
    if random.uniform(0.0, 1.0) < share {
        Knowledge::Model(factors)
    } else {
        Knowledge::Nothing
    }
}

#[test]
fn a_sound_servo_raises_no_alarm() {
    alarms(3, |random, mut axis| {
        let drive = random.one_of(&[Drive::Probing, Drive::Steps, Drive::Shake, Drive::Hold]);
        // Until the first command acts a load would move the servo, and no ramp has.
        if drive == Drive::Probing && random.uniform(0.0, 1.0) < 0.5 {
            axis.delay = 0.0;
        } else if drive == Drive::Probing {
            axis.servo.load = 0.0;
        }
        let factors = core::array::from_fn(|_| random.uniform(0.9, 1.1));
        let knowledge = known(random, 0.7, factors);
        let step = 0.3 * axis.servo.b * axis.limit;
        let mut faults = vec![InjectedFault {
            kind: FaultKind::LoadStep,
            // Not with a step of the setpoint: a load that holds the servo in that very moment cannot be
            // distinguished from an actuator that fails then.
            time: STEP * random.one_of(&[0.0, 1.0, 2.0, 3.0]) + random.uniform(0.05, 0.2),
            duration: f64::INFINITY,
            size: random.uniform(-step, step),
        }];
        // A relay has no answer to a load: it is not stepped there.
        if drive == Drive::Probing {
            faults.clear();
        }
        (Run::new(axis, drive, knowledge, &[]), faults)
    });
}

#[test]
fn a_sound_servo_in_rough_operation_raises_no_alarm() {
    alarms(5, |random, mut axis| {
        // The rates of a drive.
        axis.sample_time = axis.sample_time.min(1e-3);
        // Its payload weighs up to twice the rest, or was there when it was identified.
        let range = log_uniform(random, 0.45, 2.2);
        let drive = random.one_of(&[Drive::Steps, Drive::Shake, Drive::Hold]);
        axis.servo.load *= 0.5;
        let authority = axis.servo.b * axis.limit;
        let half_cycle = [
            authority * random.uniform(0.0, 0.3),
            log_uniform(random, 0.3, 8.0),
        ];
        let knowledge = known(random, 0.8, [1.0, range, range]);
        let mut run = Run::new(axis, drive, knowledge, &[]);
        run.settings.used_for = Use::Operation;
        run.half_cycle = half_cycle;
        (run, Vec::new())
    });
}
