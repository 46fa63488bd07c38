//! The contract of `servo-id tune`: its inputs, its output, its refusals.

use crate::support::{Folder, committed_log, number, own_folder, packed_log};
use identifier_log::recognise::LogOptions;
use serde_json::{Value, json};

/// A result of a fit, with the keys that `tune` reads. Its motion shows every resonance below the sampling frequency.
fn result() -> Value {
    let estimate = |value: f64, error: f64| json!({ "value": value, "std_error": error });
    let frequencies = std::iter::successors(Some(20.0), |last| Some(1.1 * last));
    let mode = |of: f64| json!({ "rad_per_s": of, "ratio": 0.0, "std_error": 1e-4 });
    let modes: Vec<Value> = frequencies
        .take_while(|of| *of < 6283.0)
        .map(mode)
        .collect();
    json!({
        "status": "converged",
        "reason": "every estimate keeps still",
        "sample_time": 1e-3,
        "estimates": {
            "a": estimate(0.2174, 0.002),
            "b": estimate(257.7, 0.1),
            "coulomb": estimate(10.0, 0.02),
            "load": estimate(20.0, 0.01),
            "delay": estimate(5e-4, 1e-5),
        },
        "residual": { "rms": 2e-4 },
        "fit": { "effects": [], "second_modes": modes },
    })
}

/// A folder with a result.
fn with(result: &Value) -> Folder {
    let folder = own_folder();
    folder.write("result.json", result.to_string());
    folder
}

/// What is tuned, of a servo whose encoder and limit are stated.
const TUNE: &str = "tune result.json --counts 10000 --limit 10";

/// The stiffest gains for 3 counts of noise, in addition to quantisation, are slower, and the predicted response
/// includes it.
#[test]
fn noise_of_counts_in_a_result_makes_the_gains_slower_and_that_of_rounding_does_not() {
    let resolution = std::f64::consts::TAU / 10_000.0;
    let [silent, rounded, noisy] = [0.0, 0.3, 3.0].map(|counts| {
        let mut result = result();
        if counts > 0.0 {
            result["noise"] = json!({ "moving": counts * resolution });
        }
        let tuned = with(&result).json(&format!("{TUNE} --stiffest"));
        ["/bandwidth", "/predicted_response/noise"].map(|key| number(&tuned, key))
    });
    assert_eq!(silent.map(f64::to_bits), rounded.map(f64::to_bits));
    assert!(noisy[0] < 0.9 * silent[0], "{silent:?} {noisy:?}");
    // 0.03 of the command that the load leaves, at most.
    assert!(noisy[1] <= 0.3 + 1e-9, "{noisy:?}");
}

#[test]
fn it_prints_a_controller_that_a_scenario_takes() {
    for (goal, feed_forward) in [
        ("--response-time 0.04", None),
        (
            "--bandwidth 80 --step 0.05 --feed-forward",
            Some("feed_forward = { bandwidth = 240.0, acceleration = 0.003880481,"),
        ),
    ] {
        let folder = with(&result());
        let page = folder.done(&format!("{TUNE} {goal}"));
        let begin = page.find("[controller]").expect("a controller");
        let (controller, _) = page[begin..].split_once("\n\n").expect("its end");
        let is_led = controller.contains(feed_forward.unwrap_or("feed_forward"));
        assert_eq!(is_led, feed_forward.is_some(), "{controller}");
        let scenario = format!(
            "[plant]\na = 0.2174\nb = 257.7\n{controller}\n[identifier]\nlaw = \"gauss-newton\"\n[run]\nduration = 1.0\n"
        );
        folder.write("scenario.toml", scenario);
        folder.done("run scenario.toml");
    }
}

/// Forces that are five standard errors from zero, and no others.
#[test]
fn known_forces_are_in_the_formula() {
    let mut result = result();
    for (name, value, std_error) in [
        ("gravity-sine", 300.0, 10.0),
        ("gravity-cosine", 40.0, 10.0),
        ("ripple-sine", -20.0, 1.0),
        ("ripple-cosine", 0.1, 1.0),
        ("dead-band", 0.2, 0.01),
    ] {
        result["estimates"][name] = json!({ "value": value, "std_error": std_error });
    }
    let folder = with(&result);
    let plant = "[plant]\na = 0.2174\nb = 257.7\ngravity = [300.0, 0.0]\nripple = [-20.0, 0.0]\nripple_order = 7\n\
                 dead_band = 0.2\n[encoder]\ncounts_per_rev = 10000\n[amplifier]\nlimit = 10.0\n\
                 [identifier]\nlaw = \"gauss-newton\"\nripple_order = 7.0\n[run]\nduration = 1.0\n";
    folder.write("scenario.toml", plant);
    let asked = "--bandwidth 80 --step 0.05 --feed-forward --scenario scenario.toml";
    let json = folder.json(&format!("{TUNE} {asked}"));
    for (name, expected) in [
        ("gravity_sine", -300.0 / 257.7),
        ("ripple_sine", 20.0 / 257.7),
        ("gravity_cosine", 0.0),
        ("ripple_cosine", 0.0),
        ("ripple_order", 7.0),
        ("dead_band", 0.2),
    ] {
        let found = number(&json, &format!("/feed_forward/{name}"));
        assert!((found - expected).abs() < 1e-9, "{name}: {found}");
    }
}

#[test]
fn json_has_the_predicted_keys() {
    let tuned = with(&result()).json(&format!("{TUNE} --bandwidth 60"));
    assert!(tuned["cap"].is_null());
    // b kp = 2 ω (ω + a), with the least friction that the servo may have.
    let kp = number(&tuned, "/kp");
    let [least, most] = [0.0, 0.2174].map(|a| 2.0 * 60.0 * (60.0 + a));
    assert!((least..most).contains(&(kp * 257.7)), "{kp}");
    assert!((number(&tuned, "/bandwidth") - 60.0).abs() < 1e-12);
    let constant = number(&tuned, "/feed_forward/constant");
    assert!((constant + 20.0 / 257.7).abs() < 1e-12, "{constant}");
    for key in [
        "rise_time",
        "overshoot",
        "settling_time",
        "sensitivity",
        "command_share",
        "noise",
        "stiffness",
    ] {
        number(&tuned, &format!("/predicted_response/{key}"));
    }
}

#[test]
fn encoder_limit_and_delay_come_from_the_scenario() {
    let text = "[plant]\na = 0.2174\nb = 257.7\n[encoder]\ncounts_per_rev = 10000\n[amplifier]\n\
                limit = 10.0\ndelay = 0.0005\ncurrent_loop = 0.0002\n[identifier]\nlaw = \"gauss-newton\"\n";
    let mut without = result();
    without["estimates"]["delay"] = Value::Null;
    // A declared delay is in the identified one, a current loop is not.
    for (result, delay) in [(result(), 0.0002), (without, 0.0007)] {
        let folder = with(&result);
        folder.write("scenario.toml", text);
        let declared = folder.json("tune result.json --step 0.02 --scenario scenario.toml");
        let stated = folder.json(&format!("{TUNE} --step 0.02 --command-delay {delay}"));
        assert_eq!(declared, stated, "{delay}");
    }
}

/// Calls that are refused, and what the message names. The command that holds the load is 0.0776.
const REFUSED: &str = "
tune result.json --limit 10 | --counts
tune result.json --counts 4096 | --limit
tune result.json --counts 4096 --limit 0.05 | -0.0776
tune result.json --counts 10000 --limit -3 | --limit = -3
tune result.json --counts 10000 --limit NaN | --limit = NaN
tune result.json --limit 10 --counts -3 | --counts = -3
tune result.json --limit 10 --counts NaN | --counts = NaN
TUNE --sample-time 0 | --sample-time =
TUNE --resonance 0 | --resonance =
TUNE --step 0.001 | --step =
TUNE --step NaN | --step =
TUNE --bandwidth 3 --step 0.01 | --step 0.01:
TUNE --for vesc | --command-unit A
TUNE --for vesc --command-unit A | --max-current
TUNE --for sparkmax --command-unit V --bus-voltage -1 | --bus-voltage
TUNE --for esc | --for
TUNE --max-current 60 | --for
TUNE --for odrive --command-unit Nm --response-time 0.002 | --response-time 0.002:
TUNE --encoder-on both | --encoder-on
TUNE --command-sign minus | --command-sign
TUNE --command-unit furlong | --command-unit
";

#[test]
fn what_is_missing_impossible_or_out_of_its_range_is_refused_by_name() {
    let folder = with(&result());
    folder.assert_refused(&REFUSED.replace("TUNE", TUNE));
    for sentence in include_str!("../../../../identifier-core/tests/tuning/refusals.txt").lines() {
        let (name, told) = sentence.split_once(" = ").expect("a value");
        let (value, _) = told.split_once(' ').expect("a sentence");
        let option = format!("--{}", name.replace('_', "-"));
        let message = folder.refused(&format!("{TUNE} {option} {value}"));
        assert!(message.contains(&format!("{option} = {told}")), "{message}");
    }
}

#[test]
fn a_result_that_has_not_converged_is_refused_unless_it_is_accepted() {
    let mut moving = result();
    moving["status"] = json!("moving");
    let folder = with(&moving);
    folder.refused(TUNE);
    folder.done(&format!("{TUNE} --accept-unconverged"));
}

#[test]
fn a_demand_beyond_the_servo_is_refused_with_the_figure_that_would_do() {
    let folder = with(&result());
    let message = folder.refused(&format!("{TUNE} --response-time 0.002"));
    let (_, would_do) = message.split_once("ask for ").expect("advice");
    let would_do = would_do.split(' ').next().expect("a figure");
    folder.done(&format!("{TUNE} --response-time {would_do}"));
}

/// The parameters of a firmware, to be typed in, and the same in the JSON.
#[test]
fn gains_are_stated_in_the_form_of_a_drive() {
    let folder = with(&result());
    let odrive = format!("{TUNE} --for odrive --command-unit Nm");
    let page = folder.done(&odrive);
    let form = &folder.json(&odrive)["form"];
    for parameter in form["parameters"].as_array().expect("parameters") {
        let of = |key: &str| parameter[key].as_str().expect("a text");
        let value = parameter["value"].as_f64().expect("a number");
        let line = format!("{} = {value} {}", of("name"), of("unit"));
        assert!(page.contains(line.trim_end()), "{line}: {page}");
    }
    assert_eq!(form["name"], json!("odrive"));
    assert_eq!(form["exactness"], json!("needs ki cut"));
    assert!(number(form, "/margins/sensitivity") < 1.61);
    assert!(page.contains("needs ki cut"), "{page}");
    // A unit that nothing states is not assumed.
    let refused = folder.refused(&format!("{TUNE} --for odrive"));
    assert!(refused.contains("--command-unit Nm"), "{refused}");
}

/// The report of a log, the verb tune on its result, and the playground: one function, with the largest command as limit.
#[test]
fn a_report_tune_and_the_playground_have_the_same_gains() {
    let folder = own_folder();
    folder.write("log.csv.gz", packed_log());
    folder.done("identify log.csv.gz --json result.json --report report.html");
    let page = folder.done("tune result.json");
    let report = folder.read("report.html");
    let gains = |text: &str| -> Vec<String> {
        let lines = text.lines();
        let lines = lines.map(|line| line.rsplit('>').next().unwrap_or(line).trim());
        let is_gain = |line: &&str| {
            let mut names = ["kp = ", "kd = ", "ki = "].iter();
            names.any(|name| line.starts_with(name))
        };
        lines.filter(is_gain).map(str::to_owned).collect()
    };
    assert_eq!(gains(&page).len(), 3, "{page}");
    assert_eq!(gains(&report), gains(&page));
    let limit = "the largest command of the log";
    assert!(report.contains(limit), "said beside the gains");
    let text = committed_log().into_bytes();
    let found = playground::log::identify(text, &LogOptions::default()).expect("identified");
    let tuning = found.tuned.expect("gains").tuning;
    let of_tune = folder.json("tune result.json");
    for (name, gain) in [("kp", tuning.kp), ("kd", tuning.kd), ("ki", tuning.ki)] {
        assert_eq!(of_tune[name], json!(gain), "{name}");
    }
}

/// Rows that are numbered in a column of the name of a time may be ms: what follows from it waits until that is stated.
#[test]
fn a_time_that_is_assumed_has_no_gains_no_inertia_and_no_export() {
    let folder = own_folder();
    let mut rows = String::from("t,position_rad,effort_Nm\n");
    for (number, line) in committed_log().lines().skip(1).enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        rows += &format!("{number},{},{}\n", cells[2], cells[3]);
    }
    folder.write("log.csv", rows);
    for (unit, is_open) in [("", true), (" --time-unit ms", false)] {
        folder.done(&format!(
            "identify log.csv{unit} --json result.json --force"
        ));
        let found = folder.read_json("result.json");
        assert_eq!(found["code"] == json!(51), is_open, "{}", found["reason"]);
        assert_eq!(found["physical"].is_null(), is_open);
        for command in [TUNE, "export result.json --format json"] {
            match is_open {
                true => {
                    let refused = folder.refused(command);
                    assert!(refused.contains("--time-unit"), "{refused}");
                }
                false => drop(folder.done(command)),
            }
        }
    }
}
