//! Feed-forward removes the error with which a loop follows its reference.

use identifier_core::control::{FeedForward, FeedForwardSettings, ReferenceMotion};
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::{Goal, TuningSettings, tune};
use identifier_core::units::Units;

use crate::support::{Bench, identified};

const SERVO: ServoParameters = ServoParameters {
    a: 4.0,
    b: 257.7,
    coulomb: 15.0,
    load: 0.0,
};

const SAMPLE_TIME: f64 = 1e-3;
const DELAY: f64 = 1.3e-3;

/// Position, velocity and acceleration of 0.5 rad (1 − cos 6t).
fn reference(time: f64) -> [f64; 3] {
    let (sine, cosine) = (6.0 * time).sin_cos();
    [0.5 * (1.0 - cosine), 3.0 * sine, 18.0 * cosine]
}

/// The largest error after the first swing, with what the feed-forward is told, if there is one; rad.
fn largest_error(told: Option<(ServoParameters, f64)>) -> f64 {
    let settings = TuningSettings {
        goal: Goal::Bandwidth(40.0),
        ..TuningSettings::new(SAMPLE_TIME, 0.0, 10.0, 0.1)
    };
    let tuning = tune(&settings, &identified(SERVO, DELAY, [0.0; 3])).expect("within reach");
    let units = Units::new(SAMPLE_TIME, 1.0).expect("valid");
    let feed_forward = told.map(|(servo, kd_share)| {
        let settings = FeedForwardSettings {
            a: servo.a,
            b: servo.b,
            coulomb: servo.coulomb,
            load: servo.load,
            gravity: [0.0; 2],
            kd: kd_share * tuning.kd,
            sign_speed: 0.02,
        };
        FeedForward::<f64>::new(&units, &settings).expect("valid")
    });
    let mut bench = Bench::new(&tuning, &settings, &(SERVO, DELAY), 0.0);
    let mut largest = 0.0_f64;
    for k in 0..6000 {
        let time = f64::from(k) * SAMPLE_TIME;
        let [_, velocity, acceleration] = reference(time + DELAY + 0.5 * SAMPLE_TIME);
        let command = feed_forward.map_or(0.0, |feed_forward| {
            feed_forward.command(&ReferenceMotion {
                angle: 0.0,
                velocity: velocity * units.velocity(),
                acceleration: acceleration * units.acceleration(),
            })
        });
        let [wanted, ..] = reference(time);
        let (position, _) = bench.advance_with(wanted, command);
        if time > 2.0 {
            largest = largest.max((wanted - position).abs());
        }
    }
    largest
}

#[test]
fn the_tracking_error_goes() {
    let without = largest_error(None);
    let with = largest_error(Some((SERVO, 1.0)));
    assert!(without > 0.1, "{without}");
    assert!(with < without / 40.0, "{with} of {without}");
}

/// Each part is needed: without it the error is a multiple.
#[test]
fn every_part_has_its_share() {
    let with = largest_error(Some((SERVO, 1.0)));
    for (servo, kd_share) in [
        (ServoParameters { a: 0.0, ..SERVO }, 1.0),
        (
            ServoParameters {
                coulomb: 0.0,
                ..SERVO
            },
            1.0,
        ),
        (
            ServoParameters {
                b: 2.0 * SERVO.b,
                ..SERVO
            },
            1.0,
        ),
        (SERVO, 0.0),
    ] {
        let lacking = largest_error(Some((servo, kd_share)));
        assert!(
            lacking > 2.0 * with,
            "{lacking} {with} {servo:?} {kd_share}"
        );
    }
}
