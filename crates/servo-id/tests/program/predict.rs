//! Several logs of one servo: identification on one after the other, and prediction of others.

use std::path::{Path, PathBuf};

use crate::support::{argument, assert_done, folder, printed_json, servo_id, standard_error};
use serde_json::Value;

const PLANT: &str = "[plant]\na = 0.2174\nb = 257.7\nload = 20.0\ncoulomb = 10.0\n";
pub(crate) const CONTROLLER: &str =
    "[controller]\nkp = 9.0\nkd = 0.19\nki = 4.0\n[amplifier]\nlimit = 10.0\n";
pub(crate) const ALL: &str = "parameters = [\"a\", \"b\", \"coulomb\", \"load\"]";

/// The log of a run with a noise of this seed.
fn log(folder: &Path, seed: u32, sample_time: f64) -> PathBuf {
    log_of(folder, seed, sample_time, "")
}

/// The same of a servo with effects.
pub(crate) fn log_of(folder: &Path, seed: u32, sample_time: f64, effects: &str) -> PathBuf {
    log_under(CONTROLLER, folder, seed, sample_time, effects)
}

/// The same under a controller.
fn log_under(
    controller: &str,
    folder: &Path,
    seed: u32,
    sample_time: f64,
    effects: &str,
) -> PathBuf {
    let scenario = folder.join(format!("run-{seed}.toml"));
    let controller = controller.replace(
        "[controller]",
        &format!("[controller]\nsample_time = {sample_time}"),
    );
    let text =
        format!("{PLANT}{effects}{controller}[run]\nduration = 4.0\n[excitation]\nseed = {seed}\n");
    std::fs::write(&scenario, text).expect("written");
    let log = folder.join(format!("{seed}.csv"));
    let [run, csv] = [&scenario, &log].map(|path| argument(path));
    let output = servo_id(&["run", &run, "--csv", &csv]);
    assert_done(&output);
    log
}

/// A scenario without a servo, with these parameters and tables.
pub(crate) fn scenario(folder: &Path, parameters: &str, rest: &str) -> PathBuf {
    let path = folder.join("replay.toml");
    let text = format!(
        "[encoder]\ncounts_per_rev = 10000\n[identifier]\nlaw = \"gauss-newton\"\n{parameters}\n\
         {rest}[log]\ntime = \"time_s\"\nreference = \"reference_rad\"\nposition = \"position_rad\"\n\
         angle = \"absolute\"\n         command = \"command\"\n"
    );
    std::fs::write(&path, text).expect("written");
    path
}

fn replay(logs: &[&Path], predict: &[&Path], scenario: &Path) -> std::process::Output {
    let mut arguments = vec!["identify".to_owned()];
    arguments.extend(logs.iter().map(|path| argument(path)));
    arguments.extend(["--scenario".to_owned(), argument(scenario)]);
    for path in predict {
        arguments.extend(["--predict".to_owned(), argument(path)]);
    }
    arguments.extend(["--json".to_owned(), "-".to_owned()]);
    servo_id(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
}

fn result(logs: &[&Path], predict: &[&Path], scenario: &Path) -> Value {
    printed_json(&replay(logs, predict, scenario))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[test]
fn a_servo_identified_from_two_logs_predicts_a_third() {
    let folder = folder("predict-third");
    let [a, b, c] = [1, 2, 3].map(|seed| log(&folder, seed, 1e-3));
    let whole = scenario(&folder, ALL, CONTROLLER);
    let found = result(&[&a, &b], &[&c, &b], &whole);
    assert_eq!(found["logs"].as_array().map(Vec::len), Some(3));
    let of_b = number(&found["estimates"]["b"]["value"]);
    assert!((of_b / 257.7 - 1.0).abs() < 1e-3, "{found}");
    let [third, learnt] = [&found["predictions"][0], &found["predictions"][1]];
    assert_eq!(third["learnt_from"], false);
    assert_eq!(learnt["learnt_from"], true);
    // The encoder's rounding reaches the recorded command through the derivative.
    let count = std::f64::consts::TAU / 10_000.0;
    let open = &third["open_loop"];
    assert_eq!(open["unit"], "rad");
    assert!(number(&open["rms"]) < 2.0 * count, "{third}");
    let closed = &third["closed_loop"];
    let travel = number(&open["rms"]) / number(&open["relative"]);
    assert!(number(&closed["position"]) * travel < count, "{third}");
    assert!(number(&closed["velocity"]) < 0.03, "{third}");
    assert!(number(&closed["command"]) < 0.03, "{third}");
    // A model without friction predicts worse, in each respect.
    let bare = scenario(&folder, "parameters = [\"a\", \"b\", \"load\"]", CONTROLLER);
    let worse = result(&[&a, &b], &[&c], &bare);
    let worse = &worse["predictions"][0];
    assert!(
        number(&worse["open_loop"]["rms"]) > 10.0 * number(&open["rms"]),
        "{worse}"
    );
    for name in ["position", "velocity", "command"] {
        let worse = number(&worse["closed_loop"][name]);
        assert!(
            worse > 1.2 * number(&closed[name]),
            "{name}: {worse}, {closed}"
        );
    }
}

/// One fit to two logs, each under a controller of its own which is not declared, with an amplifier that is not either.
#[test]
fn a_fit_of_two_logs_predicts_a_third_with_what_it_found() {
    const EFFECTS: &str = "current_loop = 0.004\n";
    let folder = folder("predict-fit");
    let softer = CONTROLLER
        .replace("kp = 9.0", "kp = 4.0")
        .replace("kd = 0.19", "kd = 0.12");
    let a = log_of(&folder, 1, 1e-3, EFFECTS);
    let b = log_under(&softer, &folder, 2, 1e-3, EFFECTS);
    let c = log_of(&folder, 3, 1e-3, EFFECTS);
    let path = scenario(&folder, "", "");
    let text = std::fs::read_to_string(&path).expect("it was written");
    std::fs::write(&path, text.replace("gauss-newton", "fit")).expect("written");
    let found = result(&[&a, &b], &[&c], &path);
    assert_eq!(found["fit"]["samples"], 8000, "{found}");
    assert_eq!(found["status"], "converged", "{found}");
    let of_b = number(&found["estimates"]["b"]["value"]);
    assert!((of_b / 257.7 - 1.0).abs() < 2e-3, "{found}");
    let count = std::f64::consts::TAU / 10_000.0;
    let third = &found["predictions"][0]["open_loop"];
    assert!(number(&third["rms"]) < 3.0 * count, "{third}");
    // The same by the verb that needs no scenario.
    let [a, b, c] = [&a, &b, &c].map(|path| argument(path));
    let identified = printed_json(&servo_id(&[
        "identify",
        &a,
        &b,
        "--predict",
        &c,
        "--counts-per-rev",
        "10000",
        "--json",
        "-",
    ]));
    assert_eq!(identified["fit"]["samples"], 8000, "{identified}");
    let again = &identified["predictions"][0]["open_loop"];
    assert!(number(&again["rms"]) < 3.0 * count, "{again}");
}

#[test]
fn estimates_that_do_not_predict_another_log_are_not_converged() {
    let folder = folder("predict-another");
    let [a, b] = [1, 2].map(|seed| log(&folder, seed, 1e-3));
    // The brake drags.
    let c = log_of(
        &folder,
        3,
        1e-3,
        "low_speed_friction = 25.0\nlow_speed_velocity = 100.0\n",
    );
    let scenario = scenario(&folder, ALL, CONTROLLER);
    let same = result(&[&a], &[&b], &scenario);
    assert_eq!(same["status"], "converged", "{same}");
    let other = result(&[&a], &[&b, &c], &scenario);
    assert_eq!(other["status"], "unexplained", "{other}");
    assert_eq!(other["code"], 43, "{other}");
}

#[test]
fn a_second_log_continues_from_the_first_estimates() {
    let folder = folder("predict-second");
    let [a, b] = [1, 2].map(|seed| log(&folder, seed, 1e-3));
    let scenario = scenario(&folder, ALL, CONTROLLER);
    let [one, both] = [&[a.as_path()][..], &[&a, &b]].map(|logs| result(logs, &[], &scenario));
    assert_eq!(one["samples"], 4000);
    assert_eq!(both["samples"], 8000);
    let error = |result: &Value| number(&result["estimates"]["b"]["std_error"]);
    assert!(error(&both) < 0.9 * error(&one), "{one}\n{both}");
    assert_eq!(both["agreement"]["holds"], true, "{both}");
    for (name, truth, within) in [
        ("b", 257.7, 0.1),
        ("coulomb", 10.0, 0.05),
        ("load", 20.0, 0.05),
    ] {
        let found = number(&both["estimates"][name]["value"]);
        assert!((found - truth).abs() < within, "{name}: {found}");
    }
    assert_eq!(both["predictions"], Value::Array(Vec::new()));
}

#[test]
fn without_a_controller_the_command_alone_predicts() {
    let folder = folder("predict-open");
    let [a, b] = [1, 2].map(|seed| log(&folder, seed, 1e-3));
    let scenario = scenario(&folder, ALL, "");
    let found = result(&[&a], &[&b], &scenario);
    let prediction = &found["predictions"][0];
    assert!(prediction["closed_loop"].is_null(), "{prediction}");
    assert!(
        number(&prediction["open_loop"]["relative"]) < 0.05,
        "{prediction}"
    );
}

#[test]
fn logs_of_different_rates_are_refused() {
    let folder = folder("predict-rates");
    let (a, b) = (log(&folder, 1, 1e-3), log(&folder, 2, 2e-3));
    for rest in ["", CONTROLLER] {
        let scenario = scenario(&folder, ALL, rest);
        for (logs, predict) in [(&[&*a, &*b][..], &[][..]), (&[&*a][..], &[&*b][..])] {
            let output = replay(logs, predict, &scenario);
            let answer = standard_error(&output);
            assert_eq!(output.status.code(), Some(2), "{answer}");
            assert!(answer.contains("2.csv: "), "{answer}");
        }
    }
    let missing = folder.join("nowhere.csv");
    let scenario = scenario(&folder, ALL, "");
    let output = replay(&[&a], &[&missing], &scenario);
    assert_eq!(output.status.code(), Some(2));
    assert!(standard_error(&output).contains("nowhere.csv: the log cannot be read"));
}

/// An angle is the log's own, at the start of a log, of a second log, and after an excluded range.
#[test]
fn gravity_follows_the_angle_of_the_log() {
    const TURNED: f64 = 1.0;
    let folder = folder("predict-gravity");
    let run = |name: &str, seed: u32, turned: f64, from: usize| {
        let scenario = folder.join(format!("{name}.toml"));
        let text = format!(
            "[plant]\na = 0.5\nb = 250.0\ncoulomb = 5.0\ngravity = [-30.0, 12.0]\n{CONTROLLER}\
             [run]\nduration = 12.0\n[excitation]\nseed = {seed}\npower = 0.2\nsample_time = 0.3\n"
        );
        std::fs::write(&scenario, text).expect("written");
        let log = folder.join(format!("{name}.csv"));
        let [run, csv] = [&scenario, &log].map(|path| argument(path));
        let output = servo_id(&["run", &run, "--csv", &csv]);
        assert_done(&output);
        let text = std::fs::read_to_string(&log).expect("written");
        let mut rows = "time_s,reference_rad,position_rad,command\n".to_owned();
        for line in text.lines().skip(1 + from) {
            let fields: Vec<f64> = line
                .split(',')
                .take(4)
                .map(|x| x.parse().expect("a number"))
                .collect();
            let [time, reference, position, command] = fields[..] else {
                panic!("{line}")
            };
            rows += &format!(
                "{time},{},{},{command}\n",
                reference + turned,
                position + turned
            );
        }
        std::fs::write(&log, rows).expect("written");
        log
    };
    // Where each begins is at another angle.
    let (a, b) = (run("first", 1, TURNED, 0), run("second", 2, TURNED, 2317));
    let c = run("third", 3, TURNED, 1234);
    let parameters = "parameters = [\"a\", \"b\", \"coulomb\"]\nrequired_terms = [\"gravity\"]\narithmetic = \"f64\"";
    let whole = scenario(&folder, parameters, CONTROLLER);
    let found = result(&[&a, &b], &[&c], &whole);
    let term = |name: &str| number(&found["estimates"][name]["value"]);
    let (sine, cosine) = (TURNED.sin(), TURNED.cos());
    let (by_sine, by_cosine) = (-30.0 * cosine + 12.0 * sine, 30.0 * sine + 12.0 * cosine);
    assert!(
        (term("gravity-sine") - by_sine).abs() < 0.3,
        "{by_sine}: {found}"
    );
    assert!(
        (term("gravity-cosine") - by_cosine).abs() < 0.3,
        "{by_cosine}: {found}"
    );
    let open = &found["predictions"][0]["open_loop"];
    assert!(number(&open["relative"]) < 0.02, "{open}");
    // A counter that began anywhere does not know the angle.
    let text = std::fs::read_to_string(&whole).expect("it was written");
    std::fs::write(&whole, text.replace("angle = \"absolute\"", "")).expect("written");
    let refused = replay(&[&a], &[], &whole);
    assert_eq!(refused.status.code(), Some(2));
    let why = standard_error(&refused);
    assert!(
        why.contains("log.angle") && why.contains("absolute"),
        "{why}"
    );
}
