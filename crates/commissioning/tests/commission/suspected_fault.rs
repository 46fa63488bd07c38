//! Faults that a sound axis may seem to have: it is not let go for them, and a true one ends in time.
//!
//! `INSTANTS=160 cargo test -p commissioning --test commission suspected -- --nocapture` for more instants.

use std::f64::consts::{PI, TAU};

use commissioning::{CommissionSettings, HoldingGains, LargestMotion, Limits, Phase};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use identifier_core::settings::ControllerSettings;
use virtual_servo::Effects;
use virtual_servo::faults::{FaultKind, InjectedFault};

use crate::machine::before;
use crate::rig::{Background, Bench, Course, ordinary};

/// An axis that all of its command takes through its travel in 9 ms, held by soft gains.
fn strong() -> Bench {
    let counts = 6632.0;
    Bench {
        servo: ServoParameters::new(0.1725, 98_097.0, 20_469.0, -14_431.0),
        effects: Effects {
            current_loop: 1.087e-4,
            ..Effects::NONE
        },
        counts,
        offset: 0.4,
        noise: 0.0,
        settings: CommissionSettings::new(
            2.5e-4,
            TAU / counts,
            Limits {
                duration: 3.0,
                ..Limits::new([-PI, PI], 200.0, [-1.0, 1.0])
            },
        ),
        before: Some(HoldingGains {
            controller: ControllerSettings::pid(0.02283, 0.000_897, 0.1305).limited(1.0),
            cutoff: 320.0,
        }),
        background: Background::Usual,
    }
}

/// An axis that holds a part of its command against its load, and moves with a little speed.
fn loaded(part: f64) -> Bench {
    let counts = 17_581.0;
    let b = 17_787.0;
    Bench {
        servo: ServoParameters::new(0.4266, b, 4484.0, part * b),
        effects: Effects {
            delay: 2e-4,
            current_loop: 8.78e-5,
            ..Effects::NONE
        },
        counts,
        offset: 0.4,
        noise: 0.0,
        settings: CommissionSettings {
            command_delay: 2e-4,
            ..CommissionSettings::new(
                1e-4,
                TAU / counts,
                Limits {
                    duration: 3.0,
                    ..Limits::new([-PI, PI], 10.0, [-1.0, 1.0])
                },
            )
        },
        before: Some(HoldingGains {
            controller: ControllerSettings::pid(0.1259, 0.004_947, 0.7196).limited(1.0),
            cutoff: 320.0,
        }),
        background: Background::Usual,
    }
}

/// The end of an axis whose encoder sticks at a time, s.
#[derive(Debug)]
pub(crate) struct Stuck {
    reason: Option<Reason>,
    /// From the first sample in which the axis is ordered to move to the end, s, and true if the stage is disabled then.
    pub(crate) ended: f64,
    is_disabled: bool,
    /// The time from there in which half of b would move the axis by 20 counts against twice its friction, s; none if it was
    /// not identified then, or would not.
    pub(crate) least_motion: Option<f64>,
}

/// The time from a sample on in which half of b moves an axis at rest by 20 counts against twice its friction, s.
fn least_motion(bench: &Bench, given: &[f64]) -> Option<f64> {
    let (servo, time) = (&bench.servo, bench.settings.sample_time);
    let friction = 2.0 * servo.coulomb;
    let (mut velocity, mut moved) = (0.0_f64, 0.0_f64);
    let samples = given.iter().position(|command| {
        let force = 0.5 * (servo.b * command + servo.load);
        let direction = if velocity == 0.0 { force } else { velocity };
        let next = velocity + (force - friction.copysign(direction)) * time;
        velocity = if next * direction > 0.0 { next } else { 0.0 };
        moved += velocity * time;
        moved.abs() > 20.0 * bench.settings.resolution
    });
    samples.map(|samples| (samples + 1) as f64 * time)
}

pub(crate) fn stuck(bench: &Bench, time: f64) -> Stuck {
    let fault = InjectedFault::lasting(FaultKind::EncoderStuck, time, 0.0);
    let course = bench.run(&[fault], &mut |_| None);
    let ordered = course.ordered_since(time).unwrap_or(time);
    let known = course.began(Phase::FrequencyResponse);
    let first = (ordered / bench.settings.sample_time).round() as usize;
    let least_motion = known
        .filter(|&known| known <= ordered)
        .and_then(|_| least_motion(bench, &course.given[first..]));
    println!(
        "{time:.4} {:?} {:?} ordered {:.4} ended {:.4} {:?} disabled {:?}",
        course.state.reason(),
        course.travel,
        ordered,
        course.ended().unwrap_or(0.0),
        course.phases.iter().rev().nth(1),
        course.disabled
    );
    Stuck {
        reason: course.state.reason(),
        ended: course
            .ended()
            .map_or(f64::INFINITY, |end| (end - ordered).max(0.0)),
        is_disabled: course.disabled.is_some(),
        least_motion,
    }
}

#[test]
fn a_stuck_encoder_is_found_in_every_phase() {
    let given = std::env::var("INSTANTS").ok();
    let instants: u32 = given.and_then(|text| text.parse().ok()).unwrap_or(16);
    let bench = strong();
    let end = bench.commission(&mut |_| None).ended().expect("it ends");
    let mut times: Vec<f64> = (0..instants)
        .map(|place| {
            let found = stuck(&bench, end * (f64::from(place) + 0.5) / f64::from(instants));
            let names = [Reason::EncoderStuck, Reason::ActuatorDead];
            let is_named = found.reason.is_some_and(|reason| names.contains(&reason));
            // Before the first motion its ramp finds it.
            let is_unmoved = found.reason == Some(Reason::DoesNotMove);
            // The solver may end it at that moment, and the gains before hold it where it stands.
            let is_over = !found.is_disabled && found.ended < 0.03;
            assert!(
                is_named && found.is_disabled || is_unmoved || is_over,
                "{found:?}"
            );
            found.ended
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let (median, longest) = (times[times.len() / 2], times[times.len() - 1]);
    println!("median {median} s, longest {longest} s");
    let rounding = 0.5 * bench.settings.sample_time;
    assert!(
        median <= 0.06 + rounding && longest <= LargestMotion::STUCK_ENCODER_TIME,
        "{median} {longest}"
    );
}

#[test]
fn in_the_trial_half_of_b_tells_that_an_encoder_sticks() {
    let bench = strong();
    let course = bench.commission(&mut |_| None);
    let trial = course.began(Phase::Trial).expect("it is tried");
    for before in [0.2, 0.1, 0.01] {
        let found = stuck(&bench, trial - before);
        let least = found.least_motion.expect("its command suffices");
        assert_eq!(found.reason, Some(Reason::ActuatorDead));
        assert!(
            found.is_disabled && found.ended <= least + 0.005,
            "{found:?}"
        );
    }
}

#[test]
fn an_axis_that_holds_a_heavy_load_is_not_let_go() {
    for part in [0.26, 0.29, 0.298] {
        let course: Course = loaded(part).commission(&mut |_| None);
        let reason = course.state.reason();
        assert_eq!(course.disabled, None, "{part} {reason:?}");
        let doubtful = [Reason::Reversed, Reason::ActuatorDead, Reason::EncoderStuck];
        assert!(
            reason.is_none_or(|reason| !doubtful.contains(&reason)),
            "{part} {reason:?}"
        );
        assert!(
            course.travel[0] > -PI && course.travel[1] < PI,
            "{:?}",
            course.travel
        );
    }
}

#[test]
fn noise_at_rest_is_no_speed() {
    for (time, noise, speed) in [(5e-5, 2.0, 10.0), (1e-4, 5.0, 30.0), (5e-5, 5.0, 10.0)] {
        let counts = 4096.0;
        let limits = Limits::new([-1.0, 1.0], speed, [-10.0, 10.0]);
        let bench = Bench {
            servo: ServoParameters::new(1.0, 300.0, 50.0, 0.0),
            counts,
            noise,
            settings: CommissionSettings::new(time, TAU / counts, limits),
            before: Some(HoldingGains {
                controller: ControllerSettings::pid(12.0, 0.4, 72.0).limited(10.0),
                cutoff: 600.0,
            }),
            ..ordinary()
        };
        let course = bench.commission(&mut |_| None);
        let reason = course.state.reason();
        let is_noise = reason == Some(Reason::EncoderNoise);
        assert!(reason.is_none() || is_noise, "{time} {noise}: {reason:?}");
        assert_eq!(course.disabled, None, "{time} {noise}: {reason:?}");
        let [low, high] = course.travel;
        assert!(low > -1.0 && high < 1.0, "{time} {noise}: {low} {high}");
    }
}

/// Whether new gains hold the axis or those before, a loop that fails after the end is disabled.
#[test]
fn an_axis_is_watched_after_the_end() {
    for stopped_in in [None, Some(Phase::Fit)] {
        let bench = Bench {
            before: Some(before()),
            ..ordinary()
        };
        let mut stop = |phase| (Some(phase) == stopped_in).then_some(Reason::FollowingError);
        let sound = bench.run(&[], &mut stop);
        assert_eq!(sound.disabled, None, "{stopped_in:?}");
        let end = sound.ended().expect("it ends");
        let fault = InjectedFault::lasting(FaultKind::EncoderReversed, end + 2e-3, 0.0);
        let course = bench.run(&[fault], &mut stop);
        assert_eq!(course.ended(), Some(end), "{stopped_in:?}");
        assert!(course.disabled.is_some(), "{stopped_in:?}");
    }
}
