//! Many random servos: the paper's claim as numbers.

use host_sim::compare::with_estimator;
use host_sim::scenario::{Estimator, Scenario};
use host_sim::sweep::draw;
use identifier_core::parameters::Parameter;
use integration_tests::{environment, in_parallel, parse, run, servo};

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

/// By how much a load of 20 rad/s² moves the estimates of each servo, in ascending order: |Δb̂|/b in
/// per cent and |Δâ| in 1/s.
fn moved_by_a_load(law: Estimator) -> [Vec<f64>; 2] {
    let servos = SERVOS * environment("CAMPAIGN").unwrap_or(1);
    let mut scenario = with_estimator(&parse(BOX), law);
    scenario.identifier.parameters = vec![Parameter::A, Parameter::B];
    let scenario = scenario.with_gamma_chosen();
    let drawn: Vec<Scenario> = (0..servos).map(|place| draw(&scenario, 7, place)).collect();
    let moved = in_parallel(&drawn, |drawn| {
        let [without, with] = [0.0, 20.0].map(|load| {
            let mut drawn = drawn.clone();
            servo(&mut drawn).load = load;
            run(&drawn).estimates
        });
        let b = drawn.plant.expect("a servo").b;
        let moved_b = 100.0 * (with.b.value - without.b.value).abs() / b;
        [moved_b, (with.a.value - without.a.value).abs()]
    });
    [0, 1].map(|of| {
        let mut sorted: Vec<f64> = moved.iter().map(|moved| moved[of]).collect();
        sorted.sort_by(f64::total_cmp);
        sorted
    })
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
