//! Faults that a sound axis may seem to have: it is not disabled for them.

use std::f64::consts::{PI, TAU};

use commissioning::{CommissionSettings, HoldingGains, Limits, Phase};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use identifier_core::settings::ControllerSettings;
use virtual_servo::Effects;
use virtual_servo::faults::{FaultKind, InjectedFault};

use crate::machine::before;
use crate::rig::{Bench, Course, ordinary};

/// An axis that holds a part of its command against its load, and moves with a little speed.
fn loaded(part: f64) -> Bench {
    let counts = 17_581.0;
    let b = 17_787.0;
    Bench {
        servo: ServoParameters {
            a: 0.4266,
            b,
            coulomb: 4484.0,
            load: part * b,
        },
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
        background: None,
    }
}

#[test]
fn an_axis_that_holds_a_heavy_load_is_not_disabled() {
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
            servo: ServoParameters {
                a: 1.0,
                b: 300.0,
                coulomb: 50.0,
                load: 0.0,
            },
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
