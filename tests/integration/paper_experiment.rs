//! The figures that the matched loop must reach in the paper's experiment.

use host_sim::scenario::{Arithmetic, Scenario};
use identifier_log::result::Summary;
use identifier_log::verdict::Status;
use integration_tests::{controller, parse, run, servo};
use servo_id::paper::{self, Case, Method, NOMINAL_A, NOMINAL_B};

fn proposed(load: f64, arithmetic: Arithmetic) -> Scenario {
    let mut scenario = paper::scenario(Method::Proposed, Case::Balanced);
    servo(&mut scenario).load = load;
    scenario.identifier.arithmetic = arithmetic;
    scenario
}

/// Tail means within `a` (1/s) and `b` (relative) of nominal, and d̂ within 1 % of the load.
fn assert_tail(summary: &Summary, a: f64, b: f64) {
    let truth = summary.truth.expect("known");
    let label = format!("{} d = {}", summary.arithmetic, truth.load);
    let load = summary.estimates.load;
    assert_eq!(
        summary.status(),
        Status::Converged,
        "{label}: {}",
        summary.reason
    );
    assert!(
        (summary.estimates.a.tail_mean - NOMINAL_A).abs() < a,
        "{label}: â {:?}",
        summary.estimates.a
    );
    assert!(
        (summary.estimates.b.tail_mean / NOMINAL_B - 1.0).abs() < b,
        "{label}: b̂ {:?}",
        summary.estimates.b
    );
    let load_error = (load.tail_mean - truth.load).abs();
    assert!(
        load_error < 0.01 * truth.load.abs().max(1.0),
        "{label}: d̂ {load:?}"
    );
}

#[test]
fn matched_loop_identifies_the_papers_servo_with_and_without_load() {
    for arithmetic in [Arithmetic::F64, Arithmetic::F32] {
        for load in [0.0, 20.0, -20.0] {
            let summary = run(&proposed(load, arithmetic));
            assert_tail(&summary, 0.01, 1e-3);
            assert!(summary.outcome.certified);
        }
    }
}

/// With the paper's own Γ and reference b̂ needs 2.2 s to come within 2 %, with any encoder, sample
/// time or number format: it is (11) itself that takes this long. The automatic Γ takes 1.0 s.
#[test]
fn automatic_gain_settles_faster_than_the_papers() {
    for arithmetic in [Arithmetic::F64, Arithmetic::F32] {
        for load in [0.0, 20.0] {
            let mut scenario = proposed(load, arithmetic);
            let by_paper = run(&scenario).settling_time.b.expect("settles");
            assert!(by_paper < 2.5, "{by_paper}");
            scenario.stated.identifier.gamma = None;
            let summary = run(&scenario);
            assert!(
                summary.settling_time.b.expect("settles") < 1.5,
                "{summary:?}"
            );
            assert_tail(&summary, 0.01, 1e-3);
        }
    }
}

#[test]
fn saturation_under_load_does_not_bias() {
    for arithmetic in [Arithmetic::F64, Arithmetic::F32] {
        let mut scenario = proposed(40.0, arithmetic);
        controller(&mut scenario).limit = [-1.0, 1.0];
        assert_tail(&run(&scenario), 0.03, 5e-3);
    }
}

#[test]
fn asymmetric_saturation_does_not_bias_either() {
    let mut scenario = proposed(20.0, Arithmetic::F32);
    controller(&mut scenario).limit = [-2.0, 0.8];
    assert_tail(&run(&scenario), 0.03, 5e-3);
}

#[test]
fn every_velocity_estimate_is_matched() {
    for filter in ["\"difference\"", "\"averaged-difference\""] {
        let text = paper::PROPOSED.replace("\"low-pass\", cutoff = 500.0", filter);
        let mut scenario = parse(&text);
        servo(&mut scenario).load = 20.0;
        assert_tail(&run(&scenario), 0.01, 1e-3);
    }
}
