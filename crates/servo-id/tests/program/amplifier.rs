//! An amplifier's delay and current loop, declared and not: every law with a model takes them.

use host_sim::scenario::{Purpose, Scenario};
use host_sim::simulate;
use identifier_core::parameters::ServoParameters;

const SERVO: &str = "[plant]\na = 0.2174\nb = 257.7\ncoulomb = 10.0\nload = 20.0\n\
                     delay = 0.0016\ncurrent_loop = 0.001\n[run]\nduration = 20.0\n";
const BOX: &str = "plant_box = { a = [0.0, 50.0], b = [150.0, 1000.0] }";

fn scenario(law: &str, amplifier: &str, keys: &str) -> Result<Scenario, String> {
    let text = format!(
        "{SERVO}[amplifier]\n{amplifier}\n[identifier]\nlaw = \"{law}\"\n{keys}\n\
         parameters = [\"a\", \"b\", \"coulomb\"]\n"
    );
    Scenario::parse("s.toml", &text, Purpose::Run).map_err(|error| error.to_string())
}

/// The estimates at the end.
fn found(law: &str, amplifier: &str, keys: &str) -> ServoParameters {
    let mut last = None;
    let scenario = scenario(law, amplifier, keys).unwrap_or_else(|error| panic!("{error}"));
    simulate::run(&scenario, &mut |sample| {
        last = Some(sample.estimates);
    })
    .expect("it can be built");
    last.expect("a sample")
}

/// Relative errors of b and c.
fn off(found: &ServoParameters) -> [f64; 2] {
    [found.b / 257.7 - 1.0, found.coulomb / 10.0 - 1.0].map(f64::abs)
}

#[test]
fn a_declared_amplifier_acts_for_every_law() {
    let declared = "delay = 0.0016\ncurrent_loop = 0.001";
    for (law, keys) in [("gradient", BOX), ("gauss-newton", "")] {
        let [b, c] = off(&found(law, declared, keys));
        assert!(b < 0.005 && c < 0.05, "{law}: {b} {c}");
        let [_, without] = off(&found(law, "", keys));
        assert!(without > 0.2, "{law}: {without}");
    }
}

#[test]
fn the_delay_is_found_besides_the_declared_current_loop() {
    let keys = "required_terms = [\"delay\"]";
    let [b, c] = off(&found("gauss-newton", "current_loop = 0.001", keys));
    assert!(b < 0.005 && c < 0.05, "{b} {c}");
}

#[test]
fn fixed_point_refuses_a_declared_delay() {
    let keys = format!("arithmetic = \"fixed\"\n{BOX}");
    let answer = scenario("gradient", "delay = 0.001", &keys).expect_err("refused");
    assert!(answer.contains("amplifier.delay"), "{answer}");
    assert!(answer.contains("fixed point"), "{answer}");
}
