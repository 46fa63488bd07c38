//! Replay from the command line: the committed log, and every way a log can be wrong.

use std::io::Write;
use std::process::{Command, Output, Stdio};

use crate::support::{
    committed_log, folder, printed_json, refusal_message, servo_id, standard_error,
};

const LOG: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../host-sim/logs/simulated-servo.csv.gz"
);
const SCENARIO: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../host-sim/scenarios/replay.toml"
);

/// The lines of the committed log.
fn lines() -> Vec<String> {
    committed_log().lines().map(str::to_owned).collect()
}

fn replay_text(test: &str, text: &str, scenario: &str) -> Output {
    let folder = folder(&format!("replay-{test}"));
    let log = folder.join("log.csv");
    std::fs::write(&log, text).expect("the log is written");
    let path = folder.join("scenario.toml");
    std::fs::write(&path, scenario).expect("the scenario is written");
    let [log, path] = [log, path].map(|path| path.display().to_string());
    servo_id(&["identify", &log, "--scenario", &path, "--json", "-"])
}

fn scenario() -> String {
    std::fs::read_to_string(SCENARIO).expect("the scenario is committed")
}

/// The committed scenario with the gradient estimator, which needs a parameter range.
fn gradient() -> String {
    scenario().replace(
        "law = \"gauss-newton\"",
        "law = \"gradient\"\nservo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }",
    )
}

/// The same without the tables and lines that begin so.
fn without(text: &str, tables: &[&str], keys: &[&str]) -> String {
    let mut inside = false;
    text.lines()
        .filter(|line| {
            if line.starts_with('[') {
                inside = tables.contains(&line.trim());
            }
            !inside && !keys.iter().any(|key| line.starts_with(key))
        })
        .map(|line| format!("{line}\n"))
        .collect()
}

/// Message about a wrong log: exit status 2 and no output.
fn refusal(test: &str, change: impl FnOnce(&mut Vec<String>)) -> String {
    let mut lines = lines();
    change(&mut lines);
    let output = replay_text(test, &(lines.join("\n") + "\n"), &scenario());
    refusal_message(&output)
}

/// A line with one of its fields changed.
fn with_field(line: &str, index: usize, value: &str) -> String {
    let mut fields: Vec<&str> = line.split(',').collect();
    fields[index] = value;
    fields.join(",")
}

/// A result without the name of its log and where it is from.
fn unnamed(mut result: serde_json::Value) -> serde_json::Value {
    let file = result["logs"][0]["file"].take();
    assert!(file.is_string(), "{result}");
    let origin = result["origin"].take();
    assert!(origin.is_object(), "{result}");
    result
}

#[test]
fn the_committed_log_gives_the_servo_that_made_it() {
    let result = printed_json(&servo_id(&[
        "identify",
        LOG,
        "--scenario",
        SCENARIO,
        "--json",
        "-",
    ]));
    let found = |name: &str| result["estimates"][name]["value"].as_f64().expect("number");
    assert!((found("a") - 0.2174).abs() < 0.03, "{result}");
    assert!((found("b") / 257.7 - 1.0).abs() < 2e-3, "{result}");
    assert!((found("coulomb") / 10.0 - 1.0).abs() < 0.03, "{result}");
    assert!((found("load") / 20.0 - 1.0).abs() < 0.02, "{result}");
    assert!(result["truth"].is_null() && result["settling_time"]["a"].is_null());
    assert_eq!(result["status"], "converged");
    assert!(result["estimates"]["b"]["std_error"].is_f64());
}

#[test]
fn each_pass_continues_from_the_last_and_pictures_are_drawn() {
    let folder = folder("replay-passes");
    let plot = folder.join("replay.svg").display().to_string();
    let path = folder.join("scenario.toml");
    std::fs::write(&path, gradient()).expect("the scenario is written");
    let path = path.display().to_string();
    let error_after = |passes: &str| {
        let arguments = [
            "identify",
            LOG,
            "--scenario",
            &path,
            "--passes",
            passes,
            "--json",
            "-",
            "--plot",
            &plot,
        ];
        let result = printed_json(&servo_id(&arguments));
        let b = result["estimates"]["b"]["value"].as_f64().expect("number");
        (b / 257.7 - 1.0).abs()
    };
    assert!(error_after("8") < 0.01);
    assert!(std::fs::read(&plot).expect("drawn").starts_with(b"<svg"));
    assert_eq!(
        servo_id(&["identify", LOG, "--scenario", &path, "--passes", "0"])
            .status
            .code(),
        Some(2)
    );
}

#[test]
fn plain_and_packed_logs_are_alike() {
    let text = lines().join("\n") + "\n";
    let plain = printed_json(&replay_text("plain", &text, &gradient()));
    let path = folder("replay-packed").join("scenario.toml");
    std::fs::write(&path, gradient()).expect("the scenario is written");
    let path = path.display().to_string();
    let packed = printed_json(&servo_id(&[
        "identify",
        LOG,
        "--scenario",
        &path,
        "--json",
        "-",
    ]));
    assert_eq!(unnamed(plain), unnamed(packed));
}

#[test]
fn a_bridged_gap_costs_next_to_nothing() {
    let mut lines = lines();
    lines.drain(500..503);
    // A stamp that went wrong, a row that was cut off.
    lines[700] = with_field(&lines[700], 0, "0.050");
    lines[900].truncate(8);
    let text = lines.join("\n") + "\n";
    let bridging = scenario() + "bridge_gaps = 3\n";
    for scenario in [scenario(), bridging] {
        let result = printed_json(&replay_text("bridged", &text, &scenario));
        let b = result["estimates"]["b"]["value"].as_f64().expect("number");
        assert!((b / 257.7 - 1.0).abs() < 0.01, "{result}");
    }
}

#[test]
fn the_command_of_the_declared_controller_is_not_compared_through_a_gap() {
    // Straight lines are nothing that a controller answered.
    let mut gaps = lines();
    for begin in (1000..7000).step_by(200).rev() {
        gaps.drain(begin..begin + 8);
    }
    let bridging = scenario() + "bridge_gaps = 8\n";
    let result = printed_json(&replay_text(
        "compared",
        &(gaps.join("\n") + "\n"),
        &bridging,
    ));
    let agreement = &result["agreement"];
    assert_eq!(agreement["holds"], true, "{agreement}");
    let largest = agreement["largest"].as_f64().expect("number");
    assert!(largest < 1e-3, "{agreement}");
}

#[test]
fn a_log_without_samples_is_refused() {
    for keep in [0, 1, 2] {
        let answer = refusal("no-samples", |lines| lines.truncate(keep));
        assert!(answer.contains("log.csv"), "{answer}");
    }
    let output = servo_id(&["identify", "no-such-log.csv", "--scenario", SCENARIO]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_broken_row_is_answered_with_its_place() {
    let answer = refusal("row", |lines| {
        "t,reference_rad,position_rad,command".clone_into(&mut lines[0])
    });
    assert!(answer.contains("column time_s"), "{answer}");
    for value in ["fast", "inf"] {
        let answer = refusal("field", |lines| {
            lines[41] = with_field(&lines[41], 2, value)
        });
        assert!(
            answer.contains("log.csv:42: column position_rad"),
            "{answer}"
        );
    }
    let endless = |filler: &str| filler.repeat((1 << 21) / filler.len());
    for row in [
        endless("1"),
        endless("1,"),
        format!("\"{}", endless("1\n")),
        endless("\n"),
    ] {
        let answer = refusal("endless", |lines| lines[41] = row);
        assert!(answer.contains("1048576"), "{answer}");
        assert!(answer.len() < 400, "{answer}");
    }
    let wide = "0,".repeat(1000);
    let answer = refusal("columns", |lines| {
        lines.iter_mut().for_each(|line| line.clone_from(&wide))
    });
    assert!(answer.contains("log.csv:1: "), "{answer}");
}

#[test]
fn a_wrongly_declared_controller_is_reported_and_does_no_harm() {
    let text = lines().join("\n") + "\n";
    let found = |result: &serde_json::Value| {
        let b = result["estimates"]["b"]["value"].as_f64();
        b.expect("number")
    };
    let right = printed_json(&replay_text("right", &text, &gradient()));
    assert_eq!(right["agreement"]["holds"], true);
    assert!(right["agreement"]["relative"].as_f64().expect("number") < 0.01);
    for (test, from, to) in [
        ("gain", "kp = 9.0", "kp = 8.0"),
        ("filter", "\"low-pass\", cutoff = 500.0", "\"difference\""),
        ("limit", "limit = 10.0", "limit = 0.5"),
    ] {
        let wrong = printed_json(&replay_text(test, &text, &gradient().replace(from, to)));
        let agreement = &wrong["agreement"];
        assert_eq!(agreement["holds"], false, "{test}: {wrong}");
        assert!(agreement["relative"].as_f64().expect("number") > 0.05);
        assert!(agreement["line"].as_u64().expect("a line") > 1);
        // The model is driven by the command that acted.
        assert!(
            (found(&wrong) / found(&right) - 1.0).abs() < 0.01,
            "{test}: {wrong}"
        );
    }
}

/// The loop is not ours: the log has the command that acted, and that is enough.
#[test]
fn a_log_with_the_command_needs_neither_controller_nor_reference() {
    let text = lines().join("\n") + "\n";
    let gains = "gamma = [1.0, 2000.0, 40.0, 40.0]\ncorrection = { kp = 4.0, kd = 0.1, ki = 2.0 }";
    let alone = without(
        &gradient(),
        &["[controller]", "[amplifier]"],
        &["reference"],
    )
    .replace("[log]", &format!("{gains}\n[log]"));
    let found = printed_json(&replay_text("alone", &text, &alone));
    let b = found["estimates"]["b"]["value"].as_f64().expect("number");
    assert!((b / 257.7 - 1.0).abs() < 0.02, "{found}");
    assert!(found["agreement"].is_null());
    // The log's own.
    assert!((found["sample_time"].as_f64().expect("number") - 1e-3).abs() < 1e-9);
}

#[test]
fn a_log_without_the_command_is_driven_by_the_declared_controllers() {
    let text = lines().join("\n") + "\n";
    let computed = without(&gradient(), &[], &["command"]);
    let b = |result: &serde_json::Value| {
        let b = result["estimates"]["b"]["value"].as_f64();
        b.expect("number")
    };
    let recorded = printed_json(&replay_text("recorded", &text, &gradient()));
    let computed = printed_json(&replay_text("computed", &text, &computed));
    assert!(computed["agreement"].is_null());
    assert!(
        (b(&computed) / b(&recorded) - 1.0).abs() < 1e-3,
        "{computed}"
    );
}

#[test]
fn keys_that_a_replay_needs_are_named() {
    let text = lines().join("\n") + "\n";
    let bare = without(&gradient(), &["[controller]"], &[]);
    for (test, scenario, key) in [
        (
            "no-controller",
            without(&bare, &[], &["command"]),
            "controller",
        ),
        (
            "no-correction",
            without(&bare, &[], &["servo_range"]),
            "identifier.correction",
        ),
        (
            "no-gamma",
            without(&gradient(), &[], &["reference"]),
            "identifier.gamma",
        ),
        (
            "nothing",
            without(&gradient(), &[], &["reference", "command"]),
            "log.command",
        ),
        (
            "speed",
            gradient().replace("[log]", "max_speed = 0.0\n[log]"),
            "identifier.max_speed",
        ),
        (
            "bandwidth",
            gradient().replace("[log]", "bandwidth = 0.0\n[log]"),
            "identifier.bandwidth",
        ),
    ] {
        let output = replay_text(test, &text, &scenario);
        let answer = standard_error(&output);
        assert_eq!(output.status.code(), Some(2), "{test}: {answer}");
        assert!(answer.contains(&format!(": {key}: ")), "{test}: {answer}");
    }
}

#[test]
fn a_scenario_without_a_servo_cannot_be_run() {
    let output = servo_id(&["run", SCENARIO]);
    assert_eq!(output.status.code(), Some(2));
    assert!(standard_error(&output).contains(": plant: "));
}

/// A servo that is stated beside the columns of a log judges the estimates and changes none.
#[test]
fn a_declared_servo_does_not_turn_a_replay_into_a_run() {
    let stated = lines().join("\n") + "\n";
    let known = scenario() + "[plant]\na = 2.0\nb = 100.0\n";
    let [unjudged, judged] = [("unjudged", scenario()), ("judged", known)]
        .map(|(test, scenario)| printed_json(&replay_text(test, &stated, &scenario)));
    assert_eq!(unjudged["estimates"], judged["estimates"]);
    assert!(unjudged["truth"].is_null());
    assert_eq!(judged["truth"]["b"].as_f64(), Some(100.0));
}

/// Without [log] the columns are those of the tool's own traces.
#[test]
fn columns_default_to_those_of_a_trace() {
    let stated = lines().join("\n") + "\n";
    let unstated = without(&scenario(), &["[log]"], &[]);
    assert_eq!(
        unnamed(printed_json(&replay_text("stated", &stated, &scenario()))),
        unnamed(printed_json(&replay_text("unstated", &stated, &unstated)))
    );
    let foreign = stated.replace("position_rad", "angle");
    let output = replay_text("foreign", &foreign, &unstated);
    let answer = standard_error(&output);
    assert_eq!(output.status.code(), Some(2), "{answer}");
    assert!(answer.contains("log.csv: column position_rad"), "{answer}");
}

#[test]
fn a_message_quotes_a_log_briefly_and_without_control_characters() {
    let field = format!("\u{1b}[2J{}", "9e".repeat(5000));
    let answer = refusal("long-field", |lines| {
        lines[41] = with_field(&lines[41], 2, &field)
    });
    assert!(answer.len() < 400 && !answer.contains('\u{1b}'), "{answer}");
    assert!(
        answer.contains("log.csv:42: column position_rad"),
        "{answer}"
    );
}

/// A few compressed bytes that expand to an endless row.
#[test]
fn a_row_that_unpacks_without_end_is_refused() {
    let path = folder("replay-bomb").join("log.csv.gz");
    let file = std::fs::File::create(&path).expect("created");
    let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
    packed
        .write_all(b"time_s,reference_rad,position_rad,command\n")
        .expect("written");
    for _ in 0..300 {
        packed.write_all(&[b'1'; 1 << 20]).expect("written");
    }
    packed.finish().expect("written");
    let output = servo_id(&[
        "identify",
        &path.display().to_string(),
        "--scenario",
        SCENARIO,
    ]);
    let answer = standard_error(&output);
    assert_eq!(output.status.code(), Some(2), "{answer}");
    assert!(answer.contains("log.csv.gz:2: "), "{answer}");
}

#[test]
#[cfg(unix)]
fn a_log_through_a_pipe_gives_what_its_file_gives() {
    let folder = folder("replay-pipe");
    let packed = std::fs::read(LOG).expect("the log");
    let plain = lines().join("\n") + "\n";
    std::fs::write(folder.join("log.csv"), &plain).expect("it is written");
    let called = |log: &str, bytes: &[u8]| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_servo-id"))
            .args(["identify", log, "--json", "-"])
            .current_dir(&folder)
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
    for log in ["-", "/dev/stdin"] {
        let piped = called(log, plain.as_bytes());
        assert_eq!(piped["estimates"], from_file["estimates"], "{log}");
        assert_eq!(&piped["origin"]["logs"][0]["sha256"], sum, "{log}");
    }
    let unpacked = called("-", &packed);
    assert_eq!(unpacked["estimates"], from_file["estimates"]);
    let nothing = servo_id(&["identify", "/dev/null"]);
    assert_eq!(nothing.status.code(), Some(2), "{nothing:?}");
}

#[test]
fn a_pass_over_a_short_log_does_not_run_into_the_next() {
    // 300 samples: fewer than a first fit usually looks at.
    let folder = folder("replay-short");
    let path = folder.join("log.csv");
    std::fs::write(&path, lines()[..301].join("\n") + "\n").expect("the log is written");
    let path = path.display().to_string();
    let arguments = [
        "identify",
        &path,
        "--scenario",
        SCENARIO,
        "--passes",
        "4",
        "--json",
        "-",
    ];
    let result = printed_json(&servo_id(&arguments));
    let b = result["estimates"]["b"]["value"].as_f64().expect("number");
    assert!((b / 257.7 - 1.0).abs() < 0.02, "{result}");
}

#[test]
fn least_squares_take_a_log_and_a_estimator_with_a_loop_of_its_own_refuses_it() {
    let with = |law: &str| {
        scenario()
            .replace("gauss-newton", law)
            .replace("[\"a\", \"b\", \"coulomb\", \"load\"]", "[\"a\", \"b\"]")
    };
    let log = lines().join("\n") + "\n";
    let result = printed_json(&replay_text("squares", &log, &with("relay-least-squares")));
    let b = result["estimates"]["b"]["value"].as_f64().expect("number");
    // The log's servo has friction, of which it knows nothing.
    assert!((b / 257.7 - 1.0).abs() < 0.1, "{result}");
    assert!(result["output_error"].is_null() && result["residual"]["rms"].is_f64());
    refusal_message(&replay_text("own-loop", &log, &with("pd-gradient")));
}

/// As drives log the current that they measured: each row has the command of the row before.
#[test]
fn a_recursion_says_why_a_log_with_a_late_command_has_no_first_fit() {
    let before = lines();
    let place = before[0]
        .split(',')
        .position(|name| name.starts_with("command"));
    let place = place.expect("a command");
    let field = |line: &str| line.split(',').nth(place).map(str::to_owned);
    let mut late = vec![before[0].clone()];
    for pair in before[1..].windows(2) {
        late.push(with_field(
            &pair[1],
            place,
            &field(&pair[0]).expect("a command"),
        ));
    }
    let text = late.join("\n") + "\n";
    let result = printed_json(&replay_text("late", &text, &scenario()));
    assert_eq!(
        result["first_fit_rejection"]["name"], "early-command",
        "{result}"
    );
}
