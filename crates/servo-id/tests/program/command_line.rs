//! The contract of the command line: exit status, files, messages.

use std::fs;

use crate::support::readable::assert_readable;
use crate::support::{
    Folder, estimate, folder_with_paper, own_folder, printed, scenario_text, servo_id, table,
};
use host_sim::scenario::keys::KEYS;
use host_sim::scenario::{Purpose, Scenario};
use serde_json::Value;
use servo_id::paper::PROPOSED;

/// A folder with the paper's scenario of 10 s, changed.
fn short(from: &str, to: &str) -> Folder {
    let folder = own_folder();
    let text = PROPOSED.replace("duration = 60.0", "duration = 10.0");
    folder.write("scenario.toml", text.replace(from, to));
    folder
}

/// Message about a wrong scenario of a run.
fn refusal(text: &str) -> String {
    let error = Scenario::parse("s.toml", text, Purpose::Run).expect_err(text);
    let answer = error.to_string();
    assert_readable(&answer, text);
    answer
}

#[test]
fn the_minimal_scenario_runs_in_fixed_point_too() {
    let folder = own_folder();
    let minimal = scenario_text("minimal.toml");
    folder.write("minimal.toml", &minimal);
    let shown = folder.done("run minimal.toml --formats");
    for format in ["f32", "fixed"] {
        assert_eq!(shown.matches(&format!(" {format} ")).count(), 7, "{shown}");
    }
    let fixed = "[identifier]\narithmetic = \"fixed\"";
    folder.write_scenario("minimal.toml", "[identifier]", fixed);
    let result = folder.json("run minimal.toml");
    assert_eq!(result["arithmetic"], "fixed");
    assert_eq!(result["status"], "converged", "{result}");
}

#[test]
fn an_unknown_value_is_a_dash() {
    let folder = own_folder();
    folder.write(
        "still.toml",
        "[plant]\na = 1.0\nb = 100.0\n[excitation]\nkind = \"none\"\n[identifier]\nlaw = \"gauss-newton\"\n\
         [run]\nduration = 1.0\n",
    );
    let text = folder.done("run still.toml");
    assert!(!text.contains('±'), "{text}");
    for quantity in [" a  ", " b  "] {
        let row = text.lines().find(|line| line.starts_with(quantity));
        let estimate = row.and_then(|row| row.split_whitespace().nth(1));
        assert_eq!(estimate, Some("–"), "{text}");
    }
}

/// Keys of a result, and what they hold: a kind, or a value.
const RESULT: &str = r#"
/law | "paper"
/arithmetic | "f32"
/samples | 10000
/status | "converged"
/code | 0
/cause /first_fit_rejection /agreement /estimates/coulomb | null
/slowed_samples /model_restarts /standing_samples /load_steps /not_following_samples | whole
/truth/a /truth/b /truth/coulomb /truth/load /output_error/rms /output_error/max | number
/settling_time/a /settling_time/b | number
/estimates/a/value /estimates/a/tail_std /estimates/a/std_error | number
/estimates/b/value /estimates/b/tail_std /estimates/b/std_error | number
/estimates/load/value /estimates/load/tail_std /estimates/load/std_error | number
/estimates/a/at_bound /estimates/b/at_bound /estimates/load/at_bound | false
/estimates/a/unit | "1/s"
/estimates/b/unit | "rad/s² per command unit"
/estimates/load/unit | "rad/s²"
"#;

#[test]
fn json_on_standard_output_is_alone_and_has_the_predicted_keys() {
    let result = short("", "").json("run scenario.toml");
    assert!((result["sample_time"].as_f64().expect("number") - 1e-3).abs() < 1e-15);
    for row in table(RESULT) {
        for key in row[0].split(' ') {
            let value = result.pointer(key).unwrap_or(&Value::Null);
            let is_right = match &*row[1] {
                "whole" => value.is_u64(),
                "number" => value.is_f64(),
                expected => *value == serde_json::from_str::<Value>(expected).expect("JSON"),
            };
            assert!(is_right, "{key}: {value}");
        }
    }
}

#[test]
fn without_a_verb_the_papers_table_is_printed_and_nothing_is_written() {
    let folder = own_folder();
    assert!(folder.done("").matches("proposed, d").count() >= 2);
    assert!(folder.names().is_empty());
}

/// What is changed in the paper's scenario, to what, the key that the answer names, and a figure of it.
const CHANGES: &str = r#"
load = 0.0 | laod = 0.0 | plant.laod |
kp = 9.0 | kp = "nine" | controller.kp |
cutoff = 500.0 | cutoff = true | controller.velocity_filter.cutoff |
gamma = [0.2, 110.0] | gamma = "large" | identifier.gamma |
seed = 1212121 | seed = -1 | excitation.seed | 4294967295
law = "paper" | law = "magic" | identifier.law |
parameters = ["a", "b"] | parameters = ["a", "z"] | identifier.parameters |
sample_time = 0.001 | sample_time = 0.0 | controller.sample_time |
kd = 0.19 | kd = nan | controller.kd |
cutoff = 500.0 | cutoff = 4000.0 | controller.velocity_filter.cutoff | 3141.59
b = [5.0, 5000.0] | b = [0.0, 5000.0] | identifier.bounds.b |
a = [0.0, 100.0] | a = [3.0, 1.0] | identifier.bounds.a |
gamma = [0.2, 110.0] | gamma = [[1.0, 0.0], [0.0, 1.0]] | identifier.gamma |
gamma = [0.2, 110.0] | gamma = [0.2, -1.0] | identifier.gamma |
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
fit | parameters = ["a", "b", "coulomb", "load"]; required_terms = ["ripple"] | identifier.ripple_order
relay-least-squares | parameters = ["a", "b", "load"] | identifier.parameters
"#;

#[test]
fn a_wrong_value_is_answered_with_line_and_key() {
    for row in table(CHANGES) {
        let text = PROPOSED.replacen(&row[0], &row[1], 1);
        assert_ne!(text, PROPOSED, "{row:?}");
        let change = row[1].lines().last().expect("a change");
        let line = text.lines().position(|line| line.contains(change));
        let place = format!("s.toml:{}: {}", 1 + line.expect("the change"), row[2]);
        let answer = refusal(&text);
        let is_named = answer.contains(&place) && answer.contains(&row[3]);
        assert!(is_named, "{row:?}: {answer}");
    }
    let elsewhere = table(ELSEWHERE).into_iter().map(|row| {
        let text = PROPOSED.replace(&row[0], &row[1]);
        (text, row[2].clone())
    });
    let fits = table(FITS).into_iter();
    let fits = fits.map(|row| (with_fit(&row[0], &row[1]), row[2].clone()));
    for (text, key) in elsewhere.chain(fits) {
        let answer = refusal(&text);
        assert!(answer.contains(&format!(": {key}: ")), "{key}: {answer}");
    }
    let answer = refusal("[run]\nduration = 1.0\n");
    assert!(answer.contains(": plant: "), "{answer}");
    assert!(refusal("[plant\na = 1").contains("s.toml:1"));
}

/// An estimate at its bound is not identified, even if it is constant.
#[test]
fn an_estimate_at_a_bound_is_no_result() {
    let folder = short("b = [5.0, 5000.0]", "b = [5.0, 200.0]");
    let result = folder.json("run scenario.toml");
    assert_eq!(result["estimates"]["b"]["at_bound"], true, "{result}");
    assert_eq!(result["status"], "no-information");
    assert_eq!(result["code"], 24);
}

/// A servo that is declared slower than it is: the run ends where the speed exceeds the declaration.
#[test]
fn a_run_ends_where_the_largest_speed_is_exceeded() {
    let folder = short("mu = 10.0", "mu = 10.0\nmax_speed = 1.0");
    let output = folder.call("run scenario.toml --json -");
    assert_eq!(output.status.code(), Some(1));
    let result: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(result["status"], "aborted");
}

/// The paper's scenario with an estimator that fits, and lines of it.
fn with_fit(law: &str, lines: &str) -> String {
    let gradient = "law = \"paper\"\ngamma = [0.2, 110.0]\nmu = 10.0";
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
fn every_kind_of_reference_runs() {
    let folder = own_folder();
    for table in [
        "kind = \"prbs\"\namplitude = 0.2\nhold = 0.05",
        "kind = \"multisine\"\namplitudes = [0.1, 0.1, 0.05]\nfrequencies = [5.0, 12.0, 31.0]",
        "kind = \"chirp\"\namplitude = 0.2\nfrom = 2.0\nto = 40.0\nduration = 5.0",
        "kind = \"square\"\namplitude = 0.2\nperiod = 0.5",
        "kind = \"steps\"\nlevels = [0.1, -0.2, 0.3]\nhold = 0.2",
    ] {
        let text = format!("[plant]\na = 0.5\nb = 200.0\nload = 5.0\n[excitation]\n{table}\n");
        folder.write("scenario.toml", text);
        let b = estimate(&folder.json("run scenario.toml"), "b");
        assert!((b / 200.0 - 1.0).abs() < 0.01, "{table}: {b}");
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

/// Calls that are refused, and a part of the answer: the nearest word where one is unknown.
const REFUSED: &str = "
no-such-verb | no-such-verb
identifi log.csv | 'identify'
run scenario.toml --jsn r.json | '--json'
sweep scenario.toml --runs 2 --plot p.svg | --plot
reproduce r.json | 'reproduce'
run no-such-file.toml | no-such-file.toml
run scenario.toml --plot picture.gif | picture.gif
run scenario.toml --json no/such/folder/result.json | result.json
run scenario.toml --formats --json - | --json
";

#[test]
fn a_call_that_is_refused_is_answered_with_its_word() {
    short("", "").assert_refused(REFUSED);
}

#[test]
fn compare_gives_every_method_the_range_that_it_has_to_know() {
    let folder = own_folder();
    folder.write_scenario("friction.toml", "duration = 8.0", "duration = 1.0");
    folder.done("compare friction.toml --json compare.json");
    let range = &folder.read_json("compare.json")["assumed_range"]["b"];
    for (place, expected) in [(0, 85.9), (1, 773.1)] {
        let end = range[place].as_f64().expect("a number");
        assert!((end - expected).abs() < 1e-9, "{range}");
    }
}

#[test]
fn sweep_gives_the_same_for_any_number_of_threads() {
    let folder = folder_with_paper("sweep", "1.0");
    let run = |threads: &str| {
        let call = format!(
            "sweep scenario.toml --runs 20 --seed 5 --threads {threads} --csv rows.csv --force"
        );
        (folder.json(&call), folder.read("rows.csv"))
    };
    let one = run("1");
    assert_eq!(one, run("3"));
    assert_eq!(one.0["runs"], 20);
    assert_eq!(one.1.lines().count(), 21);
}

#[test]
fn a_log_that_python_reads_is_answered_with_its_command() {
    let folder = own_folder();
    fs::create_dir(folder.join("bag")).expect("a folder");
    folder.write("bag/metadata.yaml", "version: 9");
    folder.write("bag/bag_0.db3", "SQLite format 3\0\x10");
    for log in ["bag", "bag/bag_0.db3"] {
        let answer = folder.refused(&format!("identify {log}"));
        let command = format!("python -m servo_id identify \"{log}\"");
        let install = "pip install './crates/identifier-py[ros]'";
        let is_answered = answer.contains(&command) && answer.contains(install);
        assert!(is_answered, "{answer}");
    }
}

#[test]
fn a_result_holds_what_repeats_it_to_the_last_bit() {
    let folder = short("", "");
    let text = format!("# a servo\n{}", folder.read("scenario.toml"));
    folder.write("scenario.toml", &text);
    folder.done("run scenario.toml --json r.json --csv r.csv");
    let mut result = folder.read_json("r.json");
    let origin = result["origin"].take();
    assert_eq!(folder.read_json("r.csv-metadata.json")["origin"], origin);
    assert_eq!(origin["version"], servo_id::VERSION);
    assert_eq!(origin["command"][1], "run");
    let kept = origin["scenario"]["text"].as_str().expect("a text");
    assert_eq!(kept, text);
    folder.write("again.toml", kept);
    let mut again = folder.json("run again.toml");
    again["origin"].take();
    assert_eq!(again, result);
}
