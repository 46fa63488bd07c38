//! Sound axes at every rate, half of them with a step of the load at a random moment: none is said to have a fault of its
//! encoder or its actuator. The same axes with an encoder that sticks before the trial: found in time.
//!
//! `AXES=600 SEED=7 cargo test -p commissioning --test commission sound_axes -- --ignored --nocapture`

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use commissioning::{CommissionSettings, HoldingGains, Limits, Phase};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use identifier_core::settings::ControllerSettings;
use virtual_servo::faults::{FaultKind, InjectedFault};
use virtual_servo::{Effects, SplitMix64};

use crate::rig::{Bench, ordinary};
use crate::suspected_fault::stuck;

const RATES: [f64; 5] = [250.0, 1e3, 4e3, 10e3, 20e3];
const LIMIT: f64 = 10.0;
const WEAKEST: f64 = 50.0;

/// An axis of b over 100:1, as far as its command does not change its speed by more than 15 % in a sample. Friction is up to
/// 20 % of the limit and half as much more at low speed, the load up to 30 %; 1000 to 131 072 counts, a delay of up to two
/// samples; half of them with soft gains.
fn axis(place: usize, random: &mut SplitMix64) -> Bench {
    let sample_time = 1.0 / RATES[place % RATES.len()];
    let strongest = (100.0 * WEAKEST).min((0.03 / sample_time).powi(2));
    let b = WEAKEST * (strongest / WEAKEST).powf(random.next_uniform());
    let authority = b * LIMIT;
    let coulomb = authority * random.uniform(0.0, 0.2);
    let counts = (1000.0 * 131.072_f64.powf(random.next_uniform())).round();
    let scale = (b / WEAKEST).sqrt();
    let (travel, speed) = (0.16 * scale, 15.0 * scale);
    let delay = sample_time * random.uniform(0.0, 2.0);
    let omega = (0.02 / sample_time).min(40.0);
    let before = HoldingGains {
        controller: ControllerSettings::pid(
            1.4 * omega * omega / b,
            2.2 * omega / b,
            0.2 * omega * omega * omega / b,
        )
        .limited(LIMIT),
        cutoff: 8.0 * omega,
    };
    Bench {
        servo: ServoParameters::new(
            b * random.uniform(0.0, 8e-3),
            b,
            coulomb,
            authority * random.uniform(-0.3, 0.3),
        ),
        effects: Effects {
            delay,
            low_speed_friction: coulomb * random.uniform(0.0, 0.5),
            low_speed_velocity: 0.01 * speed,
            ..Effects::NONE
        },
        counts,
        offset: random.next_uniform(),
        settings: CommissionSettings {
            command_delay: delay,
            ..CommissionSettings::new(
                sample_time,
                TAU / counts,
                Limits::new([-travel, travel], speed, [-LIMIT, LIMIT]),
            )
        },
        before: (random.next_uniform() < 0.5).then_some(before),
        ..ordinary()
    }
}

fn asked(name: &str, usual: u64) -> u64 {
    let given = std::env::var(name).ok();
    given.and_then(|text| text.parse().ok()).unwrap_or(usual)
}

#[test]
#[ignore = "campaign: minutes, AXES=600 cargo test -p commissioning --test commission sound_axes -- --ignored --nocapture"]
fn sound_axes_are_not_lost() {
    let axes = asked("AXES", 100);
    let mut random = SplitMix64::new(asked("SEED", 29));
    let mut tally: BTreeMap<(u64, bool), [u64; 3]> = BTreeMap::new();
    let mut found = Vec::new();
    for place in 0..axes as usize {
        let bench = axis(place, &mut random);
        let [time, size] = [0.3, 3.0].map(|most| random.uniform(0.1 * most, most));
        let size = if random.next_uniform() < 0.5 {
            size
        } else {
            -size
        };
        let step = InjectedFault::lasting(
            FaultKind::LoadStep,
            10.0 * time,
            0.1 * LIMIT * size * bench.servo.b,
        );
        let is_stepped = place / RATES.len() % 2 == 1;
        let faults: &[InjectedFault] = if is_stepped { &[step] } else { &[] };
        let course = bench.run(faults, &mut |_| None);
        let reason = course.state.reason();
        let names = [Reason::EncoderStuck, Reason::ActuatorDead];
        let is_lost = reason.is_some_and(|reason| names.contains(&reason));
        let is_applied = course.state.phase() == Phase::Applied;
        if !is_applied {
            println!("{place} {reason:?} {:?}", course.phases.iter().rev().nth(1));
        }
        let rate = (1.0 / bench.settings.sample_time).round() as u64;
        let [all, applied, lost] = tally.entry((rate, is_stepped)).or_default();
        *all += 1;
        *applied += u64::from(is_applied);
        *lost += u64::from(is_lost);
        if !is_stepped && let Some(trial) = course.began(Phase::Trial) {
            let stuck = stuck(&bench, trial - 0.02);
            if let Some(least) = stuck.least_motion {
                found.push(stuck.ended - least);
            }
        }
    }
    println!("{tally:?} all, applied, lost");
    found.sort_by(f64::total_cmp);
    println!("beyond the least motion, s: {found:?}");
    assert!(tally.values().all(|[_, _, lost]| *lost == 0));
    // Where a command grows slowly, the errors of friction and load are a long time.
    let in_time = found.iter().filter(|&&beyond| beyond <= 0.02).count();
    assert!(
        10 * in_time >= 9 * found.len(),
        "{in_time} of {}",
        found.len()
    );
}
