//! One fit to a whole log, from the command line.

use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;

use crate::support::{argument, assert_done, folder, printed_json, refusal_message, servo_id};

/// The trace of a simulated servo, and the scenario of the page on the fit.
fn trace(name: &str) -> (PathBuf, PathBuf) {
    let folder = folder(&format!("fit-{name}"));
    let [log, scenario] = ["trace.csv", "fit.toml"].map(|name| folder.join(name));
    let own = crate::support::scenario("friction.toml");
    assert_done(&servo_id(&["run", &own, "--csv", &argument(&log)]));
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/fit.md");
    let page = std::fs::read_to_string(page).expect("the page is there");
    let example = page.split("```").nth(1).expect("an example");
    std::fs::write(&scenario, example.trim_start_matches("toml")).expect("written");
    (log, scenario)
}

fn replay(log: &Path, scenario: &Path) -> Output {
    let [log, scenario] = [log, scenario].map(|path| path.display().to_string());
    servo_id(&["identify", &log, "--scenario", &scenario, "--json", "-"])
}

fn replayed(log: &Path, scenario: &Path) -> Value {
    printed_json(&replay(log, scenario))
}

/// The message about a log that the program refuses to identify.
fn refused(log: &Path, scenario: &Path) -> String {
    refusal_message(&replay(log, scenario))
}

/// Changes the commands of a trace.
fn with_commands(log: &Path, change: impl FnOnce(&mut Vec<f64>)) {
    let text = std::fs::read_to_string(log).expect("a trace");
    let mut rows: Vec<Vec<String>> = text
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect();
    let place = rows[0].iter().position(|name| name == "command");
    let place = place.expect("a column of commands");
    let mut commands: Vec<f64> = rows[1..]
        .iter()
        .map(|row| row[place].parse().expect("a number"))
        .collect();
    change(&mut commands);
    for (row, command) in rows[1..].iter_mut().zip(commands) {
        row[place] = command.to_string();
    }
    let lines: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    std::fs::write(log, lines.join("\n") + "\n").expect("written");
}

fn number(result: &Value, pointer: &str) -> f64 {
    let value = result.pointer(pointer).and_then(Value::as_f64);
    value.unwrap_or_else(|| panic!("no {pointer} in {result}"))
}

#[test]
fn a_log_is_identified_without_a_first_guess() {
    let (log, scenario) = trace("plain");
    let result = replayed(&log, &scenario);
    assert_eq!(result["status"], "converged", "{}", result["reason"]);
    let off = |name: &str, truth: f64| {
        let value = number(&result, &format!("/estimates/{name}/value"));
        let error = number(&result, &format!("/estimates/{name}/std_error"));
        assert!(
            (value - truth).abs() < 4.0 * error,
            "{name} {value} ± {error}"
        );
        value / truth - 1.0
    };
    assert!(off("b", 257.7).abs() < 2e-3);
    assert!(off("coulomb", 10.0).abs() < 0.01);
    let noise = number(&result, "/noise/moving_counts");
    assert!((0.25..0.35).contains(&noise), "{noise}");
    assert_eq!(result["fit"]["effects"], Value::Array(Vec::new()));
    assert!(result["fit"]["command_recorded_late"].is_null());
}

#[test]
fn a_command_that_was_recorded_a_row_late_is_shifted_back_and_said() {
    let (log, scenario) = trace("late");
    with_commands(&log, |commands| commands.rotate_right(1));
    let result = replayed(&log, &scenario);
    let late = number(&result, "/fit/command_recorded_late");
    assert!((late - 1.0).abs() < 0.05, "{late}");
    let coulomb = number(&result, "/estimates/coulomb/value");
    assert!((coulomb - 10.0).abs() < 0.5, "{coulomb}");
    assert_eq!(result["status"], "converged", "{}", result["reason"]);
}

/// With the servo as the model, only the quantisation of the encoder is left, sample by sample; of one with another
/// gain more.
#[test]
fn what_a_model_leaves_of_every_sample_is_beside_it() {
    let (log, scenario) = trace("left");
    let left = |scenario: &Path| -> f64 {
        let rows = log.with_file_name("beside.csv");
        let [log, scenario, rows] = [&log, scenario, &rows].map(argument);
        let call = [
            "identify",
            &log,
            "--scenario",
            &scenario,
            "--csv",
            &rows,
            "--force",
        ];
        assert_done(&servo_id(&call));
        let text = std::fs::read_to_string(&rows).expect("rows");
        let mut lines = text
            .lines()
            .map(|line| line.split(',').nth(4).expect("a cell"));
        assert_eq!(lines.next(), Some("output_error_rad"));
        let errors: Vec<f64> = lines.flat_map(str::parse).collect();
        assert!(errors.len() > 7500, "{} of 8000", errors.len());
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        (squares / errors.len() as f64).sqrt() * 10_000.0 / std::f64::consts::TAU
    };
    let counts = left(&scenario);
    assert!((0.27..0.35).contains(&counts), "{counts}");
    // A delay that changes in the middle is none that a model has.
    with_commands(&log, |commands| {
        let half = commands.len() / 2;
        commands[half..].rotate_right(6);
    });
    let counts = left(&scenario);
    assert!(counts > 0.5, "{counts}");
}

#[test]
fn all_of_a_long_log_is_fitted_and_tells_no_less() {
    let (short, scenario) = trace("long");
    let whole = replayed(&short, &scenario);
    assert_eq!(whole["fit"]["samples"], whole["samples"]);
    let servo = include_str!("../../../../host-sim/scenarios/friction.toml");
    let longer = servo.replace("duration = 8.0", "duration = 140.0");
    assert_ne!(servo, longer);
    let own = short.with_file_name("long.toml");
    std::fs::write(&own, longer).expect("written");
    let log = short.with_file_name("long.csv");
    let call = ["run", &argument(&own), "--csv", &argument(&log)];
    assert_done(&servo_id(&call));
    let long = replayed(&log, &scenario);
    assert_eq!(long["fit"]["samples"], 140_000, "{}", long["fit"]);
    let off = |result: &Value| (number(result, "/estimates/b/value") / 257.7 - 1.0).abs();
    let error = |result: &Value| number(result, "/estimates/b/std_error");
    assert!(off(&long) < 1e-4, "{} of {}", off(&long), off(&whole));
    assert!(
        error(&long) <= 1.05 * error(&whole),
        "{} of {}",
        error(&long),
        error(&whole)
    );
}

#[test]
fn a_reversed_or_foreign_command_is_not_converged() {
    let (log, scenario) = trace("reversed");
    with_commands(&log, |commands| {
        commands.iter_mut().for_each(|command| *command = -*command);
    });
    assert_ne!(replayed(&log, &scenario)["status"], "converged");
    with_commands(&log, |commands| {
        let half = commands.len() / 2;
        commands.rotate_left(half);
    });
    assert_ne!(replayed(&log, &scenario)["status"], "converged");
}

/// The scenario of the page with further keys of the identifier.
fn with_keys(scenario: &Path, keys: &str) {
    let text = std::fs::read_to_string(scenario).expect("written");
    let law = "law = \"fit\"";
    std::fs::write(scenario, text.replace(law, &format!("{law}\n{keys}"))).expect("written");
}

#[test]
fn a_required_term_is_in_the_model_without_evidence() {
    let (log, scenario) = trace("required");
    assert!(replayed(&log, &scenario)["estimates"]["asymmetry"].is_null());
    with_keys(&scenario, "required_terms = [\"asymmetry\"]");
    let result = replayed(&log, &scenario);
    assert_eq!(result["status"], "converged", "{}", result["reason"]);
    let size = number(&result, "/estimates/asymmetry/value");
    let error = number(&result, "/estimates/asymmetry/std_error");
    assert!(size.abs() < 4.0 * error && error < 0.1, "{size} ± {error}");
}

#[test]
fn a_required_term_that_the_motion_does_not_show_is_the_reason_of_the_status() {
    let (log, scenario) = trace("not-entered");
    // No sample is as slow.
    with_keys(
        &scenario,
        "required_terms = [\"low-speed\"]\nlow_speed_velocity = 1e-12",
    );
    let result = replayed(&log, &scenario);
    assert_eq!(
        (&result["status"], &result["code"]),
        (&"no-information".into(), &29.into())
    );
}

#[test]
fn a_required_term_without_its_setting_is_refused() {
    let (log, scenario) = trace("without-setting");
    with_keys(&scenario, "required_terms = [\"ripple\"]");
    assert!(refused(&log, &scenario).contains("identifier.ripple_order"));
}
