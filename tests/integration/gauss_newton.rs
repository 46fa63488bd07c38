//! Gauss–Newton: the coverage of its standard errors, a loop without derivative action, friction that is known.

use host_sim::scenario::{Arithmetic, Scenario};
use identifier_core::parameters::Parameter;
use identifier_log::result::Summary;
use integration_tests::{Random, factor, in_parallel, parse, run, servo};

/// The paper's servo and loop under noise of its own for each run, from an initial b̂.
fn scenarios(runs: usize, initial_b: f64, extra: &str) -> Vec<Scenario> {
    let base = parse(&format!(
        "[plant]\n\
         a = 0.2174\n\
         b = 257.7\n\
         {extra}\n\
         [amplifier]\n\
         limit = 10.0\n\
         [identifier]\n\
         law = \"gauss-newton\"\n\
         parameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n\
         initial = {{ a = 0.0, b = {initial_b} }}\n"
    ));
    let mut random = Random::new(33);
    (0..runs)
        .map(|k| {
            let mut scenario = base.clone();
            servo(&mut scenario).load = [0.0, 20.0, -20.0][k % 3];
            scenario.excitation.seed = random.seed();
            scenario
        })
        .collect()
}

/// How many runs have the truth within two standard errors.
fn covered(summaries: &[Summary], parameter: Parameter) -> usize {
    summaries
        .iter()
        .filter(|summary| {
            let estimate = summary.estimate(parameter).expect("estimated");
            let error = estimate.last - summary.truth.expect("known").get(parameter);
            error.abs() < 2.0 * estimate.std_error.expect("the law has one")
        })
        .count()
}

#[test]
fn standard_errors_cover_the_truth() {
    let runs = 40 * factor::<usize>();
    let scenarios = scenarios(runs, 50.0, "coulomb = 10.0");
    let summaries = in_parallel(&scenarios, run);
    let found = Parameter::ALL.map(|parameter| (parameter.name(), covered(&summaries, parameter)));
    println!("of {runs}: {found:?}");
    // They are on the safe side: up to four times as large as the errors turn out to be.
    for (name, covered) in found {
        assert!(10 * covered >= 9 * runs, "{name}: {covered} of {runs}");
    }
    for parameter in Parameter::ALL {
        let square = summaries.iter().map(|summary| {
            let estimate = summary.estimate(parameter).expect("estimated");
            let error = estimate.last - summary.truth.expect("known").get(parameter);
            (error / estimate.std_error.expect("the law has one")).powi(2)
        });
        let size = (square.sum::<f64>() / runs as f64).sqrt();
        println!(
            "{}: errors are {size:.2} of the standard errors",
            parameter.name()
        );
        assert!((0.2..1.0).contains(&size), "{}: {size}", parameter.name());
    }
}

#[test]
fn a_loop_without_derivative_action_is_identified_too() {
    let summary = run(&parse(
        "[plant]\na = 20.0\nb = 257.7\nload = 20.0\n[controller]\nkp = 2.0\nkd = 0.0\nki = 1.0\n\
         [identifier]\nlaw = \"gauss-newton\"\n",
    ));
    assert!(
        (summary.estimates.a.tail_mean - 20.0).abs() < 0.5,
        "{summary:?}"
    );
    assert!(
        (summary.estimates.b.tail_mean / 257.7 - 1.0).abs() < 0.01,
        "{summary:?}"
    );
}

#[test]
fn friction_that_is_known_can_be_given_and_kept() {
    let mut known = scenarios(2, 50.0, "coulomb = 10.0").remove(1);
    known.identifier.arithmetic = Arithmetic::F64;
    known.identifier.parameters.truncate(2);
    known.stated.identifier.initial.coulomb = Some(10.0);
    let found = run(&known).estimates;
    assert!((found.a.tail_mean - 0.2174).abs() < 0.01, "{found:?}");
    assert!((found.b.tail_mean / 257.7 - 1.0).abs() < 1e-3, "{found:?}");
    assert!(
        (found.load.tail_mean / 20.0 - 1.0).abs() < 0.02,
        "{found:?}"
    );
    let kept = found.coulomb.tail_mean - 10.0;
    assert!(
        kept.abs() < 1e-8 && found.coulomb.tail_std < 1e-9,
        "{found:?}"
    );
}
