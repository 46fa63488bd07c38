//! Properties of the gains of every servo.

use std::f64::consts::{PI, TAU};

use identifier_core::control::Gains;
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::stability::SampledLoop;
use identifier_core::tuning::{
    Goal, PredictedResponse, Tuner, Tuning, TuningError, TuningSettings,
};
use identifier_core::units::Units;
use proptest::prelude::*;

use crate::support::{
    Candidate, bench, candidates, identified, loop_gain, sensitivity, step, tuned,
};

/// A servo and the demands on its loop.
type Case = (IdentifiedServo, TuningSettings);

fn between(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

/// Servos of b 20 to 2000, time constants down to 20 ms, friction up to a fifth of the limit, delays of up to
/// three samples, known to between 0.1 and 3 %, at 250 Hz to 20 kHz; half of them with feed-forward. With as much friction it is
/// seldom worthwhile, so that a third has little.
fn case() -> impl Strategy<Value = Case> {
    let servo = (
        between(20.0, 2000.0),
        between(0.01, 50.0),
        prop_oneof![2 => 0.0..0.2, 1 => 0.0..0.003],
        between(0.001, 0.03),
    );
    let drive = (
        between(250.0, 20_000.0),
        0.0..3.0,
        prop_oneof![
            Just(0.0),
            between(1000.0, 131_072.0).prop_map(|counts| TAU / counts)
        ],
    );
    let goal = prop_oneof![
        2 => Just(Goal::Stiffest),
        1 => between(0.01, 1.0).prop_map(Goal::ResponseTime),
        1 => between(1.0, 500.0).prop_map(Goal::Bandwidth),
    ];
    let shape = (between(0.02, 0.5), any::<bool>());
    (servo, drive, goal, shape).prop_map(
        |((b, a, friction, error), (rate, delay, resolution), goal, (part, feed_forward))| {
            let limit = 10.0;
            let sample_time = 1.0 / rate;
            let parameters = ServoParameters::new(a, b, friction * limit * b, 0.0);
            let errors = [error * (a + 1.0), error * b, error * sample_time];
            let step = part.max(12.0 * resolution);
            let settings = TuningSettings {
                goal,
                feed_forward,
                ..TuningSettings::new(sample_time, resolution, limit, step)
            };
            (
                identified(parameters, delay * sample_time, errors),
                settings,
            )
        },
    )
}

/// The goal, or a fifth less than the largest possible.
fn within_reach((servo, mut settings): Case) -> Option<(TuningSettings, Tuning)> {
    let (mut result, slices) = tuned(&settings, &servo);
    assert!(slices < 25_000, "{slices}");
    if let Err(TuningError::TooFast { most, .. }) = result {
        settings.goal = Goal::Bandwidth(0.8 * most);
        result = tuned(&settings, &servo).0;
    }
    match result {
        Ok(tuning) => Some((settings, tuning)),
        // A slower step may end where friction holds it.
        Err(TuningError::DoesNotArrive) => None,
        Err(error) => panic!("{error:?}"),
    }
}

/// True if the response to a step decays, without friction, counts and limit.
fn is_stable(tuning: &Tuning, settings: &TuningSettings, candidate: &Candidate) -> bool {
    let frictionless = ServoParameters {
        coulomb: 0.0,
        ..candidate.0
    };
    let ideal = TuningSettings {
        resolution: 0.0,
        command: f64::INFINITY,
        ..*settings
    };
    let mut bench = bench(tuning, &ideal, &(frictionless, candidate.1), 0.0);
    let samples = (60.0 / (tuning.bandwidth * settings.sample_time)) as usize;
    let positions: Vec<f64> = (0..samples).map(|_| bench(1.0)).collect();
    let mut late = positions[samples * 9 / 10 + 1..].iter();
    late.all(|position| (position - 1.0).abs() < 1e-3)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn every_possible_servo_keeps_the_margins_and_is_stable(case in case()) {
        if let Some((settings, tuning)) = within_reach(case) {
            let mut worst = 0.0_f64;
            for candidate in candidates(&case.0) {
                prop_assert!(is_stable(&tuning, &settings, &candidate), "{candidate:?} {tuning:?}");
                worst = worst.max(sensitivity(&tuning, settings.sample_time, &candidate));
            }
            prop_assert!(worst < 1.002 * settings.max_sensitivity, "{worst} {tuning:?}");
            let predicted = tuning.predicted_response.sensitivity;
            prop_assert!((worst / predicted - 1.0).abs() < 0.005, "{worst} {tuning:?}");
            let tuner = Tuner::new(&settings, &case.0).expect("it tuned");
            let omega = 3.0 * tuning.bandwidth;
            let [identified, largest] = tuner.sensitivity(&tuning, omega).expect("below π/T");
            let distance = loop_gain(&tuning, settings.sample_time, &candidates(&case.0)[0], omega) + 1.0;
            prop_assert!((identified * distance.power().sqrt() - 1.0).abs() < 1e-5, "{identified}");
            prop_assert!(identified <= largest && largest < 1.002 * predicted, "{largest} {predicted}");
            prop_assert!(tuning.predicted_response.noise <= settings.max_noise * settings.command);
        }
    }

    /// At the gain margins L is −1 over the factor. One below a thousandth may be given as zero.
    #[test]
    fn gain_margins_are_where_the_loop_crosses(case in case()) {
        let known = IdentifiedServo { covariance: [[0.0; 5]; 5], ..case.0 };
        if let Some((settings, tuning)) = within_reach((known, case.1)) {
            let candidate = (known.parameters, known.delay);
            let (mut lower, mut upper) = (0.0_f64, 50.0_f64);
            let mut before: Option<f64> = None;
            let nyquist = PI / settings.sample_time;
            let low = tuning.bandwidth / 80.0;
            for i in 0..=20_000 {
                let omega = low * (0.999 * nyquist / low).powf(f64::from(i) / 20_000.0);
                let here = loop_gain(&tuning, settings.sample_time, &candidate, omega);
                let crosses = before.replace(here.im).is_some_and(|im| (im > 0.0) != (here.im > 0.0));
                if crosses && here.re < 0.0 {
                    let factor = -1.0 / here.re;
                    if factor < 1.0 { lower = lower.max(factor) } else { upper = upper.min(factor) }
                }
            }
            let [fall, rise] = tuning.predicted_response.gain_margins;
            let is_any = fall.max(lower) < 1e-3;
            prop_assert!(is_any || (fall - lower).abs() < 0.02 * lower, "{fall} {lower} {tuning:?}");
            prop_assert!((rise - upper).abs() < 0.02 * upper, "{rise} {upper} {tuning:?}");
        }
    }

    /// Without delay the characteristic polynomial is exact: the loop is stable up to the gain margins and
    /// not beyond.
    #[test]
    fn without_delay_the_polynomial_agrees(case in case()) {
        let known = IdentifiedServo { covariance: [[0.0; 5]; 5], delay: 0.0, ..case.0 };
        if let Some((settings, tuning)) = within_reach((known, case.1)) {
            let units = Units::new(settings.sample_time, 1.0).expect("valid");
            let gains = Gains::new(tuning.kp, tuning.kd, tuning.ki).expect("valid");
            let filter = LowPass::<f64>::new(&units, tuning.cutoff).expect("valid").transfer();
            let ServoParameters { a, b, .. } = known.parameters;
            let stable = |factor: f64| SampledLoop::new(&units, &gains, &filter).is_stable(a, factor * b);
            let [fall, rise] = tuning.predicted_response.gain_margins;
            prop_assert!(stable(1.0));
            prop_assert!(stable((1.02 * fall).max(0.01)) && stable(0.98 * rise), "{tuning:?}");
            if fall > 0.0 {
                prop_assert!(!stable(0.98 * fall), "{tuning:?}");
            }
            if rise < 49.0 {
                prop_assert!(!stable(1.02 * rise), "{tuning:?}");
            }
        }
    }

    /// The tolerances of the trial on the axis: rise time within 15 %, overshoot within 3 points.
    #[test]
    fn the_prediction_is_kept(case in case(), corner in 0_usize..7, friction in -1.0..1.0) {
        if let Some((settings, tuning)) = within_reach(case) {
            let predicted_response = tuning.predicted_response;
            let candidates = candidates(&case.0);
            let duration = 30.0 / tuning.bandwidth;
            let steps = |candidate: &Candidate, held: f64| {
                step(bench(&tuning, &settings, candidate, held), &settings, duration)
            };
            let nominal = steps(&candidates[0], 0.0);
            let rise = nominal.rise().expect("it rises") * settings.sample_time;
            prop_assert!((rise / predicted_response.rise_time - 1.0).abs() < 0.15, "{rise} {predicted_response:?}");
            let ServoParameters { b, coulomb, .. } = case.0.parameters;
            let held = steps(&candidates[0], friction * coulomb / b);
            let between = held.rise().map_or(f64::INFINITY, |rise| rise * settings.sample_time);
            let least = 0.85 * predicted_response.quickest_rise_time.min(predicted_response.rise_time);
            let most = 1.15 * predicted_response.slowest_rise_time;
            let is_told = most > PredictedResponse::MAX_TIME / tuning.bandwidth || between < most;
            prop_assert!(between > least && is_told, "{between} {predicted_response:?}");
            // Friction holds the servo at any earlier value of the integral.
            let ServoParameters { b, coulomb, .. } = candidates[corner].0;
            let other = steps(&candidates[corner], friction * coulomb / b);
            prop_assert!(other.overshoot() < predicted_response.overshoot + 0.03, "{} {predicted_response:?}", other.overshoot());
        }
    }
}
