//! One fit to a whole log, from the command line.

use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;

use crate::support::{folder, printed_json, refusal_message, servo_id};

/// The trace of a simulated servo, and the scenario of the page on the fit.
fn trace(name: &str) -> (PathBuf, PathBuf) {
    trace_of(name, "")
}

/// The same of a servo with some effects, lines of `[plant]`.
fn trace_of(name: &str, effects: &str) -> (PathBuf, PathBuf) {
    trace_by(name, effects, "")
}

/// The same by an encoder with some errors, lines of `[encoder]`.
fn trace_by(name: &str, effects: &str, errors: &str) -> (PathBuf, PathBuf) {
    let folder = folder(&format!("fit-{name}"));
    let log = folder.join("trace.csv");
    let servo = include_str!("../../../../host-sim/scenarios/friction.toml");
    let own = folder.join("servo.toml");
    let table = "[plant]\n";
    let servo = servo.replace(table, &format!("{table}{effects}"));
    std::fs::write(&own, format!("{servo}[encoder]\n{errors}")).expect("written");
    let [own, path] = [&own, &log].map(|path| path.display().to_string());
    let output = servo_id(&["run", &own, "--csv", &path]);
    assert!(output.status.success());
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/fit.md");
    let page = std::fs::read_to_string(page).expect("the page is there");
    let example = page.split("```").nth(1).expect("an example");
    let scenario = folder.join("fit.toml");
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

#[test]
fn ripples_of_force_and_gain_have_orders_of_their_own() {
    let effects = "ripple = [0.0, 15.0]\nripple_order = 7\ntorque_ripple = [0.1, 0.0]\ntorque_ripple_order = 11\n";
    let (log, scenario) = trace_of("ripples", effects);
    let result = replayed(&log, &scenario);
    let mut orders = effects_of(&result, "order");
    orders.sort_unstable_by_key(|(name, _)| *name);
    let expected = [("ripple", Some(7.0)), ("torque-ripple", Some(11.0))];
    assert_eq!(orders, expected, "{result}");
    let [sine, cosine] =
        ["sine", "cosine"].map(|axis| number(&result, &format!("/estimates/ripple-{axis}/value")));
    assert!(
        (sine.hypot(cosine) / 15.0 - 1.0).abs() < 0.02,
        "{sine} {cosine}"
    );
}

/// The effects of a result, each with the size of a name where it has one.
fn effects_of<'a>(result: &'a Value, size: &str) -> Vec<(&'a str, Option<f64>)> {
    let effects = result["fit"]["effects"].as_array().expect("a list");
    let of = |effect: &'a Value| Some((effect["name"].as_str()?, effect["sizes"][size].as_f64()));
    effects.iter().filter_map(of).collect()
}

#[test]
fn an_encoder_off_its_centre_is_found_with_its_error() {
    let further =
        "[excitation]\nkind = \"multisine\"\namplitudes = [1.5, 0.5]\nfrequencies = [4.0, 11.0]\n";
    let errors = format!("eccentricity = 0.005\n{further}");
    let (log, scenario) = trace_by("eccentric", "", &errors);
    let result = replayed(&log, &scenario);
    let [sine, cosine] = ["sine_rad", "cosine_rad"].map(|size| {
        let [("eccentricity", Some(size))] = effects_of(&result, size)[..] else {
            panic!("{result}")
        };
        size
    });
    assert!((sine / 0.005 - 1.0).abs() < 0.03, "{sine}");
    assert!(cosine.abs() < 2e-4, "{cosine}");
    let b = number(&result, "/estimates/b/value");
    assert!((b / 257.7 - 1.0).abs() < 2e-3, "{b}");
}

#[test]
fn instants_that_are_uneven_are_found_with_their_deviation_and_a_noise_is_not_one() {
    let (log, scenario) = trace_by("jitter", "", "jitter = 0.1\n");
    let result = replayed(&log, &scenario);
    let [("jitter", Some(deviation))] = effects_of(&result, "deviation_s")[..] else {
        panic!("{result}")
    };
    assert!((deviation / 1e-4 - 1.0).abs() < 0.1, "{deviation}");
    let (log, scenario) = trace_by("noisy", "", "noise = 0.002\n");
    let result = replayed(&log, &scenario);
    assert_eq!(result["fit"]["effects"], Value::Array(Vec::new()));
}

#[test]
fn friction_that_drifts_is_one_effect() {
    let (log, scenario) = trace_of("drift", "friction_drift = -0.05\n");
    let result = replayed(&log, &scenario);
    let [("friction-drift", Some(size))] = effects_of(&result, "size")[..] else {
        panic!("{result}")
    };
    // Of the middle's friction over the 8 s of the run.
    assert!((size / (-0.4 / 0.8) - 1.0).abs() < 0.1, "{size}");
}

#[test]
fn a_delay_is_an_effect_that_the_record_shows() {
    let (log, scenario) = trace_of("delayed", "delay = 0.0015\n");
    let result = replayed(&log, &scenario);
    assert_eq!(effects_of(&result, "size"), [("delay", None)], "{result}");
    let delay = number(&result, "/estimates/delay/value");
    assert!((delay / 0.0015 - 1.0).abs() < 0.02, "{delay}");
}

#[test]
fn the_end_of_a_long_log_is_fitted_and_the_result_states_it() {
    let (short, scenario) = trace("long");
    let whole = replayed(&short, &scenario);
    assert_eq!(whole["fit"]["samples"], whole["samples"]);
    let servo = include_str!("../../../../host-sim/scenarios/friction.toml");
    let longer = servo.replace("duration = 8.0", "duration = 140.0");
    assert_ne!(servo, longer);
    let own = short.with_file_name("long.toml");
    std::fs::write(&own, longer).expect("written");
    let [own, log, scenario] =
        [own, short.with_file_name("long.csv"), scenario].map(|path| path.display().to_string());
    assert!(servo_id(&["run", &own, "--csv", &log]).status.success());
    let output = servo_id(&["identify", &log, "--scenario", &scenario]);
    let answer = String::from_utf8_lossy(&output.stdout);
    let stated = "The last 131072 of 140000 samples were fitted";
    assert!(answer.contains(stated), "{answer}");
}

#[test]
fn a_reversed_or_foreign_command_is_refused() {
    let (log, scenario) = trace("reversed");
    with_commands(&log, |commands| {
        commands.iter_mut().for_each(|command| *command = -*command);
    });
    assert!(refused(&log, &scenario).contains("command_scale"));
    with_commands(&log, |commands| {
        let half = commands.len() / 2;
        commands.rotate_left(half);
    });
    let foreign = refused(&log, &scenario);
    assert!(foreign.contains("command"), "{foreign}");
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
    let reason = result["reason"].as_str().expect("text");
    assert!(reason.contains("low-speed"), "{reason}");
}

#[test]
fn a_required_term_without_its_setting_is_refused() {
    let (log, scenario) = trace("without-setting");
    with_keys(&scenario, "required_terms = [\"ripple\"]");
    assert!(refused(&log, &scenario).contains("identifier.ripple_order"));
}
