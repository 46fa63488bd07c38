//! Runs of a scenario that cannot begin, or not go on.

use host_sim::scenario::{Estimator, PAPER, Purpose, Scenario};
use host_sim::simulate::run;

fn paper() -> Scenario {
    Scenario::parse("paper.toml", PAPER, Purpose::Run).expect("valid")
}

#[test]
fn a_part_that_cannot_be_built_names_its_key_and_runs_no_sample() {
    let refused = |change: &dyn Fn(&mut Scenario)| {
        let mut scenario = paper();
        change(&mut scenario);
        let fault = run(&scenario, &mut |_| panic!("a sample")).expect_err("it cannot be");
        fault.key
    };
    assert_eq!(refused(&|s| s.plant = None), "plant");
    assert_eq!(
        refused(&|s| s.stated.cutoff = -1.0),
        "controller.velocity_filter.cutoff"
    );
    let key = refused(&|s| {
        s.identifier.set_estimator(Estimator::RelayLeastSquares);
        s.identifier.rival.filter_cutoff = 1e9;
    });
    assert_eq!(key, "identifier.filter_cutoff");
}

#[test]
fn a_servo_that_outruns_its_encoder_ends_the_run_with_the_time() {
    let mut scenario = paper();
    let servo = scenario.plant.as_mut().expect("a run has a plant");
    servo.b *= 1e6;
    let mut last = 0.0;
    let outcome = run(&scenario, &mut |sample| last = sample.time).expect("it can be built");
    let abort = outcome.abort.expect("it stops");
    assert_eq!(outcome.samples, (abort.time * 1e3).round() as u64);
    assert!((abort.time - last - scenario.sample_time()).abs() < 1e-9);
}
