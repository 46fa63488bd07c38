//! Steps along a reference model, with feed-forward, against those that the filter of the reference shapes.

use std::f64::consts::TAU;

use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::{Goal, Tuning, TuningSettings};

use crate::support::{Candidate, bench, candidates, identified, quantile, step, tuned};

/// The n-th of a sequence that fills the unit cube evenly (Kronecker's, with the roots of x⁷ = x + 1).
fn draw<const N: usize>(n: u32) -> [f64; N] {
    const ROOT: f64 = 1.112_775_684_278_705_5;
    let mut part = 1.0;
    [(); N].map(|()| {
        part /= ROOT;
        (0.5 + part * f64::from(n)).fract()
    })
}

fn between(low: f64, high: f64, part: f64) -> f64 {
    low * (high / low).powf(part)
}

/// Servos of b 20 to 2000 and a 0.01 to 50, with friction up to 0.02 of the limit, delays of up to three samples, known to
/// between 0.1 and 3 %, at 250 Hz to 20 kHz, as stiff as they bear.
fn servo(n: u32) -> (IdentifiedServo, TuningSettings) {
    const LIMIT: f64 = 10.0;
    let [b, a, friction, error, rate, delay, step, counts] = draw(n);
    let (b, a) = (between(20.0, 2000.0, b), between(0.01, 50.0, a));
    let error = between(0.001, 0.03, error);
    let sample_time = 1.0 / between(250.0, 20_000.0, rate);
    let counts = between(4000.0, 131_072.0, counts);
    let resolution = f64::from(n % 2) * TAU / counts;
    let parameters = ServoParameters::new(a, b, 0.02 * friction * LIMIT * b, 0.0);
    let errors = [error * (a + 1.0), error * b, error * sample_time];
    let step = between(0.01, 0.5, step).max(40.0 * resolution);
    (
        identified(parameters, 3.0 * delay * sample_time, errors),
        TuningSettings {
            goal: Goal::Stiffest,
            feed_forward: true,
            ..TuningSettings::new(sample_time, resolution, LIMIT, step)
        },
    )
}

/// The rise time, s, and the overshoot of a step after the integral has held this part of the friction.
fn stepped(tuning: &Tuning, settings: &TuningSettings, of: &Candidate, held: f64) -> (f64, f64) {
    let ServoParameters { b, coulomb, .. } = of.0;
    let bench = bench(tuning, settings, of, held * coulomb / b);
    let measure = step(bench, settings, 25.0 / tuning.bandwidth);
    let rise = measure.rise().unwrap_or(f64::INFINITY) * settings.sample_time;
    (rise, measure.overshoot())
}

/// `cargo test -p identifier-core --test tuning feed_forward:: -- --nocapture` prints the figures of docs/tuning.md.
#[test]
fn a_step_along_the_model_rises_faster_and_overshoots_as_little() {
    let (mut ratios, mut free, mut overshoots, mut before) = (vec![], vec![], vec![], vec![]);
    let mut drawn = 0;
    for n in 0..300 {
        let (servo, settings) = servo(n);
        let Ok(led) = tuned(&settings, &servo).0 else {
            continue;
        };
        drawn += 1;
        let Some(first_moment) = led.feed_forward else {
            continue;
        };
        let filter = TuningSettings {
            feed_forward: false,
            ..settings
        };
        let filtered = tuned(&filter, &servo).0.expect("the same loop");
        let of_loop = |tuning: &Tuning| {
            let Tuning { kp, kd, ki, .. } = *tuning;
            [kp, kd, ki, tuning.predicted_response.sensitivity].map(f64::to_bits)
        };
        assert_eq!(of_loop(&led), of_loop(&filtered));
        assert!(led.predicted_response.command_share <= 1.0);
        let all = candidates(&servo);
        let rises = [&led, &filtered].map(|tuning| stepped(tuning, &settings, &all[0], 0.0).0);
        let ratio = rises[0] / rises[1];
        ratios.push(ratio);
        if first_moment.bandwidth > 2.99 * led.bandwidth {
            free.push(ratio);
        }
        let most = |tuning: &Tuning| {
            let steps = all
                .iter()
                .flat_map(|of| [-1.0, 0.0, 1.0].map(|held| stepped(tuning, &settings, of, held).1));
            steps.fold(0.0, f64::max)
        };
        let count = settings.resolution / settings.step;
        let overshoot = most(&led);
        assert!(
            overshoot < led.predicted_response.overshoot + 0.005,
            "{overshoot} {led:?}"
        );
        overshoots.push(overshoot - count);
        before.push(most(&filtered) - count);
    }
    println!("{} of {drawn} with feed-forward", ratios.len());
    for (name, values) in [
        ("rise time over the filter's", &mut ratios),
        ("that where the command does not bound it", &mut free),
        ("overshoot, worst corner and friction", &mut overshoots),
        ("that with the filter", &mut before),
    ] {
        let [first, median, ninth, last] = [0.0, 0.5, 0.9, 1.0].map(|part| quantile(values, part));
        println!("{name}: {first:.3}, median {median:.3}, nine of ten {ninth:.3}, {last:.3}");
    }
    assert!(ratios.len() > 60 && free.len() > 20);
    assert!(quantile(&mut free, 0.5) < 0.35 && quantile(&mut ratios, 0.9) < 0.95);
    assert!(quantile(&mut overshoots, 0.95) < 0.03);
}

/// The integral may hold it already.
#[test]
fn friction_that_may_be_too_large_is_not_compensated() {
    let is_led = |(servo, settings): &(_, _)| {
        let tuning = tuned(settings, servo).0;
        tuning.is_ok_and(|tuning| tuning.feed_forward.is_some())
    };
    let (mut servo, settings) = (0..).map(servo).find(is_led).expect("one of them is led");
    let error = 0.3 * servo.parameters.b;
    servo.covariance[IdentifiedServo::COULOMB][IdentifiedServo::COULOMB] = error * error;
    let tuning = tuned(&settings, &servo).0.expect("the same loop");
    assert_eq!(tuning.feed_forward, None);
}
