//! A result is reproduced from itself, to the last bit, or refused with the reason.

use std::path::{Path, PathBuf};
use std::process::Output;

use crate::support::{argument, assert_done, folder, servo_id, standard_error};
use serde_json::{Value, json};

const SCENARIO: &str = "# a servo\n[plant]\na = 0.2174\nb = 257.7\nload = 20.0\n[encoder]\nnoise = 1e-4\n\
                        [amplifier]\nlimit = 10.0\n[identifier]\nlaw = \"gauss-newton\"\n\
                        parameters = [\"a\", \"b\", \"load\"]\n[run]\nduration = 3.0\nseed = 7\n";

fn done(arguments: &[&str]) -> Output {
    let answer = servo_id(arguments);
    assert_done(&answer);
    answer
}

fn read(file: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(file).expect("a result")).expect("JSON")
}

/// A run that can be reproduced; its scenario is gone.
fn ran(test: &str) -> (PathBuf, [PathBuf; 2]) {
    let folder = folder(test);
    let scenario = folder.join("servo.toml");
    std::fs::write(&scenario, SCENARIO).expect("written");
    let files = ["r.json", "r.csv"].map(|name| folder.join(name));
    let [json, csv] = files.each_ref().map(|file| argument(file));
    done(&["run", &argument(&scenario), "--json", &json, "--csv", &csv]);
    std::fs::remove_file(scenario).expect("it was there");
    (folder, files)
}

#[test]
fn a_run_is_reproduced_from_json_and_from_the_file_beside_a_trace() {
    let (folder, [json, csv]) = ran("rerun-run");
    let origin = &read(&json)["origin"];
    assert_eq!(origin["version"], servo_id::VERSION);
    assert_eq!(origin["seed"], 7);
    assert_eq!(origin["scenario"]["text"], SCENARIO);
    assert_eq!(origin["command"][1], "run");
    let answer = done(&["reproduce", &argument(&json)]);
    assert_eq!(standard_error(&answer), "");
    let (again, trace) = (folder.join("again.json"), folder.join("again.csv"));
    let beside = folder.join("r.csv-metadata.json");
    let outputs = ["--json", &argument(&again), "--csv", &argument(&trace)];
    done(&[&["reproduce", &argument(&beside)][..], &outputs].concat());
    assert_eq!(
        std::fs::read(&csv).expect("a trace"),
        std::fs::read(&trace).expect("a trace")
    );
    let without = |file: &Path| {
        let mut result = read(file);
        result.as_object_mut().expect("an object").remove("origin");
        result
    };
    assert_eq!(without(&json), without(&again));
    // A reproduced result has its origin, too.
    done(&["reproduce", &argument(&again)]);
    // A result is read, and so is not written over.
    let answer = servo_id(&[
        "reproduce",
        &argument(&json),
        "--json",
        &argument(&json),
        "--force",
    ]);
    assert_eq!(answer.status.code(), Some(2));
}

#[test]
fn a_different_version_and_a_different_result_are_reported() {
    let (folder, [json, ..]) = ran("rerun-other");
    let mut result = read(&json);
    result["origin"]["version"] = json!("0.0.9 (0123456789ab)");
    let other = folder.join("other.json");
    std::fs::write(&other, result.to_string()).expect("written");
    let answer = done(&["reproduce", &argument(&other)]);
    let warning = standard_error(&answer);
    for version in ["0.0.9 (0123456789ab)", servo_id::VERSION] {
        assert!(warning.contains(version), "{warning}");
    }

    let b = result["estimates"]["b"]["value"]
        .as_f64()
        .expect("a number");
    result["estimates"]["b"]["value"] = json!(b.next_up());
    std::fs::write(&other, result.to_string()).expect("written");
    let answer = servo_id(&["reproduce", &argument(&other)]);
    assert_eq!(answer.status.code(), Some(1));
    let message = format!("estimates.b.value: {} before, {b} now", b.next_up());
    assert!(standard_error(&answer).contains(&message), "{answer:?}");

    for bytes in [
        "no result",
        "[1]",
        "{\"status\": \"converged\"}",
        "{\"origin\": {\"version\": 1}}",
    ] {
        std::fs::write(&other, bytes).expect("written");
        let answer = servo_id(&["reproduce", &argument(&other)]);
        assert_eq!(answer.status.code(), Some(2));
    }
}

#[test]
fn a_replay_is_reproduced_from_the_same_log_and_from_no_other() {
    let (folder, [.., csv]) = ran("rerun-replay");
    let scenario = folder.join("log.toml");
    let columns = "[encoder]\ncounts_per_rev = 10000\n[identifier]\nlaw = \"gauss-newton\"\n\
                   parameters = [\"a\", \"b\", \"load\"]\n[log]\ntime = \"time_s\"\n\
                   position = \"position_rad\"\ncommand = \"command\"\n";
    std::fs::write(&scenario, columns).expect("written");
    let json = argument(&folder.join("p.json"));
    let (log, scenario) = (argument(&csv), argument(&scenario));
    let outputs = ["--json", &json];
    let arguments = [
        "identify",
        &log,
        "--scenario",
        &scenario,
        "--passes",
        "2",
        "--predict",
        &log,
    ];
    done(&[&arguments[..], &outputs].concat());
    done(&["reproduce", &json]);
    // A log that has moved with its result.
    let elsewhere = folder.join("elsewhere");
    std::fs::create_dir(&elsewhere).expect("a folder");
    let (moved, kept) = (elsewhere.join("r.csv"), elsewhere.join("p.json"));
    std::fs::copy(&csv, &moved).expect("copied");
    std::fs::copy(&json, &kept).expect("copied");
    std::fs::remove_file(&csv).expect("it was there");
    done(&["reproduce", &argument(&kept)]);

    let answer = servo_id(&["reproduce", &json]);
    assert_eq!(answer.status.code(), Some(2));
    let changed = std::fs::read_to_string(&moved).expect("a log");
    std::fs::write(&moved, changed.replacen(",0,", ",0.0,", 1) + "\n").expect("written");
    let answer = servo_id(&["reproduce", &argument(&kept)]);
    assert_eq!(answer.status.code(), Some(2));
}

#[test]
fn a_commissioning_is_reproduced() {
    let folder = folder("rerun-commission");
    let scenario = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../host-sim/scenarios/commission.toml"
    );
    let [json, csv] = ["k.json", "k.csv"].map(|name| argument(&folder.join(name)));
    done(&["commission", scenario, "--json", &json, "--csv", &csv]);
    done(&["reproduce", &json]);
    assert!(Path::new(&(csv + "-metadata.json")).is_file());
}
