//! A replay reads a run's own trace: with the same scenario it gives the same estimates.

use crate::support::{Folder, estimate, own_folder, scenario_text};
use serde_json::Value;

const SCENARIOS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../host-sim/scenarios");

/// The results of a run of `scenario.toml` and of a replay of its trace, without where they are from.
fn run_and_replay(folder: &Folder) -> [Value; 2] {
    let calls = [
        "run scenario.toml --csv log.csv --force",
        "identify log.csv --scenario scenario.toml",
    ];
    calls.map(|call| {
        let mut result = folder.json(call);
        result["origin"].take();
        result
    })
}

/// Asserts that a replay gives what the run gave, to the last bit. A replay has logs and, where the loop is the declared
/// controller's, its agreement with the recorded command; a run has neither.
fn assert_replays(scenario: &str) {
    let folder = own_folder();
    folder.write("scenario.toml", scenario);
    let [first, mut second] = run_and_replay(&folder);
    let agreement = second["agreement"].take();
    second["logs"] = Value::Array(Vec::new());
    assert_eq!(first, second, "{scenario}");
    // A relay is not the declared controller.
    let compared = !scenario.contains("law = \"relay-");
    let holds = agreement["holds"].as_bool();
    assert_eq!(holds, compared.then_some(true), "{scenario}: {agreement}");
}

/// A scenario of a servo with friction and load, with these lines for its identifier and after them.
fn scenario(rest: &str) -> String {
    format!(
        "[plant]\na = 0.2174\nb = 257.7\nload = 20.0\ncoulomb = 10.0\n\
         [run]\nduration = 8.0\n[identifier]\n{rest}\n"
    )
}

const FITTED: &str = "law = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]";
const GRADIENT: &str = "law = \"gradient\"\nparameters = [\"a\", \"b\", \"coulomb\"]\n\
                        servo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }";
const FIXED: &str = "law = \"gradient\"\nparameters = [\"a\", \"b\", \"coulomb\"]\n\
                     servo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }\narithmetic = \"fixed\"";
/// So low that the first command is cut off, and many later ones.
const TIGHT: &str = "[amplifier]\nlimit = 1.0";

#[test]
fn every_scenario_of_the_repository_replays_its_own_log_to_the_last_bit() {
    let mut replayed = 0;
    for entry in std::fs::read_dir(SCENARIOS).expect("the scenarios are there") {
        let name = entry.expect("an entry").file_name();
        let text = scenario_text(name.to_str().expect("a name"));
        if text.contains("[plant]") {
            assert_replays(&text);
            replayed += 1;
        }
    }
    assert!(replayed >= 7, "{replayed}");
}

#[test]
fn a_saturated_first_command_and_every_estimator_and_number_format_replay_to_the_last_bit() {
    let double = format!("{FITTED}\narithmetic = \"f64\"");
    let pd = "law = \"pd-gradient\"\nservo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }";
    let relay = "law = \"relay-least-squares\"\nrelay = 0.9";
    for identifier in [FITTED, &double, GRADIENT, FIXED, pd, relay] {
        assert_replays(&scenario(&format!("{identifier}\n{TIGHT}")));
    }
}

/// The position of an ideal sensor is no whole number of counts: single precision rounds its increments
/// a little differently.
#[test]
fn an_ideal_sensors_log_gives_the_same_estimates() {
    let folder = own_folder();
    let text = scenario(&format!("{FITTED}\n[encoder]\ncounts_per_rev = 0"));
    folder.write("scenario.toml", text);
    let both = run_and_replay(&folder);
    for name in ["a", "b", "coulomb", "load"] {
        let [first, second] = both.each_ref().map(|result| estimate(result, name));
        let off = (first - second).abs();
        assert!(
            off < 1e-4 * (1.0 + first.abs()),
            "{name}: {first}, {second}"
        );
    }
}
