//! From a data sheet to a scenario that is run and commissioned.

use std::path::PathBuf;

use crate::support::{argument, folder, printed, printed_json, refusal_message, servo_id};
use serde_json::Value;

fn done(arguments: &[&str]) -> String {
    printed(&servo_id(arguments))
}

fn json(arguments: &[&str]) -> Value {
    printed_json(&servo_id(arguments))
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// A small DC motor at 24 V, a servo motor behind its current loop, and a large geared axis.
const SHEETS: [&str; 3] = [
    "--voltage 24 --resistance 0.6 --torque-constant 0.05 --rotor-inertia 3e-5 --counts 4096 \
     --viscous 1e-5 --coulomb 5e-3",
    "--peak-current 10 --torque-constant 0.07 --rotor-inertia 6e-5 --load-inertia 1e-4 --counts 10000 \
     --coulomb 0.01",
    "--drive current --peak-current 30 --torque-constant 0.3 --rotor-inertia 5e-4 --load-inertia 2 \
     --gear 50 --counts 65536 --viscous 1e-3 --coulomb 0.1",
];

fn written(name: &str, sheet: &str) -> PathBuf {
    let file = folder(&format!("init-{name}")).join("servo.toml");
    let sheet: Vec<_> = sheet.split(' ').collect();
    done(&[&["init", &argument(&file)][..], &sheet].concat());
    file
}

#[test]
fn a_written_scenario_is_run_and_commissioned() {
    for name in SHEETS {
        let file = argument(&written("run", name));
        let run = json(&["run", &file, "--json", "-"]);
        assert_eq!(run["status"], "converged", "{name}: {}", run["reason"]);
        let error = number(&run["estimates"]["b"]["value"]) / number(&run["truth"]["b"]) - 1.0;
        assert!(error.abs() < 0.01, "{name}: {error}");
        let commissioned = json(&["commission", &file, "--json", "-"]);
        assert_eq!(
            commissioned["status"], "applied",
            "{name}: {}",
            commissioned["reason"]
        );
    }
}

#[test]
fn the_numbers_are_those_of_the_data_sheet() {
    let file = written("numbers", SHEETS[0]);
    let servo = &json(&["run", &argument(&file), "--json", "-"])["truth"];
    let near = |value: &Value, expected: f64| {
        assert!(
            (number(value) / expected - 1.0).abs() < 1e-5,
            "{value} {expected}"
        );
    };
    near(&servo["b"], 0.05 / (0.6 * 3e-5));
    near(&servo["a"], (1e-5 + 0.05 * 0.05 / 0.6) / 3e-5);
}

#[test]
fn the_examples_are_what_their_first_lines_say() {
    for name in ["dc_motor", "servo_motor"] {
        let file = format!(
            "{}/../../host-sim/scenarios/{name}.toml",
            env!("CARGO_MANIFEST_DIR")
        );
        let example = std::fs::read_to_string(file).expect("an example");
        let call = example
            .lines()
            .find_map(|line| line.strip_prefix("#   servo-id init "));
        let options: Vec<&str> = call.expect("a call").split(' ').skip(1).collect();
        let written = done(&[&["init", "-"], &options[..]].concat());
        assert!(example.ends_with(&written), "{name}:\n{written}");
    }
}

#[test]
fn missing_or_wrong_figures_are_named_and_nothing_is_written() {
    let file = folder("init-wrong").join("servo.toml");
    for (sheet, named) in [
        ("", "--drive"),
        (" --drive voltage", "--voltage"),
        (" --peak-current 3", "--torque-constant"),
        (
            " --peak-current 3 --torque-constant 0 --rotor-inertia 1e-5 --counts 4096",
            "--torque-constant 0",
        ),
    ] {
        let call = format!("init {}{sheet}", argument(&file));
        let answer = refusal_message(&servo_id(&call.split(' ').collect::<Vec<_>>()));
        assert!(answer.contains(named), "{answer}");
        assert!(!file.exists());
    }
}
