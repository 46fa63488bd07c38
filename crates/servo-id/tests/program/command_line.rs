//! The contract of the command line: exit status, files, messages.

use std::path::Path;
use std::process::Command;

use crate::support::{
    assert_done, folder, printed, printed_json, refusal_message, servo_id, standard_error,
};
use host_sim::scenario::keys::KEYS;
use servo_id::paper::PROPOSED;

fn scenario(folder: &Path, text: &str) -> String {
    let path = folder.join("scenario.toml");
    std::fs::write(&path, text).expect("the scenario is written");
    path.display().to_string()
}

fn short(text: &str) -> String {
    text.replace("duration = 60.0", "duration = 10.0")
}

/// Message about a wrong scenario: exit status 2, nothing on standard output, no file.
fn refusal(test: &str, text: &str) -> String {
    let folder = folder(test);
    let scenario = scenario(&folder, text);
    let json = folder.join("result.json");
    let output = servo_id(&["run", &scenario, "--json", &json.display().to_string()]);
    assert!(!json.exists(), "no partial output");
    refusal_message(&output)
}

/// The paper's scenario with one text changed is refused, with the line of the change, the key and
/// a part of the message.
fn assert_refused(test: &str, (from, to): (&str, &str), key: &str, message: &str) {
    let text = PROPOSED.replace(from, to);
    assert_ne!(text, PROPOSED, "{test}");
    let changed = text.lines().position(|line| line.contains(to));
    let line = 1 + changed.expect("the change is there");
    let answer = refusal(test, &text);
    let place = format!("scenario.toml:{line}: {key}");
    assert!(answer.contains(&place), "{test}: {answer}");
    assert!(answer.contains(message), "{test}: {answer}");
}

#[test]
fn the_minimal_scenario_runs_in_fixed_point_too() {
    let folder = folder("minimal-in-words");
    let minimal = include_str!("../../../../host-sim/scenarios/minimal.toml");
    let file = folder.join("minimal.toml");
    let name = file.display().to_string();
    std::fs::write(&file, minimal).expect("it is written");
    let output = servo_id(&["run", &name, "--formats"]);
    assert_done(&output);
    let fixed = minimal.replace("[identifier]", "[identifier]\narithmetic = \"fixed\"");
    assert_ne!(fixed, minimal);
    std::fs::write(&file, fixed).expect("it is written");
    let output = servo_id(&["run", &name, "--json", "-"]);
    let result = printed_json(&output);
    assert_eq!(result["arithmetic"], "fixed");
    assert_eq!(result["status"], "converged", "{result}");
}

#[test]
fn an_unknown_value_is_a_dash() {
    let folder = folder("not-known");
    let file = folder.join("still.toml");
    std::fs::write(
        &file,
        "[plant]\na = 1.0\nb = 100.0\n[excitation]\nkind = \"none\"\n[identifier]\nlaw = \"gauss-newton\"\n\
         [run]\nduration = 1.0\n",
    )
    .expect("it is written");
    let output = servo_id(&["run", &file.display().to_string()]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("\nno-information: "), "{text}");
    assert!(!text.contains('±'), "{text}");
    for quantity in [" a  ", " b  "] {
        let row = text.lines().find(|line| line.starts_with(quantity));
        let estimate = row.and_then(|row| row.split_whitespace().nth(1));
        assert_eq!(estimate, Some("–"), "{text}");
    }
}

#[test]
fn run_writes_json_csv_and_pictures() {
    let folder = folder("outputs");
    let scenario = scenario(&folder, &short(PROPOSED));
    for picture in ["plot.png", "plot.svg"] {
        let [json, csv, plot] = ["result.json", "trace.csv", picture]
            .map(|name| folder.join(name).display().to_string());
        let output = servo_id(&[
            "run", &scenario, "--json", &json, "--csv", &csv, "--plot", &plot, "--force",
        ]);
        assert_done(&output);
        let csv = std::fs::read_to_string(csv).expect("the trace is written");
        assert_eq!(csv.lines().count(), 10_001);
        assert!(csv.starts_with("time_s,reference_rad,position_rad,command,"));
        let picture = std::fs::read(plot).expect("the picture is written");
        assert!(picture.starts_with(b"\x89PNG") || picture.starts_with(b"<svg"));
    }
}

#[test]
fn json_on_standard_output_is_alone_and_has_the_promised_keys() {
    let folder = folder("json");
    let scenario = scenario(&folder, &short(PROPOSED));
    let output = servo_id(&["run", &scenario, "--json", "-"]);
    assert_eq!(output.status.code(), Some(0));
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).expect("only JSON");
    assert_eq!(result["law"], "gradient");
    assert_eq!(result["arithmetic"], "f32");
    assert_eq!(result["samples"], 10_000);
    assert_eq!(result["status"], "converged", "{}", result["reason"]);
    assert_eq!(result["code"], 0);
    assert!(result["cause"].is_null());
    assert!(result["obstacle"].is_null());
    assert!((result["sample_time"].as_f64().expect("number") - 1e-3).abs() < 1e-15);
    for parameter in ["a", "b", "load"] {
        let estimate = &result["estimates"][parameter];
        for key in ["value", "tail_std", "std_error"] {
            assert!(estimate[key].is_f64(), "estimates.{parameter}.{key}");
        }
        assert_eq!(estimate["at_bound"], false);
        assert!(estimate["unit"].is_string());
    }
    assert!(result["estimates"]["coulomb"].is_null());
    for parameter in ["a", "b", "coulomb", "load"] {
        assert!(result["truth"][parameter].is_f64(), "truth.{parameter}");
    }
    for key in [
        "slowed_samples",
        "model_restarts",
        "standing_samples",
        "load_steps",
        "not_following_samples",
    ] {
        assert!(result[key].is_u64(), "{key}");
    }
    assert!(result["agreement"].is_null());
    for key in ["rms", "max"] {
        assert!(result["output_error"][key].is_f64(), "output_error.{key}");
    }
    for key in ["a", "b"] {
        assert!(result["settling_time"][key].is_f64(), "settling_time.{key}");
    }
}

#[test]
fn without_a_verb_the_papers_table_is_printed_and_paper_writes_to_the_given_folder() {
    let folder = folder("paper");
    let output = Command::new(env!("CARGO_BIN_EXE_servo-id"))
        .current_dir(&folder)
        .output()
        .expect("the program starts");
    assert_done(&output);
    let text = String::from_utf8(output.stdout).expect("text");
    for row in [
        "proposed, d = 0",
        "proposed, d ≠ 0",
        "least squares, d = 0",
        "least squares, d ≠ 0",
    ] {
        assert!(text.contains(row), "{text}");
    }
    assert!(text.contains("`servo-id paper` draws Fig. 03"), "{text}");
    let left = std::fs::read_dir(&folder).expect("a folder").count();
    assert_eq!(left, 0, "nothing was asked for, and nothing is written");

    let elsewhere = folder.join("elsewhere");
    let output = servo_id(&["paper", "--out", &elsewhere.display().to_string()]);
    assert_eq!(output.status.code(), Some(0));
    for file in [
        "figure-03.png",
        "proposed-balanced.csv",
        "least-squares-unbalanced.json",
    ] {
        assert!(elsewhere.join(file).exists(), "{file}");
    }
}

#[test]
fn unknown_key_is_answered_with_file_line_key_and_the_known_keys() {
    let text = PROPOSED.replace("load = 0.0", "laod = 0.0");
    let line = 1 + text
        .lines()
        .position(|line| line.starts_with("laod"))
        .expect("there");
    let answer = refusal("unknown-key", &text);
    assert!(
        answer.contains(&format!("scenario.toml:{line}: plant.laod")),
        "{answer}"
    );
    assert!(answer.contains("a, b, load"), "{answer}");

    let answer = refusal("unknown-table", &format!("{PROPOSED}\n[motor]\nx = 1\n"));
    assert!(answer.contains(": motor: "), "{answer}");
    assert!(answer.contains("plant, encoder, amplifier"), "{answer}");
}

#[test]
fn wrong_type_is_answered_with_file_line_key_and_what_is_allowed() {
    for (test, from, to, key, allowed) in [
        (
            "type-number",
            "kp = 9.0",
            "kp = \"nine\"",
            "controller.kp",
            "a number above 0",
        ),
        (
            "type-inline",
            "cutoff = 500.0",
            "cutoff = true",
            "controller.velocity_filter.cutoff",
            "pi/sample_time",
        ),
        (
            "type-row",
            "gamma = [0.2, 110.0]",
            "gamma = \"large\"",
            "identifier.gamma",
            "[g_a, g_b, ..]",
        ),
        (
            "type-seed",
            "seed = 1212121",
            "seed = -1",
            "excitation.seed",
            "from 0 to 4294967295",
        ),
        (
            "type-name",
            "law = \"gradient\"",
            "law = \"magic\"",
            "identifier.law",
            "\"relay-least-squares\"",
        ),
        (
            "type-list",
            "parameters = [\"a\", \"b\"]",
            "parameters = [\"a\", \"z\"]",
            "identifier.parameters",
            "[\"a\", \"b\"]",
        ),
    ] {
        assert_refused(test, (from, to), key, allowed);
    }
}

#[test]
fn missing_value_is_answered_with_its_key_and_what_is_allowed() {
    let answer = refusal("missing-key", &PROPOSED.replace("b = 257.7", "# none"));
    assert!(
        answer.contains("plant.b") && answer.contains("a number above 0"),
        "{answer}"
    );
    let answer = refusal("missing-table", "[run]\nduration = 1.0\n");
    assert!(
        answer.contains("plant") && answer.contains("allowed"),
        "{answer}"
    );
    let prbs = "[plant]\na = 1.0\nb = 100.0\n[excitation]\nkind = \"prbs\"\nhold = 0.1\n";
    let answer = refusal("missing-amplitude", prbs);
    assert!(
        answer.contains("scenario.toml:4: excitation.amplitude"),
        "{answer}"
    );
}

#[test]
fn value_out_of_range_is_answered_with_line_key_value_and_range() {
    for (test, from, to, key, message) in [
        (
            "range-sample-time",
            "sample_time = 0.001 ",
            "sample_time = 0.0 ",
            "controller.sample_time",
            "sample_time = 0",
        ),
        (
            "range-nan",
            "kd = 0.19",
            "kd = nan",
            "controller.kd",
            "kd = NaN",
        ),
        (
            "range-cutoff",
            "cutoff = 500.0",
            "cutoff = 4000.0",
            "controller.velocity_filter.cutoff",
            "below 3141.59",
        ),
        (
            "range-b",
            "b = [5.0, 5000.0]",
            "b = [0.0, 5000.0]",
            "identifier.bounds.b",
            "above 0",
        ),
        (
            "range-order",
            "a = [0.0, 100.0]",
            "a = [3.0, 1.0]",
            "identifier.bounds.a",
            "at least 3",
        ),
        (
            "range-gamma",
            "gamma = [0.2, 110.0]",
            "gamma = [[1.0, 2.0], [2.0, 1.0]]",
            "identifier.gamma",
            "not positive definite",
        ),
        (
            "range-symmetry",
            "gamma = [0.2, 110.0]",
            "gamma = [[1.0, 0.2], [0.1, 1.0]]",
            "identifier.gamma",
            "not symmetric",
        ),
        (
            "range-mu",
            "mu = 10.0",
            "mu = 12.0",
            "identifier.mu",
            "mu < (a_min + b_min kd)/2 fails",
        ),
        (
            "range-kp",
            "kp = 9.0",
            "kp = 2.0",
            "controller.kp",
            "kp > ki/mu + mu (kd + a_max/b_min)/2 fails",
        ),
        (
            "range-hold",
            "sample_time = 0.1",
            "sample_time = 0.1005",
            "excitation.sample_time",
            "a whole multiple of 0.001, such as 0.1 or 0.101",
        ),
        (
            "range-limit",
            "limit = 10.0",
            "limit = [1.0, 2.0]",
            "amplifier.limit",
            "limit_low = 1",
        ),
        (
            "range-stranger",
            "power = 0.005",
            "period = 1.0",
            "excitation.period",
            "does not take this key",
        ),
        (
            "range-duration",
            "duration = 60.0",
            "duration = -1.0",
            "run.duration",
            "duration = -1",
        ),
        (
            "range-counts",
            "counts_per_rev = 10000",
            "counts_per_rev = -5",
            "encoder.counts_per_rev",
            "from 0 to 1e9",
        ),
    ] {
        assert_refused(test, (from, to), key, message);
    }
}

/// An estimate at its bound is not identified, even if it is constant.
#[test]
fn an_estimate_at_a_bound_is_no_result() {
    let folder = folder("bound");
    let text = short(PROPOSED).replace("b = [5.0, 5000.0]", "b = [5.0, 200.0]");
    let scenario = scenario(&folder, &text);
    let output = servo_id(&["run", &scenario, "--json", "-"]);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(result["estimates"]["b"]["at_bound"], true, "{result}");
    assert_eq!(result["status"], "no-information");
    assert_eq!(result["code"], 24);
    let reason = result["reason"].as_str().expect("text");
    assert!(
        reason.starts_with("b = ") && reason.contains("stands at a bound"),
        "{reason}"
    );
}

/// Numbers in a table of their own are found by key and judged as everything else.
#[test]
fn correction_and_largest_speed_are_judged_by_key() {
    let mu = "mu = 10.0";
    for (test, to, key, message) in [
        (
            "correction-kp",
            "correction = { kp = 0.0, kd = 0.1, ki = 1.0 }",
            "identifier.correction.kp",
            "kp = 0",
        ),
        (
            "correction-part",
            "correction = { kp = 9.0, kd = 0.1 }",
            "identifier.correction.ki",
            "missing",
        ),
        (
            "max-speed",
            "max_speed = -1.0",
            "identifier.max_speed",
            "above 0",
        ),
        (
            "bandwidth",
            "bandwidth = 0.0",
            "identifier.bandwidth",
            "above 0",
        ),
        (
            "noise",
            "noise = 1e-3",
            "identifier.noise",
            "does not take this key",
        ),
    ] {
        let text = PROPOSED.replace(mu, &format!("{mu}\n{to}"));
        let answer = refusal(test, &text);
        assert!(
            answer.contains(key) && answer.contains(message),
            "{test}: {answer}"
        );
    }
    // A servo that is declared slower than it is: the run ends where the speed exceeds the declaration.
    let folder = folder("max-speed-run");
    let text = short(PROPOSED).replace(mu, &format!("{mu}\nmax_speed = 1.0"));
    let scenario = scenario(&folder, &text);
    let output = servo_id(&["run", &scenario, "--json", "-"]);
    assert_eq!(output.status.code(), Some(1));
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(result["status"], "aborted");
    let reason = result["reason"].as_str().expect("text");
    assert!(
        reason.contains("jumped further than the servo can move"),
        "{reason}"
    );
}

/// The paper's scenario with a law that fits and one more line for it.
fn with_fit(law: &str, line: &str) -> String {
    let gradient = "law = \"gradient\"\ngamma = [0.2, 110.0]\nmu = 10.0";
    let text = PROPOSED.replace(gradient, &format!("law = \"{law}\"\n{line}"));
    let assumed = |line: &&str| !line.starts_with("plant_box") && !line.starts_with("initial");
    text.lines()
        .filter(assumed)
        .map(|line| format!("{line}\n"))
        .collect()
}

#[test]
fn a_first_fit_has_a_shortest_and_a_longest_time() {
    for length in ["1e-5", "2e4"] {
        let text = with_fit("gauss-newton", &format!("start_time = {length}"));
        let answer = refusal(&format!("first-fit-{length}"), &text);
        assert!(answer.contains("identifier.start_time"), "{answer}");
        assert!(answer.contains("from 0.0001 to 10000"), "{answer}");
    }
}

#[test]
fn what_is_gone_is_refused_with_what_replaces_it() {
    for (law, line, remedy) in [
        ("window", "", "law = \"gauss-newton\""),
        ("gauss-newton", "terms = [\"delay\"]", "required_terms"),
        (
            "gauss-newton",
            "required_terms = [\"wandering-load\"]",
            "law = \"fit\"",
        ),
    ] {
        let answer = refusal("gone", &with_fit(law, line));
        assert!(answer.contains(remedy), "{answer}");
    }
}

#[test]
fn a_memory_is_for_gauss_newton_alone_and_not_too_short() {
    let answer = refusal("memory-short", &with_fit("gauss-newton", "memory = 0.5"));
    assert!(answer.contains("identifier.memory"), "{answer}");
    let text = with_fit("fit", "memory = 5.0");
    let text = text.replace("[\"a\", \"b\"]", "[\"a\", \"b\", \"coulomb\", \"load\"]");
    let answer = refusal("memory-fit", &text);
    assert!(answer.contains("does not take this key"), "{answer}");
}

#[test]
fn a_gain_that_is_not_identified_must_be_given() {
    let text = with_fit("gauss-newton", "").replace("[\"a\", \"b\"]", "[\"a\"]");
    let answer = refusal("unknown-gain", &text);
    assert!(answer.contains("identifier.initial.b"), "{answer}");
}

#[test]
fn files_that_are_not_scenarios_are_refused() {
    assert!(refusal("broken", "[plant\na = 1").contains("scenario.toml:1"));
    let output = servo_id(&["run", "no-such-file.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(standard_error(&output).contains("no-such-file.toml"));
    let folder = folder("format");
    let scenario = scenario(&folder, PROPOSED);
    let output = servo_id(&["run", &scenario, "--plot", "picture.gif"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(standard_error(&output).contains(".png or .svg"));
    assert_eq!(servo_id(&["no-such-verb"]).status.code(), Some(2));
}

#[test]
fn places_that_cannot_be_written_are_bad_input() {
    let folder = folder("unwritable");
    let scenario = scenario(&folder, &short(PROPOSED));
    let nowhere = folder
        .join("no/such/folder/result.json")
        .display()
        .to_string();
    let output = servo_id(&["run", &scenario, "--json", &nowhere]);
    assert_eq!(output.status.code(), Some(2));
    assert!(standard_error(&output).contains("result.json"));
}

#[test]
fn every_kind_of_reference_runs() {
    let folder = folder("references");
    for table in [
        "kind = \"prbs\"\namplitude = 0.2\nhold = 0.05",
        "kind = \"multisine\"\namplitudes = [0.1, 0.1, 0.05]\nfrequencies = [5.0, 12.0, 31.0]",
        "kind = \"chirp\"\namplitude = 0.2\nfrom = 2.0\nto = 40.0\nduration = 5.0",
        "kind = \"square\"\namplitude = 0.2\nperiod = 0.5",
        "kind = \"steps\"\nlevels = [0.1, -0.2, 0.3]\nhold = 0.2",
    ] {
        let text = format!("[plant]\na = 0.5\nb = 200.0\nload = 5.0\n[excitation]\n{table}\n");
        let scenario = scenario(&folder, &text);
        let output = servo_id(&["run", &scenario, "--json", "-"]);
        let result = printed_json(&output);
        let b = result["estimates"]["b"]["value"].as_f64().expect("number");
        assert!((b / 200.0 - 1.0).abs() < 0.01, "{table}: {result}");
    }
}

#[test]
fn help_lists_every_key() {
    let output = servo_id(&["run", "--help"]);
    let text = String::from_utf8(output.stdout).expect("text");
    for key in KEYS.iter().filter(|key| key.path.contains('.')) {
        assert!(text.contains(key.path), "{}", key.path);
    }
}

#[test]
fn compare_gives_every_method_the_box_that_it_has_to_know() {
    let folder = folder("compare-box");
    let text = include_str!("../../../../host-sim/scenarios/friction.toml")
        .replace("duration = 8.0", "duration = 1.0");
    let file = folder.join("friction.toml");
    std::fs::write(&file, text).expect("the scenario is written");
    let json = folder.join("compare.json");
    let [file, json] = [&file, &json].map(|path| path.display().to_string());
    let text = printed(&servo_id(&["compare", &file, "--json", &json]));
    assert!(!text.contains("refused"), "{text}");
    assert!(text.contains("states no plant_box"), "{text}");
    let result = std::fs::read_to_string(&json).expect("a result");
    let result: serde_json::Value = serde_json::from_str(&result).expect("JSON");
    let b = &result["assumed_box"]["b"];
    let [low, high] = [&b[0], &b[1]].map(|end| end.as_f64().expect("a number"));
    assert!(
        (low - 85.9).abs() < 1e-9 && (high - 773.1).abs() < 1e-9,
        "{b}"
    );
}

#[test]
fn compare_shows_every_method_in_every_case() {
    let folder = folder("compare");
    let text = include_str!("../../../../host-sim/scenarios/compare.toml").replace("60.0", "2.0");
    let scenario = scenario(&folder, &text);
    let (picture, json) = (folder.join("compare.png"), folder.join("compare.json"));
    let [picture_name, json_name] = [&picture, &json].map(|path| path.display().to_string());
    let output = servo_id(&[
        "compare",
        &scenario,
        "--plot",
        &picture_name,
        "--json",
        &json_name,
    ]);
    assert!(output.status.success(), "{}", standard_error(&output));
    let shown = String::from_utf8_lossy(&output.stdout);
    for case in [
        "as it should be",
        "load",
        "friction",
        "coarse encoder",
        "all together",
    ] {
        assert!(shown.contains(case), "{shown}");
    }
    let png = std::fs::read(&picture).expect("the picture is there");
    assert!(png.starts_with(b"\x89PNG"));
    let text = std::fs::read_to_string(&json).expect("the result is there");
    let document: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let cases = document["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 6);
    assert!(
        cases
            .iter()
            .all(|case| case["methods"].as_array().is_some_and(|m| m.len() == 4))
    );
}

#[test]
fn sweep_gives_the_same_for_any_number_of_threads() {
    let folder = folder("sweep");
    let scenario = scenario(&folder, &PROPOSED.replace("60.0", "1.0"));
    let run = |threads: &str| {
        let rows = folder.join(format!("{threads}.csv"));
        let name = rows.display().to_string();
        let output = servo_id(&[
            "sweep",
            &scenario,
            "--runs",
            "20",
            "--seed",
            "5",
            "--json",
            "-",
            "--threads",
            threads,
            "--csv",
            &name,
        ]);
        assert!(output.status.success(), "{}", standard_error(&output));
        (
            output.stdout,
            std::fs::read(rows).expect("the rows are there"),
        )
    };
    let one = run("1");
    assert_eq!(one, run("3"));
    let document: serde_json::Value = serde_json::from_slice(&one.0).expect("JSON");
    assert_eq!(document["runs"], 20);
    assert_eq!(String::from_utf8_lossy(&one.1).lines().count(), 21);
}

#[test]
fn a_method_refuses_parameters_it_cannot_identify_and_names_those_it_can() {
    let text = PROPOSED
        .replace(
            "law = \"gradient\"\ngamma = [0.2, 110.0]\nmu = 10.0\n",
            "law = \"relay-least-squares\"\n",
        )
        .replace(
            "parameters = [\"a\", \"b\"]",
            "parameters = [\"a\", \"b\", \"load\"]",
        );
    let text: String = text
        .lines()
        .filter(|line| !line.starts_with("bounds") && !line.starts_with("plant_box"))
        .map(|line| format!("{line}\n"))
        .collect();
    let answer = refusal("relay-load", &text);
    assert!(answer.contains("identifier.parameters"), "{answer}");
    assert!(
        answer.contains(
            "\"relay-least-squares\" cannot estimate \"load\": it estimates [\"a\", \"b\"]"
        ),
        "{answer}"
    );
}

#[test]
fn what_is_gone_is_answered_at_once_with_what_replaces_it() {
    const OWN_LOG: &str = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../host-sim/scenarios/own_controller_log.toml"
    );
    let folder = folder("gone-words");
    let recording = folder.join("run.mcap");
    std::fs::write(&recording, b"\x89MCAP0\r\n\x01\0\0").expect("it is written");
    let recording = recording.display().to_string();
    for (words, instead) in [
        (
            &["check", "s.toml", "--json", "-"][..],
            "run prints margins",
        ),
        (&["drift", "s.toml"], "run SCENARIO --formats"),
        (
            &["replay", "log.csv", "--scenario", "s.toml"],
            "identify LOG --scenario",
        ),
        (&["manual", "run"], "--help"),
        (&["rerun", "result.json"], "reproduce"),
        (&["run", "s.toml", "--live=8080"], "--report"),
        (&["run", "s.toml", "--mcap", "trace.mcap"], "--csv"),
        (&["identify", &recording], "convert the recording to .csv"),
        (
            &["identify", &recording, "--scenario", OWN_LOG],
            "convert the recording to .csv",
        ),
        (&["reproduce", &recording], "convert the recording to .csv"),
    ] {
        let answer = refusal_message(&servo_id(words));
        assert!(answer.contains(instead), "{words:?}: {answer}");
        assert_eq!(answer.trim_end().lines().count(), 1, "{answer}");
    }
    let answer = refusal("gone-law", &with_fit("closed-loop-arx", ""));
    assert!(
        answer.contains("identifier.law") && answer.contains("\"relay-least-squares\" is"),
        "{answer}"
    );
}

#[test]
fn a_run_in_every_format_is_one_table() {
    let folder = folder("formats");
    let text = include_str!("../../../../host-sim/scenarios/drift.toml").replace("60.0", "2.0");
    let scenario = scenario(&folder, &text);
    let output = servo_id(&["run", &scenario, "--formats"]);
    assert!(output.status.success(), "{}", standard_error(&output));
    let shown = String::from_utf8_lossy(&output.stdout);
    for format in ["f32", "fixed"] {
        assert_eq!(shown.matches(&format!(" {format} ")).count(), 7, "{shown}");
    }
    assert!(shown.contains("the same 2000 measurements"), "{shown}");
    let both = servo_id(&["run", &scenario, "--formats", "--json", "-"]);
    assert_eq!(both.status.code(), Some(2));
}

#[test]
fn what_fixed_point_cannot_do_is_answered_with_key_and_remedy() {
    let fixed = "arithmetic = \"fixed\"";
    let words = |more: &str| PROPOSED.replace("arithmetic = \"f32\"", &format!("{fixed}\n{more}"));
    let narrow = "ranges = { error = 1.0, velocity = 100.0, command = 2.0 }";
    let answer = refusal("fixed-command", &words(narrow));
    assert!(answer.contains("identifier.ranges.command"), "{answer}");
    assert!(answer.contains("at least 10"), "{answer}");
    let answer = refusal(
        "fixed-gamma",
        &words("").replace("[0.2, 110.0]", "[0.2, 1e14]"),
    );
    assert!(
        answer.contains("identifier.gamma") && answer.contains("at most"),
        "{answer}"
    );
    let answer = refusal(
        "fixed-law",
        &with_fit("gauss-newton", "").replace("arithmetic = \"f32\"", fixed),
    );
    assert!(answer.contains("identifier.arithmetic"), "{answer}");
    assert!(
        answer.contains("\"gradient\" and \"pd-gradient\" alone"),
        "{answer}"
    );
    let stray = PROPOSED.replace(
        "arithmetic = \"f32\"",
        &format!("arithmetic = \"f32\"\n{narrow}"),
    );
    let answer = refusal("fixed-stray", &stray);
    assert!(answer.contains("identifier.ranges"), "{answer}");
}
