//! Servos without individual tuning: one automatic Γ for the whole box. `CAMPAIGN=4` for two hundred of them.

use std::fmt::Write;

use host_sim::scenario::{Estimator, Scenario};
use host_sim::simulate;
use identifier_core::parameters::PerParameter;
use identifier_log::result::Summary;
use integration_tests::{Random, factor, in_parallel, run, servo};
use servo_id::paper::{self, Case, Method};

const SERVOS: usize = 50;

/// Servos of the parameter range a ∈ [0, 50], b ∈ [110, 1000], |d| ≤ 40 under the paper's PID, each with a reference of
/// its own; Γ is chosen automatically, for all of them from the paper's reference.
fn scenarios() -> Vec<Scenario> {
    let mut base = paper::scenario(Method::Proposed, Case::Balanced);
    base.stated.identifier.gamma = None;
    let base = base.with_gamma_chosen();
    assert!(base.stated.identifier.gamma.is_some());
    let mut random = Random::new(200);
    (0..SERVOS * factor::<usize>())
        .map(|_| {
            let mut scenario = base.clone();
            let servo = servo(&mut scenario);
            servo.a = random.uniform(0.0, 50.0);
            servo.b = random.log_uniform(110.0, 1000.0);
            servo.load = random.uniform(-40.0, 40.0);
            scenario.excitation.seed = random.seed();
            scenario
        })
        .collect()
}

/// The value that a fraction of the sorted values does not exceed.
fn quantile(sorted: &[f64], fraction: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * fraction).round() as usize]
}

fn row(table: &mut String, name: &str, mut values: Vec<f64>) {
    values.sort_by(f64::total_cmp);
    let [median, ninety, most, worst] =
        [0.5, 0.9, 0.95, 1.0].map(|fraction| quantile(&values, fraction));
    writeln!(
        table,
        "{name:<36}{median:>9.2}{ninety:>9.2}{most:>9.2}{worst:>9.2}"
    )
    .expect("a string takes any text");
}

#[test]
fn every_servo_of_the_range_is_identified_with_one_automatic_gain() {
    let scenarios = scenarios();
    let summaries: Vec<Summary> = in_parallel(&scenarios, run);

    let servos = scenarios.len();
    let mut table =
        format!("{servos} servos, 60 s             median      90 %     95 %      all\n");
    let never = f64::INFINITY;
    let (mut errors_a, mut errors_b) = (Vec::new(), Vec::new());
    for summary in &summaries {
        let truth = &summary.truth.expect("known");
        errors_a.push((summary.estimates.a.tail_mean - truth.a).abs() / (0.01 * truth.a).max(0.03));
        errors_b.push(100.0 * (summary.estimates.b.tail_mean / truth.b - 1.0).abs());
        assert!(
            summary.outcome.abort.is_none(),
            "{truth:?}: {}",
            summary.reason
        );
        assert_eq!(
            summary.outcome.events.restarted, 0,
            "{truth:?}: the model ran away"
        );
    }
    let settling = |of: fn(&Summary) -> Option<f64>| {
        summaries.iter().map(|s| of(s).unwrap_or(never)).collect()
    };
    row(
        &mut table,
        "a settles (±0.1 1/s) after, s",
        settling(|s| s.settling_time.a),
    );
    row(
        &mut table,
        "b settles (2 %) after, s",
        settling(|s| s.settling_time.b),
    );
    row(
        &mut table,
        "error of a / max(1 %, 0.03 1/s)",
        errors_a.clone(),
    );
    row(&mut table, "error of b, %", errors_b.clone());
    println!("{table}");

    for ((summary, a), b) in summaries.iter().zip(errors_a).zip(errors_b) {
        assert!(a < 1.0, "{:?}: â {:?}", summary.truth, summary.estimates.a);
        assert!(b < 0.2, "{:?}: b̂ {:?}", summary.truth, summary.estimates.b);
    }
    if factor::<usize>() == 1 {
        insta::assert_snapshot!(table);
    }
}

/// A first fit over a quarter of a second, without a guess.
#[test]
fn gauss_newton_knows_b_of_the_median_servo_after_a_quarter_of_a_second() {
    const AFTER: f64 = 0.25;
    let mut scenarios = scenarios();
    for scenario in &mut scenarios {
        scenario.identifier.set_estimator(Estimator::GaussNewton);
        scenario.duration = 1.0;
        let given = &mut scenario.stated.identifier;
        given.start_time = Some(AFTER);
        given.initial = PerParameter::default();
        (given.parameter_range, given.gamma) = (None, None);
    }
    let mut errors = in_parallel(&scenarios, |scenario| {
        let truth = scenario.plant.expect("a run has a plant").b;
        let mut error = f64::INFINITY;
        simulate::run(scenario, &mut |sample| {
            if sample.time <= AFTER {
                error = (sample.estimates.b / truth - 1.0).abs();
            }
        })
        .expect("a valid scenario");
        error
    });
    errors.sort_by(f64::total_cmp);
    let [median, ninety] = [0.5, 0.9].map(|fraction| quantile(&errors, fraction));
    println!("b after {AFTER} s: {median:.5} at the median, {ninety:.5} in 90 %");
    assert!(median < 0.01, "{median}");
}

#[test]
fn a_gain_a_thousand_times_too_large_is_slowed_and_reported() {
    let mut scenarios = scenarios();
    for scenario in &mut scenarios {
        let gamma = scenario.stated.identifier.gamma.as_mut().expect("chosen");
        *gamma = PerParameter::from_fn(|parameter| 1000.0 * gamma.get(parameter));
    }
    for summary in in_parallel(&scenarios, run) {
        let truth = &summary.truth.expect("known");
        let rms = summary.output_error.expect("the law has a model").rms;
        assert!(
            summary.outcome.abort.is_none(),
            "{truth:?}: {}",
            summary.reason
        );
        assert_eq!(
            summary.outcome.events.restarted, 0,
            "{truth:?}: the model ran away"
        );
        assert!(rms < 0.2, "{truth:?}: output error {rms} rad rms");
        assert!(
            summary.reason.contains("the guard slowed"),
            "{truth:?}: {}",
            summary.reason
        );
    }
}
