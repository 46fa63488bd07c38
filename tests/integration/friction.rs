//! Servos with Coulomb friction and load: both estimators, both formats, with and without saturation.

use host_sim::scenario::Scenario;
use identifier_log::result::Summary;
use identifier_log::verdict::Cause;
use identifier_log::verdict::Status;
use integration_tests::{parse, run};

/// A scenario with friction c, a load of 20 rad/s² and |u| ≤ limit.
fn scenario(law: &str, arithmetic: &str, coulomb: f64, limit: f64) -> Scenario {
    let assumed = match law {
        "gradient" => "servo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }",
        _ => "",
    };
    parse(&format!(
        "[plant]\n\
         a = 0.2174\n\
         b = 257.7\n\
         load = 20.0\n\
         coulomb = {coulomb}\n\
         [amplifier]\n\
         limit = {limit}\n\
         [identifier]\n\
         law = \"{law}\"\n\
         parameters = [\"a\", \"b\", \"coulomb\"]\n\
         {assumed}\n\
         arithmetic = \"{arithmetic}\"\n"
    ))
}

/// Tail means within `a` (1/s), and `b`, `coulomb`, `load` (relative) of the truth.
fn assert_tail(summary: &Summary, a: f64, b: f64, coulomb: f64, load: f64) {
    let truth = summary.truth.expect("known");
    let relative = |estimate: f64, truth: f64| (estimate / truth - 1.0).abs();
    assert!(
        (summary.estimates.a.tail_mean - truth.a).abs() < a,
        "â {summary:?}"
    );
    assert!(
        relative(summary.estimates.b.tail_mean, truth.b) < b,
        "b̂ {summary:?}"
    );
    assert!(
        relative(summary.estimates.coulomb.tail_mean, truth.coulomb) < coulomb,
        "ĉ {summary:?}"
    );
    assert!(
        relative(summary.estimates.load.tail_mean, truth.load) < load,
        "d̂ {summary:?}"
    );
}

#[test]
fn both_estimators_find_friction_and_load() {
    for (coulomb, a, b) in [(10.0, 0.03, 2e-3), (30.0, 0.05, 5e-3)] {
        for law in ["gradient", "gauss-newton"] {
            for (arithmetic, limit) in [("f32", 10.0), ("f32", 1.0), ("f64", 10.0), ("f64", 1.0)] {
                let summary = run(&scenario(law, arithmetic, coulomb, limit));
                assert_tail(&summary, a, b, 0.03, 0.02);
            }
        }
    }
}

#[test]
fn a_model_without_friction_is_biased_by_it_and_the_residual_says_why() {
    let mut lacking = scenario("gauss-newton", "f64", 10.0, 10.0);
    lacking.identifier.parameters.truncate(2);
    let without = run(&lacking);
    let named = without.cause.as_ref().map(|finding| finding.cause);
    assert_eq!(named, Some(Cause::Coulomb), "{}", without.reason);
    assert_ne!(without.status(), Status::Converged, "{}", without.reason);
    let with = run(&scenario("gauss-newton", "f64", 10.0, 10.0));
    let residual = with.residual.expect("it is long enough");
    assert!(residual.is_the_encoders(), "{residual:?}");
    assert_eq!(with.status(), Status::Converged, "{}", with.reason);
}

#[test]
fn friction_that_is_known_can_be_given_and_kept() {
    let mut known = scenario("gauss-newton", "f64", 10.0, 10.0);
    known.identifier.parameters.truncate(2);
    known.stated.identifier.initial.coulomb = Some(10.0);
    let summary = run(&known);
    assert_tail(&summary, 0.01, 1e-3, 1e-9, 0.02);
    assert!(
        summary.estimates.coulomb.tail_std < 1e-9,
        "it stays where it is"
    );
}
