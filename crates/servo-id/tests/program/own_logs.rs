//! A replay reads a run's own trace: with the same scenario it gives the same estimates.

use std::path::{Path, PathBuf};

use crate::support::{argument, folder, printed_json, servo_id, standard_error};
use serde_json::Value;

const SCENARIOS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../host-sim/scenarios");

/// The result of a verb that must succeed.
fn result(arguments: &[&str]) -> Value {
    let mut result = printed_json(&servo_id(arguments));
    // A replay is from elsewhere than its run.
    result["origin"].take();
    result
}

/// The result of a run, which leaves its trace here.
fn run(scenario: &Path, log: &Path) -> Value {
    let [scenario, log] = [scenario, log].map(argument);
    result(&["run", &scenario, "--csv", &log, "--json", "-"])
}

fn replay(scenario: &Path, log: &Path) -> Value {
    let [scenario, log] = [scenario, log].map(argument);
    result(&["identify", &log, "--scenario", &scenario, "--json", "-"])
}

/// A result without its `logs`, and its `agreement` of the declared controller with the recorded command: a
/// run has neither.
fn without_agreement(mut result: Value) -> (Value, Value) {
    let agreement = result["agreement"].take();
    result["logs"] = Value::Array(Vec::new());
    (result, agreement)
}

/// A scenario of a servo with friction and load, with these lines for its identifier and after them.
fn scenario(test: &str, rest: &str) -> PathBuf {
    let path = folder(&format!("own-{test}")).join("scenario.toml");
    let text = format!(
        "[plant]\na = 0.2174\nb = 257.7\nload = 20.0\ncoulomb = 10.0\n\
         [run]\nduration = 8.0\n[identifier]\n{rest}\n"
    );
    std::fs::write(&path, text).expect("the scenario is written");
    path
}

const ALL: &str = "parameters = [\"a\", \"b\", \"coulomb\", \"load\"]";
const GRADIENT: &str = "law = \"gradient\"\nparameters = [\"a\", \"b\", \"coulomb\"]\n\
                        servo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }";
/// So low that the first command is cut off, and many later ones.
const TIGHT: &str = "[amplifier]\nlimit = 1.0";

#[test]
fn every_scenario_of_the_repository_replays_its_own_log_to_the_last_bit() {
    let folder = folder("own-repository");
    let mut replayed = 0;
    for entry in std::fs::read_dir(SCENARIOS).expect("the scenarios are there") {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&path).expect("a text");
        if !text.contains("[plant]") {
            continue;
        }
        let name = path.file_stem().expect("a name").display().to_string();
        let log = folder.join(format!("{name}.csv"));
        let first = run(&path, &log);
        let (second, agreement) = without_agreement(replay(&path, &log));
        assert_eq!(first, second, "{name}");
        // A relay is not the declared controller.
        let compared = !text.contains("law = \"relay-");
        assert_eq!(
            agreement["holds"].as_bool(),
            compared.then_some(true),
            "{name}"
        );
        replayed += 1;
    }
    assert!(replayed >= 7, "{replayed}");
}

#[test]
fn a_saturated_first_command_and_every_estimator_and_number_format_replay_to_the_last_bit() {
    let laws = [
        ("gauss-newton", format!("law = \"gauss-newton\"\n{ALL}")),
        (
            "double",
            format!("law = \"gauss-newton\"\n{ALL}\narithmetic = \"f64\""),
        ),
        ("gradient", GRADIENT.to_owned()),
        ("fixed", format!("{GRADIENT}\narithmetic = \"fixed\"")),
        (
            "pd",
            "law = \"pd-gradient\"\nservo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }".into(),
        ),
        ("relay", "law = \"relay-least-squares\"\nrelay = 0.9".into()),
    ];
    for (law, identifier) in laws {
        let path = scenario(law, &format!("{identifier}\n{TIGHT}"));
        let log = path.with_file_name("log.csv");
        let first = run(&path, &log);
        let (second, agreement) = without_agreement(replay(&path, &log));
        assert_eq!(first, second, "{law}");
        let compared = law != "relay";
        assert_eq!(
            agreement["holds"].as_bool(),
            compared.then_some(true),
            "{law}: {agreement}"
        );
    }
}

/// Position and command of every row.
fn positions_and_commands(log: &str) -> Vec<(f64, f64)> {
    log.lines()
        .skip(1)
        .map(|line| {
            let fields: Vec<f64> = line
                .split(',')
                .map(|x| x.parse().unwrap_or(f64::NAN))
                .collect();
            (fields[2], fields[3])
        })
        .collect()
}

/// The log from a row on.
fn cut(log: &Path, from: usize) -> PathBuf {
    let text = std::fs::read_to_string(log).expect("the log is written");
    let rows = text.lines().take(1).chain(text.lines().skip(1 + from));
    let path = log.with_file_name("cut.csv");
    std::fs::write(
        &path,
        rows.map(|row| format!("{row}\n")).collect::<String>(),
    )
    .expect("the log is written");
    path
}

#[test]
fn a_log_that_begins_in_motion_gives_the_same_estimates() {
    let count = std::f64::consts::TAU / 10_000.0;
    for (law, identifier) in [
        (
            "moving-gauss-newton",
            format!("law = \"gauss-newton\"\n{ALL}"),
        ),
        ("moving-gradient", GRADIENT.to_owned()),
        (
            "moving-fixed",
            format!("{GRADIENT}\narithmetic = \"fixed\""),
        ),
    ] {
        let path = scenario(law, &format!("{identifier}\n{TIGHT}"));
        let path_text = std::fs::read_to_string(&path).expect("a text");
        std::fs::write(
            &path,
            path_text.replace("duration = 8.0", "duration = 40.0"),
        )
        .expect("the scenario is written");
        let log = path.with_file_name("log.csv");
        let whole = run(&path, &log);
        let samples = positions_and_commands(&std::fs::read_to_string(&log).expect("a text"));
        // Fast, and with a command that is cut off.
        let from = (1000..2000)
            .find(|&k| {
                let step = samples[k + 1].0 - samples[k].0;
                step.abs() > 5.0 * count && samples[k].1.abs() > 0.999
            })
            .expect("a row in motion");
        let (part, agreement) = without_agreement(replay(&path, &cut(&log, from)));
        assert_eq!(agreement["holds"], true, "{law}: {agreement}");
        let found = |result: &Value, name: &str| {
            result["estimates"][name]["value"].as_f64().expect("number")
        };
        for (name, tolerance) in [("a", 0.01), ("b", 0.1), ("coulomb", 0.05), ("load", 0.05)] {
            let [whole, part] = [&whole, &part].map(|result| found(result, name));
            assert!(
                (whole - part).abs() < tolerance,
                "{law}: {name}: {whole}, {part}"
            );
        }
        // The first samples, in which its velocity is found, are not learnt from.
        let learnt = part["samples"].as_u64().expect("a count");
        let left = (samples.len() - from) as u64;
        assert!(
            (left - 20..left).contains(&learnt),
            "{law}: {learnt} of {left}"
        );
    }
}

/// The position of an ideal sensor is no whole number of counts: single precision rounds its increments
/// a little differently.
#[test]
fn an_ideal_sensors_log_gives_the_same_estimates() {
    let path = scenario(
        "ideal",
        &format!("law = \"gauss-newton\"\n{ALL}\n[encoder]\ncounts_per_rev = 0"),
    );
    let log = path.with_file_name("log.csv");
    let first = run(&path, &log);
    let second = replay(&path, &log);
    for name in ["a", "b", "coulomb", "load"] {
        let [first, second] =
            [&first, &second].map(|x| x["estimates"][name]["value"].as_f64().expect("number"));
        assert!(
            (first - second).abs() < 1e-4 * (1.0 + first.abs()),
            "{name}: {first}, {second}"
        );
    }
}

#[test]
fn fixed_point_needs_the_counts_per_revolution_and_names_the_key() {
    let path = scenario(
        "fixed-sensor",
        &format!("{GRADIENT}\narithmetic = \"fixed\""),
    );
    let log = path.with_file_name("log.csv");
    run(&path, &log);
    let text = std::fs::read_to_string(&path).expect("a text");
    let (_, identifier) = text.split_once("[identifier]").expect("an identifier");
    std::fs::write(&path, format!("[identifier]{identifier}")).expect("the scenario is written");
    let [path, log] = [path, log].map(|path| argument(&path));
    let output = servo_id(&["identify", &log, "--scenario", &path]);
    let answer = standard_error(&output);
    assert_eq!(output.status.code(), Some(2), "{answer}");
    assert!(answer.contains(": identifier.arithmetic: "), "{answer}");
    assert!(answer.contains("encoder.counts_per_rev"), "{answer}");
}
