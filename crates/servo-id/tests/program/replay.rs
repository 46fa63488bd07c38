//! Replay from the command line: the committed log, and every way a log can be wrong.

use std::io::Write;
use std::process::Stdio;

use serde_json::Value;

use crate::support::{
    Folder, committed_log, estimate, number, own_folder, packed_log, printed_json, scenario_text,
};

/// The lines of the committed log.
fn lines() -> Vec<String> {
    committed_log().lines().map(str::to_owned).collect()
}

/// A folder with the committed log, changed, and a scenario.
fn changed(change: impl FnOnce(&mut Vec<String>), scenario: &str) -> Folder {
    let folder = own_folder();
    let mut lines = lines();
    change(&mut lines);
    folder.write("log.csv", lines.join("\n") + "\n");
    folder.write("scenario.toml", scenario);
    folder
}

const REPLAY: &str = "identify log.csv --scenario scenario.toml";

/// The result of the log, changed.
fn replayed(change: impl FnOnce(&mut Vec<String>), scenario: &str) -> Value {
    changed(change, scenario).json(REPLAY)
}

/// The result of the log as it is.
fn replay(scenario: &str) -> Value {
    replayed(|_| (), scenario)
}

/// The message about the log, changed.
fn refusal(change: impl FnOnce(&mut Vec<String>)) -> String {
    changed(change, &scenario()).refused(REPLAY)
}

fn scenario() -> String {
    scenario_text("replay.toml")
}

/// The committed scenario with the gradient estimator, which needs a parameter range.
fn gradient() -> String {
    scenario().replace(
        "law = \"gauss-newton\"",
        "law = \"gradient\"\nservo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }",
    )
}

/// The committed scenario with another estimator, of a and b.
fn with_law(law: &str) -> String {
    let all = "[\"a\", \"b\", \"coulomb\", \"load\"]";
    let text = scenario().replace("gauss-newton", law);
    text.replace(all, "[\"a\", \"b\"]")
}

/// A scenario without the tables and lines that begin so.
fn without(text: &str, left_out: &[&str]) -> String {
    let mut inside = false;
    let is_kept = |line: &&str| {
        if line.starts_with('[') {
            inside = left_out.contains(&line.trim());
        }
        !inside && !left_out.iter().any(|begin| line.starts_with(begin))
    };
    let kept = text.lines().filter(is_kept);
    kept.fold(String::new(), |text, line| text + line + "\n")
}

/// A line with one of its fields changed.
fn with_field(line: &str, index: usize, value: &str) -> String {
    let mut fields: Vec<&str> = line.split(',').collect();
    fields[index] = value;
    fields.join(",")
}

/// A result without the name of its log and where it is from.
fn unnamed(mut result: Value) -> Value {
    let file = result["logs"][0]["file"].take();
    let origin = result["origin"].take();
    assert!(file.is_string() && origin.is_object(), "{result}");
    result
}

/// The gain of a result, by that of the servo, less one.
fn off(result: &Value) -> f64 {
    (estimate(result, "b") / 257.7 - 1.0).abs()
}

#[test]
fn the_committed_log_gives_the_servo_that_made_it() {
    let result = replay(&scenario());
    for (name, truth, tolerance) in [
        ("a", 0.2174, 0.03),
        ("b", 257.7, 0.5),
        ("coulomb", 10.0, 0.3),
        ("load", 20.0, 0.4),
    ] {
        let found = estimate(&result, name);
        assert!((found - truth).abs() < tolerance, "{name}: {found}");
    }
    assert!(result["truth"].is_null() && result["settling_time"]["a"].is_null());
    assert_eq!(result["status"], "converged");
    assert!(result["estimates"]["b"]["std_error"].is_f64());
}

/// A plain log and a packed one are alike.
#[test]
fn each_pass_continues_from_the_last_and_pictures_are_drawn() {
    let folder = changed(|_| (), &gradient());
    folder.write("packed.csv.gz", packed_log());
    let packed = "identify packed.csv.gz --scenario scenario.toml";
    assert_eq!(unnamed(folder.json(packed)), unnamed(folder.json(REPLAY)));
    let after = folder.json(&format!("{packed} --passes 8 --plot replay.svg"));
    assert!(off(&after) < 0.01, "{after}");
    assert!(folder.read("replay.svg").starts_with("<svg"));
    folder.refused(&format!("{packed} --passes 0"));
}

#[test]
fn a_bridged_gap_costs_next_to_nothing() {
    let gaps = |lines: &mut Vec<String>| {
        lines.drain(500..503);
        // A stamp that went wrong, a row that was cut off.
        lines[700] = with_field(&lines[700], 0, "0.050");
        lines[900].truncate(8);
    };
    for scenario in [scenario(), scenario() + "bridge_gaps = 3\n"] {
        let result = replayed(gaps, &scenario);
        assert!(off(&result) < 0.01, "{result}");
    }
}

#[test]
fn the_command_of_the_declared_controller_is_not_compared_through_a_gap() {
    // Straight lines are nothing that a controller answered.
    let gaps = |lines: &mut Vec<String>| {
        for begin in (1000..7000).step_by(200).rev() {
            lines.drain(begin..begin + 8);
        }
    };
    let result = replayed(gaps, &(scenario() + "bridge_gaps = 8\n"));
    let agreement = &result["agreement"];
    assert_eq!(agreement["holds"], true, "{agreement}");
    assert!(number(agreement, "/largest") < 1e-3, "{agreement}");
}

#[test]
fn a_broken_row_is_answered_with_its_place() {
    for keep in [0, 1, 2] {
        let answer = refusal(|lines| lines.truncate(keep));
        assert!(answer.contains("log.csv"), "{answer}");
    }
    let renamed = "t,reference_rad,position_rad,command";
    let answer = refusal(|lines| renamed.clone_into(&mut lines[0]));
    assert!(answer.contains("column time_s"), "{answer}");
    // A message quotes a log briefly and without control characters.
    let long = format!("\u{1b}[2J{}", "9e".repeat(5000));
    for value in ["fast", "inf", &long] {
        let answer = refusal(|lines| lines[41] = with_field(&lines[41], 2, value));
        assert!(
            answer.contains("log.csv:42: column position_rad"),
            "{answer}"
        );
        assert!(answer.len() < 400 && !answer.contains('\u{1b}'), "{answer}");
    }
    let endless = |filler: &str| filler.repeat((1 << 21) / filler.len());
    for row in [
        endless("1"),
        endless("1,"),
        format!("\"{}", endless("1\n")),
        endless("\n"),
    ] {
        let answer = refusal(|lines| lines[41] = row);
        assert!(answer.contains("1048576"), "{answer}");
        assert!(answer.len() < 400, "{answer}");
    }
    let wide = "0,".repeat(1000);
    let answer = refusal(|lines| lines.iter_mut().for_each(|line| line.clone_from(&wide)));
    assert!(answer.contains("log.csv:1: "), "{answer}");
}

#[test]
fn a_wrongly_declared_controller_is_reported_and_does_no_harm() {
    let right = replay(&gradient());
    assert_eq!(right["agreement"]["holds"], true);
    assert!(number(&right, "/agreement/relative") < 0.01);
    for (from, to) in [
        ("kp = 9.0", "kp = 8.0"),
        ("\"low-pass\", cutoff = 500.0", "\"difference\""),
        ("limit = 10.0", "limit = 0.5"),
    ] {
        let wrong = replay(&gradient().replace(from, to));
        let agreement = &wrong["agreement"];
        assert_eq!(agreement["holds"], false, "{to}: {wrong}");
        assert!(number(agreement, "/relative") > 0.05);
        assert!(number(agreement, "/line") > 1.0);
        // The model is driven by the command that acted.
        let ratio = estimate(&wrong, "b") / estimate(&right, "b");
        assert!((ratio - 1.0).abs() < 0.01, "{to}: {wrong}");
    }
}

/// The loop is not ours: the log has the command that acted, and that is enough.
#[test]
fn a_log_with_the_command_needs_neither_controller_nor_reference() {
    let gains = "gamma = [1.0, 2000.0, 40.0, 40.0]\ncorrection = { kp = 4.0, kd = 0.1, ki = 2.0 }";
    let alone = without(&gradient(), &["[controller]", "[amplifier]", "reference"]);
    let found = replay(&alone.replace("[log]", &format!("{gains}\n[log]")));
    assert!(off(&found) < 0.02, "{found}");
    assert!(found["agreement"].is_null());
    // The log's own.
    assert!((number(&found, "/sample_time") - 1e-3).abs() < 1e-9);
}

#[test]
fn a_log_without_the_command_is_driven_by_the_declared_controllers() {
    let recorded = replay(&gradient());
    let computed = replay(&without(&gradient(), &["command"]));
    assert!(computed["agreement"].is_null());
    let ratio = estimate(&computed, "b") / estimate(&recorded, "b");
    assert!((ratio - 1.0).abs() < 1e-3, "{computed}");
}

#[test]
fn keys_that_a_replay_needs_are_named() {
    let controller = ["[controller]", "command"];
    let range = ["[controller]", "servo_range"];
    let fixed = "law = \"gradient\"\narithmetic = \"fixed\"";
    let in_words = gradient().replace("law = \"gradient\"", fixed);
    // An estimator with a loop of its own takes no log.
    let own_loop = with_law("pd-gradient");
    let with = |line: &str| gradient().replace("[log]", &format!("{line}\n[log]"));
    for (scenario, key) in [
        (without(&gradient(), &controller), "controller"),
        (without(&gradient(), &range), "identifier.correction"),
        (without(&gradient(), &["reference"]), "identifier.gamma"),
        (
            without(&gradient(), &["reference", "command"]),
            "log.command",
        ),
        (with("max_speed = 0.0"), "identifier.max_speed"),
        (with("bandwidth = 0.0"), "identifier.bandwidth"),
        (own_loop, "identifier.law"),
        (without(&in_words, &["[encoder]"]), "identifier.arithmetic"),
    ] {
        let answer = changed(|_| (), &scenario).refused(REPLAY);
        assert!(answer.contains(&format!(": {key}: ")), "{key}: {answer}");
    }
    // Nor is a scenario without a servo one of a run.
    let answer = changed(|_| (), &scenario()).refused("run scenario.toml");
    assert!(answer.contains(": plant: "), "{answer}");
}

/// A servo that is stated beside the columns of a log judges the estimates and changes none.
#[test]
fn a_declared_servo_does_not_turn_a_replay_into_a_run() {
    let known = scenario() + "[plant]\na = 2.0\nb = 100.0\n";
    let [unjudged, judged] = [scenario(), known].map(|scenario| replay(&scenario));
    assert_eq!(unjudged["estimates"], judged["estimates"]);
    assert!(unjudged["truth"].is_null());
    assert_eq!(judged["truth"]["b"], 100.0);
}

/// A few compressed bytes that expand to an endless row.
#[test]
fn a_row_that_unpacks_without_end_is_refused() {
    let folder = changed(|_| (), &scenario());
    let file = std::fs::File::create(folder.join("log.csv.gz")).expect("created");
    let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
    let heading = b"time_s,reference_rad,position_rad,command\n";
    packed.write_all(heading).expect("written");
    for _ in 0..300 {
        packed.write_all(&[b'1'; 1 << 20]).expect("written");
    }
    packed.finish().expect("written");
    let answer = folder.refused("identify log.csv.gz --scenario scenario.toml");
    assert!(answer.contains("log.csv.gz:2: "), "{answer}");
}

#[test]
#[cfg(unix)]
fn a_log_through_a_pipe_gives_what_its_file_gives() {
    let folder = changed(|_| (), &scenario());
    let called = |log: &str, bytes: &[u8]| {
        let mut child = folder
            .program(&format!("identify {log} --json -"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("it starts");
        let mut pipe = child.stdin.take().expect("a pipe");
        pipe.write_all(bytes).expect("it is read");
        drop(pipe);
        printed_json(&child.wait_with_output().expect("it ends"))
    };
    let from_file = called("log.csv", b"");
    let sum = &from_file["origin"]["logs"][0]["sha256"];
    assert_eq!(sum.as_str().map(str::len), Some(64), "{from_file}");
    let plain = folder.read("log.csv");
    for log in ["-", "/dev/stdin"] {
        let piped = called(log, plain.as_bytes());
        assert_eq!(piped["estimates"], from_file["estimates"], "{log}");
        assert_eq!(&piped["origin"]["logs"][0]["sha256"], sum, "{log}");
    }
    let unpacked = called("-", &packed_log());
    assert_eq!(unpacked["estimates"], from_file["estimates"]);
    folder.refused("identify /dev/null");
}

#[test]
fn a_pass_over_a_short_log_does_not_run_into_the_next() {
    // 300 samples: fewer than a first fit usually looks at.
    let folder = changed(|lines| lines.truncate(301), &scenario());
    let result = folder.json(&format!("{REPLAY} --passes 4"));
    assert!(off(&result) < 0.02, "{result}");
}

/// As drives log the current that they measured: each row has the command of the row before.
#[test]
fn a_recursion_says_why_a_log_with_a_late_command_has_no_first_fit() {
    let late = |lines: &mut Vec<String>| {
        let heading = lines[0].split(',');
        let place = heading
            .into_iter()
            .position(|name| name.starts_with("command"));
        let place = place.expect("a command");
        for row in (2..lines.len()).rev() {
            let command = lines[row - 1].split(',').nth(place).expect("a command");
            lines[row] = with_field(&lines[row], place, command);
        }
        lines.remove(1);
    };
    let result = replayed(late, &scenario());
    let reason = &result["first_fit_rejection"]["name"];
    assert_eq!(*reason, "early-command", "{result}");
}
