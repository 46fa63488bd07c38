//! How far axes leave the speed and the travel of their commissioning, by their true motion up to its end.
//!
//! `AXES=300 SEED=7 cargo test -p commissioning --test commission limits -- --ignored --nocapture` for so many rigid axes and
//! axes of two masses, `DETAIL=1` for a line each of those that go beyond.

use std::f64::consts::TAU;

use commissioning::{CommissionError, HoldingGains, Phase, SynchronousCommission};
use identifier_core::error::Allowed;
use identifier_core::settings::ControllerSettings;
use virtual_servo::{Effects, SplitMix64};

use super::rig::{Background, Bench, ordinary};
use super::two_masses::{Judged, judge, log_uniform, two_masses};

/// A speed of so much of the limit, and a travel of so much, are beyond it.
const BEYOND: [f64; 2] = [1.1, 1.02];

/// Kinds of axes, the part of the asked number that is drawn, and the largest part that may go beyond of those whose motor
/// alone changes its speed by at most [`SEEN`] of the limit in a sample.
const KINDS: [(&str, f64, f64); 6] = [
    ("rigid", 1.0, 0.01),
    ("two masses", 1.0, 0.015),
    ("compliant", 0.8, 0.01),
    ("gravity", 1.0 / 3.0, 0.015),
    ("cogging", 1.0 / 3.0, 0.015),
    ("Stribeck", 1.0 / 3.0, 0.015),
];

/// The change of the motor's speed in a sample by all of the command, over the limit, up to which counts can warn.
const SEEN: f64 = 0.15;

/// Part of all axes that may go beyond.
const OF_ALL: f64 = 0.025;

/// An axis of a kind: as one of two masses but for its effects. It has 1000 counts and more, and from 0.1 rad of travel on if
/// it is rigid. Every second one is held by soft gains.
fn axis(kind: &str, seed: u64) -> Bench {
    let mut random = SplitMix64::new(seed ^ 0x6c69_6d69_7473);
    let random = &mut random;
    let mut bench = two_masses(seed);
    let command = bench.settings.limits.command[1];
    let authority = bench.servo.b * command;
    let held = random.next_uniform() < 0.5;
    if kind == "compliant" {
        // A part of its friction is on the load.
        let behind = bench.servo.coulomb * random.uniform(0.1, 0.9);
        bench.effects.load_friction = behind;
        bench.servo.coulomb -= behind;
    } else if kind != "two masses" {
        let counts = log_uniform(random, 1000.0, 131_072.0).round();
        bench.set_counts(counts);
        let travel = log_uniform(random, 0.1, 2.0);
        let limits = &mut bench.settings.limits;
        limits.travel = [-travel, travel];
        limits.speed = (authority * travel * log_uniform(random, 0.03, 1.0)).sqrt();
        limits.duration = 1.0;
        bench.servo.coulomb = authority * random.uniform(0.0, 0.2);
        bench.servo.load = authority * random.uniform(-0.3, 0.3);
        let (sine, cosine) = random.uniform(0.0, TAU).sin_cos();
        let wave = |part: f64| [part * authority * sine, part * authority * cosine];
        let rigid = Effects {
            delay: bench.effects.delay,
            current_loop: bench.effects.current_loop,
            ..Effects::NONE
        };
        bench.effects = match kind {
            "gravity" => Effects {
                gravity: wave(random.uniform(0.05, 0.25)),
                ..rigid
            },
            "cogging" => Effects {
                ripple: wave(random.uniform(0.02, 0.12)),
                ripple_order: log_uniform(random, 6.0, 84.0).round() as u32,
                ..rigid
            },
            "Stribeck" => Effects {
                low_speed_friction: bench.servo.coulomb * random.uniform(0.3, 1.5),
                low_speed_velocity: log_uniform(random, 0.05, 2.0),
                ..rigid
            },
            _ => rigid,
        };
    }
    let omega = (0.02 / bench.settings.sample_time).min(40.0);
    let gains = [
        1.4 * omega * omega / bench.servo.b,
        2.2 * omega / bench.servo.b,
        0.2 * omega * omega * omega / bench.servo.b,
    ];
    let before = HoldingGains {
        controller: ControllerSettings::pid(gains[0], gains[1], gains[2]).limited(command),
        cutoff: 8.0 * omega,
    };
    let is_at_rest = !matches!(kind, "gravity" | "cogging");
    bench.before = (held && is_at_rest).then_some(before);
    bench.background = Background::Busy(seed);
    if random.next_uniform() < 0.3 {
        state_gain(&mut bench, random.uniform(1.0, 3.0));
    }
    bench
}

/// States a largest gain, a multiple of the motor's alone, and allows the command that goes with it, if that holds an axis
/// that coasts.
fn state_gain(bench: &mut Bench, multiple: f64) {
    let gain = multiple * bench.servo.b / (1.0 - bench.effects.inertia_ratio);
    let limits = &mut bench.settings.limits;
    let most = 0.999 * SEEN * limits.speed / (gain * bench.settings.sample_time);
    let command = most.min(limits.command[1]);
    let gravity = bench.effects.gravity[0].hypot(bench.effects.gravity[1]);
    let held = (bench.servo.load.abs() + gravity) / bench.servo.b;
    if bench.before.is_some() || held < 0.8 * command {
        bench.settings.max_gain = Some(gain);
        limits.command = [-command, command];
    }
}

/// The change of the motor's speed in a sample by all of the command, over the limit.
fn change(bench: &Bench) -> f64 {
    let settings = &bench.settings;
    let motor = bench.servo.b / (1.0 - bench.effects.inertia_ratio);
    motor * settings.limits.command[1] * settings.sample_time / settings.limits.speed
}

fn is_beyond(judged: &Judged) -> [bool; 2] {
    [0, 1].map(|which| judged.reached[which] > BEYOND[which])
}

fn asked<T: std::str::FromStr>(name: &str, usual: T) -> T {
    let given = std::env::var(name).ok();
    given.and_then(|text| text.parse().ok()).unwrap_or(usual)
}

#[test]
fn an_order_that_hardly_holds_the_load_is_refused_with_the_command_that_would_do() {
    let settings = ordinary().settings;
    for (held, needed) in [
        (9.0, Some(11.25)),
        (-8.4, Some(-10.5)),
        (7.9, None),
        (-7.9, None),
    ] {
        let refused = SynchronousCommission::<f32>::new(&settings, None, Some(held)).err();
        let allowed = match refused {
            Some(CommissionError::Range(refused)) => Some(refused.allowed),
            _ => None,
        };
        let expected = needed.map(|needed: f64| match needed > 0.0 {
            true => Allowed::AtLeast(needed),
            false => Allowed::AtMost(needed),
        });
        assert_eq!(allowed, expected, "{held}");
    }
}

#[test]
#[ignore = "campaign: minutes, AXES=300 SEED=n"]
fn axes_stay_within_speed_and_travel() {
    let (axes, seed) = (asked("AXES", 60.0), asked("SEED", 1_u64));
    let only: String = asked("KIND", String::new());
    let mut failed = Vec::new();
    let (mut drawn, mut beyond_at_all) = (0, 0);
    for (place, &(kind, part, allowed)) in KINDS.iter().enumerate() {
        if !kind.starts_with(&only) {
            continue;
        }
        let first = 1_000_000 * seed + 100_000 * place as u64;
        let last = first + (axes * part).ceil() as u64;
        // An order that hardly holds the load is refused.
        let benches: Vec<(u64, Bench)> = (first..last)
            .map(|seed| (seed, axis(kind, seed)))
            .filter(|(_, bench)| {
                let held = bench.before.map(|_| -bench.servo.load / bench.servo.b);
                bench.settings.check_held(held.unwrap_or(0.0)).is_ok()
            })
            .collect();
        let half = benches.len().div_ceil(2);
        let judged: Vec<Judged> = std::thread::scope(|scope| {
            let workers: Vec<_> = benches
                .chunks(half)
                .map(|part| {
                    scope.spawn(|| {
                        part.iter()
                            .map(|(_, bench)| judge(bench))
                            .collect::<Vec<_>>()
                    })
                })
                .collect();
            let ended = workers.into_iter().map(|worker| worker.join());
            ended.flat_map(|judged| judged.expect("no panic")).collect()
        });
        let count = |is: &dyn Fn(&Bench, &Judged) -> bool| {
            let all = benches.iter().zip(&judged);
            all.filter(|((_, bench), judged)| is(bench, judged)).count()
        };
        let is_seen = |bench: &Bench| change(bench) <= SEEN;
        let left = |judged: &Judged| is_beyond(judged).contains(&true);
        let applied = count(&|_, judged| judged.phase == Phase::Applied);
        let seen = count(&|bench, _| is_seen(bench));
        let beyond_seen = count(&|bench, judged| is_seen(bench) && left(judged));
        let beyond = count(&|_, judged| left(judged));
        let over = |limit: f64| {
            count(&|_, judged| {
                judged
                    .sensitivity
                    .is_some_and(|sensitivity| sensitivity > limit)
            })
        };
        let (unstable, exceeding) = (over(1e6), over(1.8));
        let mut times: Vec<f64> = (judged.iter())
            .filter(|judged| judged.phase == Phase::Applied)
            .map(|judged| judged.time)
            .collect();
        times.sort_by(f64::total_cmp);
        println!(
            "{kind:<11}{:>4} axes of {}, {applied:>4} applied; beyond: speed {:>3}, travel {:>3}, of {seen:>3} seen {beyond_seen:>3}; \
             {unstable} unstable, {exceeding} with Ms > 1.8; {:.2} s median",
            benches.len(),
            last - first,
            count(&|_, judged| is_beyond(judged)[0]),
            count(&|_, judged| is_beyond(judged)[1]),
            times.get(times.len() / 2).copied().unwrap_or(0.0),
        );
        for ((seed, bench), judged) in benches.iter().zip(&judged) {
            if asked("DETAIL", 0) > 0 && left(judged) {
                println!(
                    "  {seed}: change {:.3}, speed {:.2}, travel {:.2}, {} {} {:.3} s",
                    change(bench),
                    judged.reached[0],
                    judged.reached[1],
                    judged.phase.name(),
                    judged.reason,
                    judged.time,
                );
            }
        }
        drawn += benches.len();
        beyond_at_all += beyond;
        if beyond_seen as f64 > allowed * seen as f64 || unstable > 0 {
            failed.push(kind);
        }
    }
    println!("{beyond_at_all} of {drawn} beyond");
    assert!(failed.is_empty(), "{failed:?}");
    assert!(beyond_at_all as f64 <= OF_ALL * drawn as f64);
}
