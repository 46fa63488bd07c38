//! The comparison of all methods: each one's claim, and where each fails, as a reviewed table.

use host_sim::compare::{self, with_estimator};
use host_sim::scenario::{Estimator, Scenario};
use identifier_core::parameters::Parameter;
use identifier_log::result::Summary;
use integration_tests::{controller, in_parallel, parse, run, servo};
use servo_id::{present, render};

const BENCH: &str = include_str!("../../host-sim/scenarios/compare.toml");

/// The page with the reviewed tables.
const PAGE: &str = include_str!("../../docs/comparison.md");

/// Wide enough for every column.
const WIDTH: u16 = 200;

#[test]
fn the_comparison_is_as_reviewed() {
    let result = compare::compare(&parse(BENCH), &|| ()).expect("it has a servo");
    let duration = parse(BENCH).duration;
    let page = present::comparison("", "", &result, duration);
    let text = render::terminal::brief(&page, WIDTH);
    let text = anstream::adapter::strip_str(&text).to_string();
    // The page explains the columns in its own words.
    let (text, _) = text.split_once("\nErrors: ").expect("the tables end");
    insta::assert_snapshot!(text);
    assert!(
        PAGE.contains(text),
        "docs/comparison.md shows another table"
    );
}

/// Conditions under which each method's own source makes its claim: the servo without load, a fine sensor, no
/// saturation; and friction where the method models friction.
fn at_its_best(law: Estimator) -> Scenario {
    let mut scenario = parse(BENCH);
    scenario.counts_per_rev = None;
    scenario.stated.identifier.initial.b = Some(50.0);
    with_estimator(&scenario, law)
}

fn assert_found(summary: &Summary, parameters: &[Parameter]) {
    let truth = summary.truth.expect("a simulated servo");
    for &parameter in parameters {
        let off =
            summary.estimate(parameter).expect("it is estimated").value - truth.get(parameter);
        let tolerance = match parameter {
            Parameter::A => 0.1,
            Parameter::B => 0.02 * truth.b,
            Parameter::Coulomb | Parameter::Load => 1.0,
        };
        assert!(
            off.abs() < tolerance,
            "{}: {} is off by {off}",
            summary.law,
            parameter.name()
        );
    }
}

#[test]
fn each_method_keeps_its_own_claim() {
    for summary in in_parallel(Estimator::ALL, |law| run(&at_its_best(*law))) {
        assert_found(&summary, &[Parameter::A, Parameter::B]);
    }
}

#[test]
fn the_methods_that_model_friction_or_a_load_identify_it() {
    for (parameter, [coulomb, load]) in [
        (Parameter::Coulomb, [10.0, 0.0]),
        (Parameter::Load, [0.0, 20.0]),
    ] {
        let finding = |law: &&Estimator| law.finds().contains(&parameter);
        let knowing: Vec<Estimator> = Estimator::ALL.iter().filter(finding).copied().collect();
        assert!(knowing.len() >= 3);
        let found = in_parallel(&knowing, |law| {
            let mut scenario = at_its_best(*law);
            (servo(&mut scenario).coulomb, servo(&mut scenario).load) = (coulomb, load);
            run(&scenario)
        });
        for summary in found {
            assert_found(&summary, &[Parameter::A, Parameter::B, parameter]);
        }
    }
}

/// A parameter range without a certified sampled loop is refused for methods with a certificate; the others still run.
#[test]
fn a_method_that_cannot_be_built_is_refused_and_the_others_run() {
    let mut scenario = parse(BENCH);
    controller(&mut scenario).kp = 0.5;
    scenario.duration = 2.0;
    let result = compare::compare(&scenario, &|| ()).expect("it has a servo");
    let methods = &result.cases[0].methods;
    assert!(methods[0].status.is_none() && methods[0].reason.contains("kp"));
    assert!(methods[3].status.is_some());
}
