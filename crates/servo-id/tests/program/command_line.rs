//! The contract of the command line: exit status, files, messages.

use std::path::Path;
use std::process::Command;

use crate::support::{
    assert_done, folder, printed, printed_json, refusal_message, servo_id, standard_error,
};
use host_sim::scenario::keys::KEYS;
use serde_json::Value;
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

/// Asserts that a text is refused with the line of its change and the key, and a part of the message, if there is one.
fn assert_refused(text: &str, change: &str, key: &str, part: &str) {
    let change = change.lines().last().expect("a change");
    let line = 1 + text
        .lines()
        .position(|line| line.contains(change))
        .expect("the change is there");
    let answer = refusal("refused", text);
    assert!(
        answer.contains(&format!("scenario.toml:{line}: {key}")),
        "{change}: {answer}"
    );
    assert!(answer.contains(part), "{change}: {answer}");
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
fn json_on_standard_output_is_alone_and_has_the_predicted_keys() {
    let folder = folder("json");
    let scenario = scenario(&folder, &short(PROPOSED));
    let output = servo_id(&["run", &scenario, "--json", "-"]);
    assert_eq!(output.status.code(), Some(0));
    let result: Value = serde_json::from_slice(&output.stdout).expect("only JSON");
    assert_eq!(result["law"], "gradient");
    assert_eq!(result["arithmetic"], "f32");
    assert_eq!(result["samples"], 10_000);
    assert_eq!(result["status"], "converged", "{}", result["reason"]);
    assert_eq!(result["code"], 0);
    assert!(result["cause"].is_null());
    assert!(result["first_fit_rejection"].is_null());
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
fn without_a_verb_the_papers_table_is_printed_and_nothing_is_written() {
    let folder = folder("paper");
    let output = Command::new(env!("CARGO_BIN_EXE_servo-id"))
        .current_dir(&folder)
        .output()
        .expect("the program starts");
    assert!(printed(&output).matches("proposed, d").count() >= 2);
    assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), 0);
}

/// What is changed in the paper's scenario, to what, the key that the answer names, and a figure of it.
const CHANGES: &str = r#"
load = 0.0 | laod = 0.0 | plant.laod |
kp = 9.0 | kp = "nine" | controller.kp |
cutoff = 500.0 | cutoff = true | controller.velocity_filter.cutoff |
gamma = [0.2, 110.0] | gamma = "large" | identifier.gamma |
seed = 1212121 | seed = -1 | excitation.seed | 4294967295
law = "gradient" | law = "magic" | identifier.law |
parameters = ["a", "b"] | parameters = ["a", "z"] | identifier.parameters |
sample_time = 0.001 | sample_time = 0.0 | controller.sample_time |
kd = 0.19 | kd = nan | controller.kd |
cutoff = 500.0 | cutoff = 4000.0 | controller.velocity_filter.cutoff | 3141.59
b = [5.0, 5000.0] | b = [0.0, 5000.0] | identifier.bounds.b |
a = [0.0, 100.0] | a = [3.0, 1.0] | identifier.bounds.a |
gamma = [0.2, 110.0] | gamma = [[1.0, 2.0], [2.0, 1.0]] | identifier.gamma |
gamma = [0.2, 110.0] | gamma = [[1.0, 0.2], [0.1, 1.0]] | identifier.gamma |
mu = 10.0 | mu = 12.0 | identifier.mu |
kp = 9.0 | kp = 2.0 | controller.kp |
sample_time = 0.1 | sample_time = 0.1005 | excitation.sample_time | 0.101
limit = 10.0 | limit = [1.0, 2.0] | amplifier.limit |
power = 0.005 | period = 1.0 | excitation.period |
duration = 60.0 | duration = -1.0 | run.duration |
counts_per_rev = 10000 | counts_per_rev = -5 | encoder.counts_per_rev | 1e9
mu = 10.0 | mu = 10.0; max_speed = -1.0 | identifier.max_speed |
mu = 10.0 | mu = 10.0; bandwidth = 0.0 | identifier.bandwidth |
mu = 10.0 | mu = 10.0; noise = 1e-3 | identifier.noise |
"#;

/// What is changed, and the key that the answer names, on a line of any place.
const ELSEWHERE: &str = r#"
b = 257.7 | # | plant.b
mu = 10.0 | correction = { kp = 0.0, kd = 0.1, ki = 1.0 } | identifier.correction.kp
mu = 10.0 | correction = { kp = 9.0, kd = 0.1 } | identifier.correction.ki
arithmetic = "f32" | arithmetic = "fixed"; ranges = { error = 1.0, velocity = 100.0, command = 2.0 } | identifier.ranges.command
arithmetic = "f32" | arithmetic = "f32"; ranges = { error = 1.0, velocity = 100.0, command = 2.0 } | identifier.ranges
"#;

/// An estimator that fits instead of the paper's, with a line, and the key that the answer names.
const FITS: &str = r#"
gauss-newton | start_time = 1e-5 | identifier.start_time
gauss-newton | start_time = 2e4 | identifier.start_time
gauss-newton | memory = 0.5 | identifier.memory
fit | parameters = ["a", "b", "coulomb", "load"]; memory = 5.0 | identifier.memory
gauss-newton | parameters = ["a"] | identifier.initial.b
gauss-newton | arithmetic = "fixed" | identifier.arithmetic
window | # | identifier.law
gauss-newton | terms = ["delay"] | identifier.terms
gauss-newton | required_terms = ["wandering-load"] | identifier.required_terms
relay-least-squares | parameters = ["a", "b", "load"] | identifier.parameters
"#;

#[test]
fn a_wrong_value_is_answered_with_line_and_key() {
    let cells = |row: &'static str| row.split('|').map(|cell| cell.trim().replace("; ", "\n"));
    for row in CHANGES.trim().lines() {
        let [from, to, key, part] =
            <[String; 4]>::try_from(cells(row).collect::<Vec<_>>()).expect("four cells");
        let text = PROPOSED.replacen(&from, &to, 1);
        assert_ne!(text, PROPOSED, "{row}");
        assert_refused(&text, &to, &key, &part);
    }
    for row in ELSEWHERE.trim().lines() {
        let [from, to, key] =
            <[String; 3]>::try_from(cells(row).collect::<Vec<_>>()).expect("three cells");
        let answer = refusal("refused", &PROPOSED.replace(&from, &to));
        assert!(answer.contains(&format!(": {key}: ")), "{row}: {answer}");
    }
    for row in FITS.trim().lines() {
        let [law, line, key] =
            <[String; 3]>::try_from(cells(row).collect::<Vec<_>>()).expect("three cells");
        let answer = refusal("refused", &with_fit(&law, &line));
        assert!(answer.contains(&format!(": {key}: ")), "{row}: {answer}");
    }
    let answer = refusal("refused", "[run]\nduration = 1.0\n");
    assert!(answer.contains(": plant: "), "{answer}");
}

/// An estimate at its bound is not identified, even if it is constant.
#[test]
fn an_estimate_at_a_bound_is_no_result() {
    let folder = folder("bound");
    let text = short(PROPOSED).replace("b = [5.0, 5000.0]", "b = [5.0, 200.0]");
    let scenario = scenario(&folder, &text);
    let output = servo_id(&["run", &scenario, "--json", "-"]);
    let result: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(result["estimates"]["b"]["at_bound"], true, "{result}");
    assert_eq!(result["status"], "no-information");
    assert_eq!(result["code"], 24);
}

/// A servo that is declared slower than it is: the run ends where the speed exceeds the declaration.
#[test]
fn a_run_ends_where_the_largest_speed_is_exceeded() {
    let folder = folder("max-speed-run");
    let text = short(PROPOSED).replace("mu = 10.0", "mu = 10.0\nmax_speed = 1.0");
    let scenario = scenario(&folder, &text);
    let output = servo_id(&["run", &scenario, "--json", "-"]);
    assert_eq!(output.status.code(), Some(1));
    let result: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(result["status"], "aborted");
}

/// The paper's scenario with an estimator that fits, and lines of it.
fn with_fit(law: &str, lines: &str) -> String {
    let gradient = "law = \"gradient\"\ngamma = [0.2, 110.0]\nmu = 10.0";
    let mut left_out = vec!["servo_range", "initial", "bounds"];
    left_out.extend(lines.lines().filter_map(|line| line.split(" =").next()));
    let is_kept = |line: &&str| !left_out.iter().any(|begin| line.starts_with(begin));
    let text = PROPOSED.replace(gradient, "LAW");
    let text: String = text
        .lines()
        .filter(is_kept)
        .map(|line| format!("{line}\n"))
        .collect();
    text.replace("LAW", &format!("law = \"{law}\"\n{lines}"))
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
fn help_fits_two_screens_and_the_keys_have_a_verb() {
    /// Lines of the help of a verb at most.
    const LINES: usize = 120;
    for verb in ["identify", "run", "tune", "export", "commission", "sweep"] {
        for flag in ["--help", "-h"] {
            let help = printed(&servo_id(&[verb, flag]));
            assert!(help.lines().count() <= LINES, "{verb}:\n{help}");
        }
    }
    let keys = printed(&servo_id(&["keys"]));
    for key in KEYS.iter().filter(|key| key.path.contains('.')) {
        assert!(keys.contains(key.path), "{}", key.path);
    }
}

#[test]
fn a_word_that_is_unknown_is_answered_with_the_nearest() {
    for (words, near) in [
        (&["identifi", "log.csv"][..], "'identify'"),
        (&["run", "s.toml", "--jsn", "r.json"], "'--json'"),
        (
            &["sweep", "s.toml", "--runs", "2", "--plot", "p.svg"],
            "--plot",
        ),
        (&["reproduce", "r.json"], "'reproduce'"),
    ] {
        let answer = refusal_message(&servo_id(words));
        assert!(answer.contains(near), "{words:?}: {answer}");
    }
}

#[test]
fn compare_gives_every_method_the_range_that_it_has_to_know() {
    let folder = folder("compare-box");
    let text = include_str!("../../../../host-sim/scenarios/friction.toml")
        .replace("duration = 8.0", "duration = 1.0");
    let file = folder.join("friction.toml");
    std::fs::write(&file, text).expect("the scenario is written");
    let json = folder.join("compare.json");
    let [file, json] = [&file, &json].map(|path| path.display().to_string());
    printed(&servo_id(&["compare", &file, "--json", &json]));
    let result = std::fs::read_to_string(&json).expect("a result");
    let result: Value = serde_json::from_str(&result).expect("JSON");
    let b = &result["assumed_range"]["b"];
    let [low, high] = [&b[0], &b[1]].map(|end| end.as_f64().expect("a number"));
    assert!(
        (low - 85.9).abs() < 1e-9 && (high - 773.1).abs() < 1e-9,
        "{b}"
    );
}

#[test]
fn compare_has_every_method_in_every_case() {
    let folder = folder("compare");
    let text = include_str!("../../../../host-sim/scenarios/compare.toml").replace("60.0", "2.0");
    let scenario = scenario(&folder, &text);
    let document = printed_json(&servo_id(&["compare", &scenario, "--json", "-"]));
    let cases = document["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 6);
    let has_all = |case: &Value| case["methods"].as_array().is_some_and(|m| m.len() == 4);
    assert!(cases.iter().all(has_all));
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
    let document: Value = serde_json::from_slice(&one.0).expect("JSON");
    assert_eq!(document["runs"], 20);
    assert_eq!(String::from_utf8_lossy(&one.1).lines().count(), 21);
}

#[test]
fn a_log_that_python_reads_is_answered_with_its_command() {
    let bag = folder("a-bag");
    let database = bag.join("bag_0.db3");
    std::fs::write(bag.join("metadata.yaml"), "version: 9").expect("it is written");
    std::fs::write(&database, b"SQLite format 3\0\x10").expect("it is written");
    for log in [&bag, &database] {
        let log = log.display().to_string();
        let answer = refusal_message(&servo_id(&["identify", &log]));
        let command = format!("python -m servo_id identify \"{log}\"");
        assert!(answer.contains(&command), "{answer}");
        assert!(
            answer.contains("pip install './crates/identifier-py[ros]'"),
            "{answer}"
        );
    }
}

#[test]
fn a_result_holds_what_repeats_it_to_the_last_bit() {
    let folder = folder("origin");
    let text = format!("# a servo\n{}", short(PROPOSED));
    let file = scenario(&folder, &text);
    let path = |name: &str| folder.join(name).display().to_string();
    let [json, csv] = ["r.json", "r.csv"].map(path);
    assert_done(&servo_id(&["run", &file, "--json", &json, "--csv", &csv]));
    let read = |name: &str| -> Value {
        let text = std::fs::read(folder.join(name)).expect("it is written");
        serde_json::from_slice(&text).expect("JSON")
    };
    let mut result = read("r.json");
    let origin = result["origin"].take();
    assert_eq!(read("r.csv-metadata.json")["origin"], origin);
    assert_eq!(origin["version"], servo_id::VERSION);
    assert_eq!(origin["command"][1], "run");
    assert_eq!(origin["scenario"]["text"], text);
    let kept = origin["scenario"]["text"].as_str().expect("a text");
    let again = scenario(&folder, kept);
    let mut again = printed_json(&servo_id(&["run", &again, "--json", "-"]));
    again["origin"].take();
    assert_eq!(again, result);
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
    let both = servo_id(&["run", &scenario, "--formats", "--json", "-"]);
    assert_eq!(both.status.code(), Some(2));
}
