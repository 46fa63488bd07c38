//! No false alarm.

use std::vec::Vec;

use crate::parameters::ServoParameters;
use virtual_servo::faults::{FaultKind, InjectedFault};

use super::support::{Axis, Drive, Knowledge, Run, STEP};

/// Numbers that look random, the same in every run (SplitMix64; Steele, Lea, Flood 2014).
struct Dice(pub u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }

    fn spread(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.roll())
    }

    fn one_of<T: Copy>(&mut self, from: &[T]) -> T {
        from[(self.roll() * from.len() as f64) as usize]
    }
}

fn axis(dice: &mut Dice) -> Axis {
    let sample_time = 1.0 / dice.one_of(&[250.0, 1e3, 4e3, 10e3, 20e3]);
    let b = dice.spread(50.0, 2000.0);
    let limit = 10.0 / dice.spread(1.0, 10.0);
    let delay = dice.between(0.0, 2.0);
    let bandwidth = dice.spread(10.0, 60.0).min(0.06 / sample_time);
    Axis {
        servo: ServoParameters {
            a: dice.between(0.0, 5.0),
            b,
            coulomb: b * limit * dice.between(0.0, 0.2),
            load: b * limit * dice.between(-0.3, 0.3),
        },
        counts_per_rev: dice.one_of(&[1000.0, 4096.0, 10_000.0, 65_536.0, 131_072.0]),
        sample_time,
        limit,
        delay,
        bandwidth,
    }
}

/// Runs of a second.
const RUNS: usize = 2000;

#[test]
fn a_sound_servo_raises_no_alarm() {
    let mut dice = Dice(3);
    let (mut samples, mut alarms) = (0, Vec::new());
    for _ in 0..RUNS {
        let mut axis = axis(&mut dice);
        let drive = dice.one_of(&[Drive::Probing, Drive::Steps, Drive::Shake, Drive::Hold]);
        // Until the first command acts a load would move the servo, and no ramp has.
        if drive == Drive::Probing && dice.between(0.0, 1.0) < 0.5 {
            axis.delay = 0.0;
        } else if drive == Drive::Probing {
            axis.servo.load = 0.0;
        }
        let error = |dice: &mut Dice| dice.between(0.9, 1.1);
        let factors = [error(&mut dice), error(&mut dice), error(&mut dice)];
        let known = dice.between(0.0, 1.0) < 0.7;
        let step = 0.3 * axis.servo.b * axis.limit;
        let faults = [InjectedFault {
            kind: FaultKind::LoadStep,
            // Not with a step of the setpoint: a load that holds the servo in that very moment cannot be
            // distinguished from an actuator that fails then.
            time: STEP * dice.one_of(&[0.0, 1.0, 2.0, 3.0]) + dice.between(0.05, 0.2),
            duration: f64::INFINITY,
            size: dice.between(-step, step),
        }];
        // A relay has no answer to a load: it is not stepped there.
        let faults = if drive == Drive::Probing {
            &[][..]
        } else {
            &faults
        };
        let run = Run {
            amplitude: dice.spread(0.02, 0.4).max(30.0 * axis.units()),
            ..Run::new(
                axis,
                drive,
                if known {
                    Knowledge::Model(factors)
                } else {
                    Knowledge::Nothing
                },
                faults,
            )
        };
        samples += (run.duration / axis.sample_time) as u64;
        if let Some(found) = run.run() {
            alarms.push(format!("{found:?} {run:?}"));
        }
    }
    assert!(samples > 1_000_000, "{samples}");
    assert!(
        alarms.is_empty(),
        "{} of {RUNS}: {:#?}",
        alarms.len(),
        alarms
    );
}
