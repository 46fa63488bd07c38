//! Faults whose detection needs no servo: found in the stated sample, and not in the one before.

use std::string::ToString;
use std::vec::Vec;

use crate::watch::{DetectionTimes, KnownServo, Observation, ServoWatch, Use, WatchSettings};
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;

const RATES: [f64; 5] = [250.0, 1e3, 4e3, 10e3, 20e3];

fn settings(rate: f64) -> WatchSettings {
    WatchSettings {
        sample_time: 1.0 / rate,
        resolution: 1e-3,
        travel: [-0.5, 2.0],
        speed: 30.0,
        command: [-8.0, 8.0],
        used_for: Use::Commissioning,
    }
}

fn prepared<N: Number>(settings: &WatchSettings, servo: &IdentifiedServo) -> KnownServo<N> {
    KnownServo::from_identified(settings, servo).expect("it has a gain")
}

/// A servo at rest at its setpoint.
const REST: Observation<f64> = Observation {
    increment: Some(0.0),
    command: 0.0,
    position: 0.0,
    setpoint: Some(0.0),
    late: false,
    must_move: false,
    excited: false,
};

/// The fault found in a sequence of samples that repeats from its beginning, and its sample, from 1.
fn found(
    settings: &WatchSettings,
    seen: impl Fn(u32) -> Observation<f64>,
) -> (Option<(Reason, u32)>, DetectionTimes) {
    let watch = ServoWatch::<f64>::new(settings).expect("allowed");
    let mut state = watch.start();
    let stated = watch.detection_times(&state);
    let samples = (2.0 / settings.sample_time) as u32;
    let found = (0..samples).find_map(|sample| {
        let refused = watch.process(&mut state, &seen(sample)).err();
        refused.map(|reason| (reason, sample + 1))
    });
    (found, stated)
}

#[test]
fn an_encoder_without_a_reading_is_lost_after_the_stated_samples() {
    for rate in RATES {
        let settings = settings(rate);
        let lost = Observation {
            increment: None,
            ..REST
        };
        let (seen, stated) = found(&settings, |_| lost);
        assert_eq!(seen, Some((Reason::EncoderLost, stated.encoder_lost)));
        assert_eq!(stated.encoder_lost, (rate * 1e-3).round().max(2.0) as u32);
        let every = stated.encoder_lost;
        let (seen, _) = found(&settings, |k| if k % every == 0 { REST } else { lost });
        assert_eq!(seen, None, "one reading in time is enough");
    }
}

#[test]
fn samples_that_are_late_running_or_mostly_are_an_overrun() {
    let settings = settings(1e3);
    let late = |late| Observation { late, ..REST };
    let (seen, stated) = found(&settings, |_| late(true));
    assert_eq!(seen, Some((Reason::Overrun, stated.overrun)));
    assert_eq!(stated.overrun, 3);
    let (seen, _) = found(&settings, |k| late(k % 2 == 0));
    assert_eq!(seen, Some((Reason::Overrun, 7)), "every other one");
    let (seen, _) = found(&settings, |k| late(k % 5 == 0));
    assert_eq!(seen, None, "every fifth one");
}

#[test]
fn a_travel_limit_trips_one_count_beyond_its_figure() {
    let settings = settings(1e3);
    for (position, within) in [
        (2001.0, true),
        (2002.0, false),
        (-501.0, true),
        (-502.0, false),
    ] {
        let (seen, _) = found(&settings, |_| Observation { position, ..REST });
        let expected = (!within).then_some((Reason::TravelLeft, 1));
        assert_eq!(seen, expected, "{position}");
    }
}

/// Counts of a servo at a speed, as they come.
fn at_speed(speed: f64, settings: &WatchSettings, sample: u32) -> Observation<f64> {
    let step = speed * settings.sample_time / settings.resolution;
    let count = |sample: u32| (f64::from(sample) * step + 0.37).floor();
    let increment = count(sample + 1) - count(sample);
    Observation {
        increment: Some(increment),
        setpoint: None,
        ..REST
    }
}

#[test]
fn a_speed_is_found_in_its_time_beyond_the_limit_and_never_at_it() {
    for rate in RATES {
        for resolution in [1e-2, 1e-3, 1e-5] {
            let settings = WatchSettings {
                resolution,
                ..settings(rate)
            };
            for sign in [1.0, -1.0] {
                let (seen, _) = found(&settings, |k| at_speed(sign * 30.0, &settings, k));
                assert_eq!(seen, None, "{rate} {resolution}");
                // Three counts in 20 ms, the longest time that a speed is the mean of.
                let fast = sign * (1.25 * 30.0 + 3.0 * resolution / 2e-3);
                let (seen, stated) = found(&settings, |k| at_speed(fast, &settings, k));
                let (reason, sample) = seen.expect("it is too fast");
                assert_eq!(reason, Reason::SpeedExceeded);
                assert!(sample <= stated.speed, "{sample} {stated:?}");
            }
        }
    }
}

#[test]
fn a_jump_is_found_in_its_sample_and_a_smaller_one_is_motion() {
    for rate in RATES {
        let settings = settings(rate);
        let watch = ServoWatch::<f64>::new(&settings).expect("allowed");
        let mut state = watch.start();
        for known in [false, true] {
            if known {
                watch.know(&mut state, &prepared(&settings, &SERVO));
            }
            let least = watch.detection_times(&state).smallest_jump;
            for jump in [least, -least, f64::NAN] {
                let mut state = state;
                watch.process(&mut state, &REST).expect("it rests");
                let jumps = Observation {
                    increment: Some(jump),
                    ..REST
                };
                let seen = watch.process(&mut state, &jumps);
                assert_eq!(seen, Err(Reason::EncoderJumped), "{rate} {jump}");
            }
            let mut state = state;
            watch.process(&mut state, &REST).expect("it rests");
            let moves = Observation {
                increment: Some((0.3 * least).floor()),
                ..REST
            };
            assert_ne!(
                watch.process(&mut state, &moves),
                Err(Reason::EncoderJumped)
            );
        }
    }
}

/// A motor that oscillates ever faster on its spring is too fast, and its encoder is right. One that jumps as well is not.
#[test]
fn oscillates_that_grow_are_no_jump_and_a_jump_amid_oscillates_is_one() {
    for rate in RATES {
        let settings = settings(rate);
        let watch = ServoWatch::<f64>::new(&settings).expect("allowed");
        let far = watch.detection_times(&watch.start()).smallest_jump;
        let oscillating = |k: u32, size: f64, growth: f64| Observation {
            increment: Some((size * growth.powi(k as i32) * f64::from(k).sin()).round()),
            command: 1.0,
            setpoint: None,
            ..REST
        };
        let (seen, _) = found(&settings, |k| oscillating(k, 0.01 * far, 1.3));
        let (reason, _) = seen.expect("it is too fast");
        assert_eq!(reason, Reason::SpeedExceeded, "{rate}");
        let (seen, _) = found(&settings, |k| match oscillating(k, 0.1 * far, 1.0) {
            half_cycles if k == 100 => Observation {
                increment: half_cycles.increment.map(|small| small + 1.2 * far),
                ..half_cycles
            },
            half_cycles => half_cycles,
        });
        assert_eq!(seen, Some((Reason::EncoderJumped, 101)), "{rate}");
    }
}

const SERVO: IdentifiedServo = IdentifiedServo {
    unexplained: 3e-4,
    ..IdentifiedServo::known(ServoParameters::new(1.0, 200.0, 20.0, 10.0), 0.0)
};

/// A loop that oscillates about its setpoint with this amplitude in counts, growing by a factor from half-cycle to
/// half-cycle, and a command with it; half of a half-cycle takes 20 ms.
fn oscillating(amplitude: f64, growth: f64, command: f64, sample: u32) -> Observation<f64> {
    let phase = f64::from(sample) * 1e-3 / 20e-3;
    let size = amplitude * growth.powf(phase);
    let (sine, _) = (phase * core::f64::consts::PI).sin_cos();
    let before = ((phase - 0.05) * core::f64::consts::PI).sin();
    Observation {
        increment: Some((size * (sine - before)).round()),
        position: (size * sine).round(),
        command: -command * sine,
        ..REST
    }
}

#[test]
fn six_half_cycles_that_do_not_decay_are_an_oscillation() {
    let settings = WatchSettings {
        travel: [f64::NEG_INFINITY, f64::INFINITY],
        speed: f64::INFINITY,
        ..settings(1e3)
    };
    let watch = ServoWatch::<f64>::new(&settings).expect("allowed");
    let stated = watch.detection_times(&watch.start());
    for growth in [0.9, 1.0, 1.2] {
        let (seen, _) = found(&settings, |k| oscillating(40.0, growth, 3.0, k));
        let (reason, sample) = seen.expect("it oscillates");
        assert_eq!(reason, Reason::Oscillating);
        // The half-cycle in which it begins is not a whole one.
        assert!(sample <= (stated.half_cycles + 1) * 20 + 10, "{sample}");
    }
    for (amplitude, growth, command) in [(4000.0, 0.6, 3.0), (3.0, 1.0, 3.0), (40.0, 1.0, 0.3)] {
        let (seen, _) = found(&settings, |k| oscillating(amplitude, growth, command, k));
        assert_eq!(seen, None, "{amplitude} {growth} {command}");
    }
    // The same half-cycles are the setpoint's own where it makes them, or a relay's.
    let of_setpoint = |k| Some(if (k / 20) % 2 == 0 { 90.0 } else { -90.0 });
    for setpoint in [of_setpoint, |_| None] {
        let (seen, _) = found(&settings, |k| Observation {
            setpoint: setpoint(k),
            ..oscillating(40.0, 1.0, 3.0, k)
        });
        assert_eq!(seen, None);
    }
}

#[test]
fn contradictory_settings_are_refused_by_name() {
    type Change = fn(&mut WatchSettings);
    let rows: [(&str, Change); 8] = [
        ("travel", |s| s.travel = [0.1, 1.0]),
        ("travel", |s| s.travel = [-1.0, -0.1]),
        ("travel", |s| s.travel = [f64::NAN, 1.0]),
        ("speed", |s| s.speed = 0.0),
        ("speed", |s| s.speed = f64::NAN),
        ("command", |s| s.command = [0.0, 1.0]),
        ("command", |s| s.command = [-1.0, f64::INFINITY]),
        ("sample_time", |s| s.sample_time = 0.0),
    ];
    for (name, change) in rows {
        let mut settings = settings(1e3);
        change(&mut settings);
        let refused = ServoWatch::<f32>::new(&settings).expect_err("it is refused");
        assert_eq!(refused.parameter, name);
    }
}

#[test]
fn the_page_has_the_figures_of_the_code() {
    let page = include_str!("../../../../../docs/faults.md");
    let row = |name: &str, known: bool, samples: fn(&DetectionTimes) -> u32| {
        let columns: Vec<_> = RATES
            .map(|rate| {
                let watch = ServoWatch::<f32>::new(&settings(rate)).expect("allowed");
                let mut state = watch.start();
                if known {
                    watch.know(&mut state, &prepared(&settings(rate), &STRONG));
                }
                samples(&watch.detection_times(&state)).to_string()
            })
            .into();
        format!("| {name} | {} |", columns.join(" | "))
    };
    let of = |detection: &DetectionTimes, reason| detection.samples(reason).expect("it is found");
    for row in [
        row("encoder lost", false, |stated| stated.encoder_lost),
        row("overrun", false, |stated| stated.overrun),
        row("reversed, weak", false, |stated| stated.response),
        row("no motion, unknown servo", false, |stated| stated.standing),
        row("no motion, known servo, at least", true, |stated| {
            stated.standing
        }),
    ] {
        assert!(page.contains(&row), "the page lacks: {row}");
    }
    let watch = ServoWatch::<f32>::new(&settings(1e3)).expect("allowed");
    let stated = watch.detection_times(&watch.start());
    assert_eq!(of(&stated, Reason::Reversed), stated.response);
    assert_eq!(
        of(&stated, Reason::ActuatorDead),
        stated.response + stated.standing
    );
    assert_eq!(of(&stated, Reason::TravelLeft), 1);
    assert_eq!(stated.samples(Reason::NoGains), None);
}

/// One that a twentieth of the command moves at once.
const STRONG: IdentifiedServo = IdentifiedServo {
    parameters: ServoParameters {
        b: 5000.0,
        ..SERVO.parameters
    },
    ..SERVO
};

/// The fault found in a known servo that glides at 16 rad/s until its encoder fails after half a second, and
/// the number of samples from that failure.
fn gliding(rate: f64, fails: impl Fn(f64) -> f64) -> Option<(Reason, u32)> {
    let settings = settings(rate);
    let settings = WatchSettings {
        travel: [f64::NEG_INFINITY, f64::INFINITY],
        ..settings
    };
    let watch = ServoWatch::<f64>::new(&settings).expect("allowed");
    let mut state = watch.start();
    watch.know(&mut state, &prepared(&settings, &SERVO));
    let ServoParameters {
        a,
        b,
        coulomb,
        load,
    } = SERVO.parameters;
    let begins = (0.5 * rate) as u32;
    let found = (0..2 * begins).find_map(|sample| {
        let glides = at_speed(16.0, &settings, sample);
        let seen = Observation {
            increment: glides.increment.map(|increment| {
                if sample < begins {
                    increment
                } else {
                    fails(increment)
                }
            }),
            command: (a * 16.0 + coulomb - load) / b,
            ..glides
        };
        let refused = watch.process(&mut state, &seen).err();
        refused.map(|reason| (reason, sample + 1))
    });
    found.map(|(reason, sample)| {
        assert!(sample > begins, "{reason:?} too early: {sample}");
        (reason, sample - begins)
    })
}

#[test]
fn an_encoder_that_stops_or_turns_in_motion_is_found_in_a_sample_or_three_blocks() {
    for rate in RATES {
        // With many counts per sample the first shows it, otherwise the blocks of 2.5 ms.
        let within = if rate < 1e3 {
            1
        } else {
            (7.5e-3 * rate).max(18.0) as u32
        };
        for (expected, turn) in [(Reason::EncoderStuck, 0.0), (Reason::Reversed, -1.0)] {
            let (reason, samples) = gliding(rate, |increment| turn * increment).expect("it fails");
            assert_eq!(reason, expected, "{rate}");
            assert!(samples <= within, "{rate} {expected:?}: {samples}");
        }
        assert_eq!(gliding(rate, |increment| increment), None);
    }
}
