//! Many random servos: the paper's claim as numbers, and a sweep that any number of threads does
//! alike.

use std::sync::atomic::AtomicBool;

use host_sim::compare::with_estimator;
use host_sim::result::SweepRun;
use host_sim::scenario::{Estimator, Scenario};
use host_sim::sweep::sweep;
use identifier_core::parameters::Parameter;
use integration_tests::{environment, parse, servo};

const BOX: &str = "
[plant]
a = 0.2174
b = 257.7
load = 0.0
[encoder]
counts_per_rev = 10000
[amplifier]
limit = 10.0
[controller]
kp = 9.0
kd = 0.19
ki = 4.0
sample_time = 0.001
[identifier]
law = \"gradient\"
initial = { a = 0.0, b = 300.0 }
servo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }
[run]
duration = 30.0
";

/// Servos of a sweep, times `CAMPAIGN`.
const SERVOS: u32 = 7;

fn swept(scenario: &Scenario, runs: u32) -> Vec<SweepRun> {
    sweep(scenario, 0..runs, 7, &AtomicBool::new(false), &|| ()).expect("it can be built")
}

/// By how much a load of 20 rad/s² moves the estimates of each servo, in ascending order: |Δb̂|/b in
/// per cent and |Δâ| in 1/s.
fn moved_by_a_load(law: Estimator) -> [Vec<f64>; 2] {
    let servos = SERVOS * environment("CAMPAIGN").unwrap_or(1);
    let mut scenario = parse(BOX);
    scenario.identifier.parameters = vec![Parameter::A, Parameter::B];
    let mut scenario = with_estimator(&scenario, law);
    scenario.identifier.parameters = vec![Parameter::A, Parameter::B];
    let without = swept(&scenario, servos);
    // A load that is drawn would differ from servo to servo; this one is the same for all.
    let with: Vec<SweepRun> = {
        let drawn: Vec<Scenario> = (0..servos)
            .map(|index| {
                let chosen = scenario.clone().with_gamma_chosen();
                let mut drawn = host_sim::sweep::draw(&chosen, 7, index);
                servo(&mut drawn).load = 20.0;
                drawn
            })
            .collect();
        integration_tests::in_parallel(&drawn, |drawn| {
            let summary = integration_tests::run(drawn);
            SweepRun {
                index: 0,
                truth: drawn.plant.expect("a servo"),
                status: summary.status(),
                found: identifier_core::parameters::ServoParameters {
                    a: summary.estimates.a.value,
                    b: summary.estimates.b.value,
                    coulomb: 0.0,
                    load: 0.0,
                },
                settling_a: None,
                settling_b: None,
            }
        })
    };
    let moved = |relative: bool| {
        let mut moved: Vec<f64> = without
            .iter()
            .zip(&with)
            .map(|(without, with)| {
                if relative {
                    100.0 * (with.found.b - without.found.b).abs() / without.truth.b
                } else {
                    (with.found.a - without.found.a).abs()
                }
            })
            .collect();
        moved.sort_by(f64::total_cmp);
        moved
    };
    [moved(true), moved(false)]
}

#[test]
fn a_constant_load_moves_the_least_squares_and_not_the_proposed_method() {
    let proposed = moved_by_a_load(Estimator::Gradient);
    let rival = moved_by_a_load(Estimator::RelayLeastSquares);
    let at = |sorted: &[f64], part: f64| sorted[(part * (sorted.len() - 1) as f64) as usize];
    for (name, [b, a]) in [("proposed", &proposed), ("least squares", &rival)] {
        println!(
            "{name}: b moves by {:.4} % (median), {:.4} % (95 of 100), {:.4} % (most); a by {:.4}, \
             {:.4}, {:.4} 1/s",
            at(b, 0.5),
            at(b, 0.95),
            at(b, 1.0),
            at(a, 0.5),
            at(a, 0.95),
            at(a, 1.0),
        );
    }
    assert!(at(&proposed[0], 0.5) < 0.02 && at(&proposed[0], 0.95) < 0.5);
    assert!(at(&rival[0], 0.5) > 20.0 * at(&proposed[0], 0.5));
}
