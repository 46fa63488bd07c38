//! Several logs of one servo: identification on one after the other, and prediction of others.

use crate::support::{Folder, estimate, number, own_folder};

const PLANT: &str = "[plant]\na = 0.2174\nb = 257.7\nload = 20.0\ncoulomb = 10.0\n";
pub(crate) const CONTROLLER: &str =
    "[controller]\nkp = 9.0\nkd = 0.19\nki = 4.0\n[amplifier]\nlimit = 10.0\n";
pub(crate) const ALL: &str = "parameters = [\"a\", \"b\", \"coulomb\", \"load\"]";

const COUNT: f64 = std::f64::consts::TAU / 10_000.0;

/// Writes the log of a run of 4 s with a noise of this seed, `SEED.csv`, of a servo with effects.
pub(crate) fn log(folder: &Folder, seed: u32, effects: &str) {
    log_under(CONTROLLER, folder, seed, effects);
}

/// The same under a controller.
fn log_under(controller: &str, folder: &Folder, seed: u32, effects: &str) {
    let text =
        format!("{PLANT}{effects}{controller}[run]\nduration = 4.0\n[excitation]\nseed = {seed}\n");
    folder.write("run.toml", text);
    folder.done(&format!("run run.toml --csv {seed}.csv"));
}

/// A folder with the logs `1.csv`, `2.csv` and `3.csv`.
fn three_logs() -> Folder {
    let folder = own_folder();
    [1, 2, 3].iter().for_each(|seed| log(&folder, *seed, ""));
    folder
}

/// Writes a scenario without a servo, with these parameters and tables.
pub(crate) fn scenario(folder: &Folder, parameters: &str, rest: &str) {
    let text = format!(
        "[encoder]\ncounts_per_rev = 10000\n[identifier]\nlaw = \"gauss-newton\"\n{parameters}\n\
         {rest}[log]\ntime = \"time_s\"\nreference = \"reference_rad\"\nposition = \"position_rad\"\n\
         angle = \"absolute\"\ncommand = \"command\"\n"
    );
    folder.write("replay.toml", text);
}

#[test]
fn a_servo_identified_from_two_logs_predicts_a_third() {
    let folder = three_logs();
    scenario(&folder, ALL, CONTROLLER);
    const CALL: &str = "identify 1.csv 2.csv --scenario replay.toml --predict 3.csv";
    let found = folder.json(&format!("{CALL} --predict 2.csv"));
    assert_eq!(found["logs"].as_array().map(Vec::len), Some(3));
    let b = estimate(&found, "b");
    assert!((b / 257.7 - 1.0).abs() < 1e-3, "{found}");
    let [third, learnt] = [0, 1].map(|place| &found["predictions"][place]);
    assert_eq!(third["learnt_from"], false);
    assert_eq!(learnt["learnt_from"], true);
    // The encoder's rounding reaches the recorded command through the derivative.
    assert_eq!(third["open_loop"]["unit"], "rad");
    let rms = number(third, "/open_loop/rms");
    assert!(rms < 2.0 * COUNT, "{third}");
    let closed = &third["closed_loop"];
    let travel = rms / number(third, "/open_loop/relative");
    assert!(number(closed, "/position") * travel < COUNT, "{third}");
    assert!(number(closed, "/velocity") < 0.03, "{third}");
    assert!(number(closed, "/command") < 0.03, "{third}");
    // A model without friction predicts worse, in each respect.
    scenario(&folder, "parameters = [\"a\", \"b\", \"load\"]", CONTROLLER);
    let worse = &folder.json(CALL)["predictions"][0];
    assert!(number(worse, "/open_loop/rms") > 10.0 * rms, "{worse}");
    for name in ["position", "velocity", "command"] {
        let of = |prediction| number(prediction, &format!("/closed_loop/{name}"));
        assert!(of(worse) > 1.2 * of(third), "{name}: {worse}, {closed}");
    }
}

/// One fit to two logs, each under a controller of its own which is not declared, with an amplifier that is not either.
#[test]
fn a_fit_of_two_logs_predicts_a_third_with_what_it_found() {
    const EFFECTS: &str = "current_loop = 0.004\n";
    let folder = own_folder();
    let softer = CONTROLLER.replace("kp = 9.0", "kp = 4.0");
    let softer = softer.replace("kd = 0.19", "kd = 0.12");
    for (seed, controller) in [(1, CONTROLLER), (2, &softer), (3, CONTROLLER)] {
        log_under(controller, &folder, seed, EFFECTS);
    }
    scenario(&folder, "", "");
    let text = folder.read("replay.toml");
    folder.write("replay.toml", text.replace("gauss-newton", "fit"));
    // The same by the verb that needs no scenario.
    for options in ["--scenario replay.toml", "--counts-per-rev 10000"] {
        let found = folder.json(&format!("identify 1.csv 2.csv --predict 3.csv {options}"));
        assert_eq!(found["fit"]["samples"], 8000, "{found}");
        assert_eq!(found["status"], "converged", "{found}");
        let b = estimate(&found, "b");
        assert!((b / 257.7 - 1.0).abs() < 2e-3, "{found}");
        let rms = number(&found, "/predictions/0/open_loop/rms");
        assert!(rms < 3.0 * COUNT, "{found}");
    }
}

#[test]
fn a_second_log_continues_from_the_first_estimates() {
    let folder = three_logs();
    scenario(&folder, ALL, CONTROLLER);
    let [one, both] = ["1.csv", "1.csv 2.csv"]
        .map(|logs| folder.json(&format!("identify {logs} --scenario replay.toml")));
    assert_eq!(one["samples"], 4000);
    assert_eq!(both["samples"], 8000);
    let [first, second] = [&one, &both].map(|result| number(result, "/estimates/b/std_error"));
    assert!(second < 0.9 * first, "{one}\n{both}");
    assert_eq!(both["agreement"]["holds"], true, "{both}");
    for (name, truth, within) in [
        ("b", 257.7, 0.1),
        ("coulomb", 10.0, 0.05),
        ("load", 20.0, 0.05),
    ] {
        let found = estimate(&both, name);
        assert!((found - truth).abs() < within, "{name}: {found}");
    }
    assert_eq!(both["predictions"], serde_json::json!([]));
    // Without a controller the command alone predicts.
    scenario(&folder, ALL, "");
    let found = folder.json("identify 1.csv --scenario replay.toml --predict 2.csv");
    let prediction = &found["predictions"][0];
    assert!(prediction["closed_loop"].is_null(), "{prediction}");
    assert!(number(prediction, "/open_loop/relative") < 0.05);
}

#[test]
fn logs_of_different_rates_are_refused() {
    let folder = three_logs();
    let slow = CONTROLLER.replace("[controller]", "[controller]\nsample_time = 0.002");
    log_under(&slow, &folder, 4, "");
    for rest in ["", CONTROLLER] {
        scenario(&folder, ALL, rest);
        folder.assert_refused(
            "identify --scenario replay.toml 1.csv 4.csv | 4.csv: \n\
             identify --scenario replay.toml 1.csv --predict 4.csv | 4.csv: \n\
             identify --scenario replay.toml 1.csv --predict no.csv | no.csv: the log cannot be read",
        );
    }
}

/// An angle is the log's own, at the start of a log, of a second log, and after an excluded range.
#[test]
fn gravity_follows_the_angle_of_the_log() {
    const TURNED: f64 = 1.0;
    let folder = own_folder();
    // Where each begins is at another angle.
    for (seed, from) in [(1, 0), (2, 2317), (3, 1234)] {
        let text = format!(
            "[plant]\na = 0.5\nb = 250.0\ncoulomb = 5.0\ngravity = [-30.0, 12.0]\n{CONTROLLER}\
             [run]\nduration = 12.0\n[excitation]\nseed = {seed}\npower = 0.2\nsample_time = 0.3\n"
        );
        folder.write("run.toml", text);
        let trace = folder.done("run run.toml --csv -");
        let mut rows = "time_s,reference_rad,position_rad,command\n".to_owned();
        for line in trace.lines().skip(1 + from) {
            let fields: Vec<f64> = line.split(',').flat_map(str::parse).collect();
            let [time, reference, position, command, ..] = fields[..] else {
                panic!("{line}")
            };
            let [reference, position] = [reference, position].map(|angle| angle + TURNED);
            rows += &format!("{time},{reference},{position},{command}\n");
        }
        folder.write(&format!("{seed}.csv"), rows);
    }
    let parameters = "parameters = [\"a\", \"b\", \"coulomb\"]\nrequired_terms = [\"gravity\"]\narithmetic = \"f64\"";
    scenario(&folder, parameters, CONTROLLER);
    let found = folder.json("identify 1.csv 2.csv --predict 3.csv --scenario replay.toml");
    let (sine, cosine) = (TURNED.sin(), TURNED.cos());
    for (name, expected) in [
        ("gravity-sine", -30.0 * cosine + 12.0 * sine),
        ("gravity-cosine", 30.0 * sine + 12.0 * cosine),
    ] {
        let size = estimate(&found, name);
        assert!((size - expected).abs() < 0.3, "{name} {expected}: {found}");
    }
    let off = number(&found, "/predictions/0/open_loop/relative");
    assert!(off < 0.02, "{found}");
    // A counter that began anywhere does not know the angle.
    let text = folder.read("replay.toml");
    folder.write("replay.toml", text.replace("angle = \"absolute\"", ""));
    let why = folder.refused("identify 1.csv --scenario replay.toml");
    assert!(
        why.contains("log.angle") && why.contains("absolute"),
        "{why}"
    );
}
