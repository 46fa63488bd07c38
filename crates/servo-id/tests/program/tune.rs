//! The contract of `servo-id tune`: its inputs, its output, its refusals.

use std::path::Path;
use std::process::Output;

use crate::support::{assert_done, committed_log, folder, printed_json, refusal_message, servo_id};
use identifier_log::recognise::LogOptions;
use serde_json::{Value, json};

/// A result of `run`, with the keys that `tune` reads.
fn result() -> Value {
    let estimate = |value: f64, error: f64| json!({ "value": value, "std_error": error });
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
    })
}

const KNOWN: [&str; 4] = ["--counts", "10000", "--limit", "10"];

fn tune(folder: &Path, result: &Value, arguments: &[&str]) -> Output {
    let path = folder.join("result.json");
    std::fs::write(&path, result.to_string()).expect("the result is written");
    let path = path.display().to_string();
    let mut all = vec!["tune", path.as_str()];
    all.extend(arguments);
    servo_id(&all)
}

fn with(further: &[&'static str]) -> Vec<&'static str> {
    KNOWN.iter().chain(further).copied().collect()
}

/// The stiffest gains for 3 counts of noise, in addition to quantisation, are slower, and the predicted response
/// includes it.
#[test]
fn noise_of_counts_in_a_result_makes_the_gains_slower_and_that_of_rounding_does_not() {
    let folder = folder("tune-noise");
    let resolution = std::f64::consts::TAU / 10_000.0;
    let tuned = |counts: Option<f64>| {
        let mut result = result();
        if let Some(counts) = counts {
            result["noise"] = json!({ "moving": counts * resolution });
        }
        let tuned = printed_json(&tune(
            &folder,
            &result,
            &with(&["--stiffest", "--json", "-"]),
        ));
        let number = |key: &str| {
            tuned
                .pointer(key)
                .and_then(Value::as_f64)
                .expect("a number")
        };
        [number("/bandwidth"), number("/predicted_response/noise")]
    };
    let (silent, rounded, noisy) = (tuned(None), tuned(Some(0.3)), tuned(Some(3.0)));
    assert_eq!(silent.map(f64::to_bits), rounded.map(f64::to_bits));
    assert!(noisy[0] < 0.9 * silent[0], "{silent:?} {noisy:?}");
    // 0.03 of the command that the load leaves, at most.
    assert!(noisy[1] <= 0.3 + 1e-9, "{noisy:?}");
}

#[test]
fn it_prints_a_controller_that_a_scenario_takes() {
    let printed = printed_controller("tune-prints", &["--response-time", "0.04"]);
    assert!(!printed.contains("feed_forward"), "{printed}");
}

/// In less than half of the time with the filter.
#[test]
fn it_prints_a_feed_forward_that_a_scenario_takes() {
    let printed = printed_controller(
        "tune-leads",
        &["--bandwidth", "80", "--step", "0.05", "--feed-forward"],
    );
    assert!(
        printed.contains("feed_forward = { bandwidth = 240.0, acceleration = 0.003880481,"),
        "{printed}"
    );
    let folder = folder("tune-led");
    let [led, filtered] = [&["--feed-forward"][..], &[]].map(|further| {
        let mut arguments = with(&["--bandwidth", "80", "--step", "0.05", "--json", "-"]);
        arguments.extend(further);
        printed_json(&tune(&folder, &result(), &arguments))
    });
    assert_eq!(led["kp"], filtered["kp"]);
    assert_eq!(led["reference_model"]["bandwidth"], json!(240.0));
    assert!(filtered.get("reference_model").is_none());
    let rise = |of: &Value| {
        of["predicted_response"]["rise_time"]
            .as_f64()
            .expect("a number")
    };
    assert!(rise(&led) < 0.4 * rise(&filtered), "{led}");
}

/// Forces that are five standard errors from zero, and no others.
#[test]
fn known_forces_are_in_the_formula() {
    let folder = folder("tune-compensates");
    let path = folder.join("scenario.toml").display().to_string();
    let plant = "[plant]\na = 0.2174\nb = 257.7\ngravity = [300.0, 0.0]\nripple = [-20.0, 0.0]\nripple_order = 7\n\
                 dead_band = 0.2\n[encoder]\ncounts_per_rev = 10000\n[amplifier]\nlimit = 10.0\n\
                 [identifier]\nlaw = \"gauss-newton\"\nripple_order = 7.0\n[run]\nduration = 1.0\n";
    std::fs::write(&path, plant).expect("the scenario is written");
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
    let asked = [
        "--bandwidth",
        "80",
        "--step",
        "0.05",
        "--feed-forward",
        "--scenario",
        &path,
    ];
    let json = printed_json(&tune(
        &folder,
        &result,
        &[&asked[..], &["--json", "-"]].concat(),
    ));
    let led = |key: &str| json["feed_forward"][key].as_f64().expect("a number");
    assert!((led("gravity_sine") + 300.0 / 257.7).abs() < 1e-9);
    assert!((led("ripple_sine") - 20.0 / 257.7).abs() < 1e-9);
    let others = ["gravity_cosine", "ripple_cosine"].map(led);
    assert_eq!(others.map(f64::to_bits), [0; 2]);
    assert_eq!(
        [led("ripple_order"), led("dead_band")].map(f64::to_bits),
        [7.0_f64, 0.2].map(f64::to_bits)
    );
}

/// The controller that is printed for a goal, which a run takes.
fn printed_controller(test: &str, goal: &[&'static str]) -> String {
    let folder = folder(test);
    let output = tune(&folder, &result(), &with(goal));
    assert_done(&output);
    let message = String::from_utf8(output.stdout).expect("text");
    let begin = message.find("[controller]").expect("a controller");
    let end = message[begin..].find("\n\n").expect("its end") + begin;
    let scenario = format!(
        "[plant]\na = 0.2174\nb = 257.7\n{}\n[identifier]\nlaw = \"gauss-newton\"\n[run]\nduration = 1.0\n",
        &message[begin..end]
    );
    let path = folder.join("scenario.toml");
    std::fs::write(&path, scenario).expect("the scenario is written");
    let run = servo_id(&["run", &path.display().to_string()]);
    assert_done(&run);
    message[begin..end].to_owned()
}

#[test]
fn json_has_the_predicted_keys() {
    let folder = folder("tune-json");
    let output = tune(
        &folder,
        &result(),
        &with(&["--bandwidth", "60", "--json", "-"]),
    );
    let document = printed_json(&output);
    let number = |pointer: &str| document.pointer(pointer).and_then(Value::as_f64);
    assert_eq!(number("/bandwidth"), Some(60.0));
    assert!(document["cap"].is_null());
    // b kp = 2 ω (ω + a), with the least friction that the servo may have.
    let kp = number("/kp").expect("a gain");
    let [least, most] = [0.0, 0.2174].map(|a| 2.0 * 60.0 * (60.0 + a));
    assert!((least..most).contains(&(kp * 257.7)), "{kp}");
    let constant = number("/feed_forward/constant").expect("a number");
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
        assert!(
            number(&format!("/predicted_response/{key}")).is_some(),
            "{key}"
        );
    }
}

#[test]
fn encoder_limit_and_delay_come_from_the_scenario() {
    let folder = folder("tune-scenario");
    let scenario = folder.join("scenario.toml");
    let text = "[plant]\na = 0.2174\nb = 257.7\n[encoder]\ncounts_per_rev = 10000\n[amplifier]\n\
                limit = 10.0\ndelay = 0.0005\ncurrent_loop = 0.0002\n[identifier]\nlaw = \"gauss-newton\"\n";
    std::fs::write(&scenario, text).expect("the scenario is written");
    let scenario = scenario.display().to_string();
    let gains = |result: &Value, arguments: &[&str]| -> Value {
        let mut all = arguments.to_vec();
        all.extend(["--json", "-", "--step", "0.02"]);
        let output = tune(&folder, result, &all);
        assert_done(&output);
        serde_json::from_slice(&output.stdout).expect("only JSON")
    };
    // A declared delay is in the identified one, a current loop is not.
    let from_scenario = gains(&result(), &["--scenario", &scenario]);
    let stated = gains(&result(), &with(&["--command-delay", "0.0002"]));
    assert_eq!(from_scenario, stated);
    let mut without = result();
    without["estimates"]["delay"] = Value::Null;
    let from_scenario = gains(&without, &["--scenario", &scenario]);
    let stated = gains(&without, &with(&["--command-delay", "0.0007"]));
    assert_eq!(from_scenario, stated);
}

/// Message of a refusal: exit status 2, nothing on standard output.
fn refusal(test: &str, result: &Value, arguments: &[&str]) -> String {
    refusal_message(&tune(&folder(test), result, arguments))
}

#[test]
fn missing_figures_are_named() {
    for (arguments, part) in [
        ("--limit 10", "--counts"),
        ("--counts 4096", "--limit"),
        // The command that holds the load.
        ("--counts 4096 --limit 0.05", "-0.0776"),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let message = refusal("tune-asked", &result(), &arguments);
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn a_result_that_has_not_converged_is_refused_unless_it_is_accepted() {
    let mut moving = result();
    moving["status"] = json!("moving");
    moving["reason"] = json!("b still moves");
    refusal("tune-moving", &moving, &KNOWN);
    let accepted = tune(
        &folder("tune-accepted"),
        &moving,
        &with(&["--accept-unconverged"]),
    );
    assert_done(&accepted);
}

#[test]
fn a_demand_beyond_the_servo_is_refused_with_the_figure_that_would_do() {
    let message = refusal("tune-fast", &result(), &with(&["--response-time", "0.002"]));
    let would_do = message
        .split("ask for ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next());
    let would_do = would_do.expect("a figure").to_owned();
    let arguments: Vec<&str> = KNOWN
        .iter()
        .copied()
        .chain(["--response-time", &would_do])
        .collect();
    let output = tune(&folder("tune-slower"), &result(), &arguments);
    assert_done(&output);
}

#[test]
fn options_out_of_their_range_are_refused_by_name() {
    for option in [
        "--bandwidth -1",
        "--sample-time 0",
        "--max-sensitivity 1",
        "--max-noise 2",
        "--cutoff 1e6",
        "--command-delay -0.1",
        "--resonance 0",
        "--step 0.001",
        "--step NaN",
    ] {
        let arguments: Vec<&str> = KNOWN.into_iter().chain(option.split(' ')).collect();
        let message = refusal("tune-range", &result(), &arguments);
        let (name, _) = option.split_once(' ').expect("a value");
        assert!(message.contains(&format!("{name} = ")), "{message}");
    }
    for (known, wrong) in [("--counts 10000", "--limit"), ("--limit 10", "--counts")] {
        for value in ["-3", "NaN"] {
            let arguments: Vec<&str> = known.split(' ').chain([wrong, value]).collect();
            let message = refusal("tune-known", &result(), &arguments);
            assert!(message.contains(&format!("{wrong} = {value}")), "{message}");
        }
    }
}

#[test]
fn a_step_that_friction_holds_is_refused() {
    let arguments = with(&["--bandwidth", "3", "--step", "0.01"]);
    let message = refusal("tune-friction", &result(), &arguments);
    assert!(message.contains("--step 0.01: "), "{message}");
}

/// The parameters of a firmware, to be typed in, and the same in the JSON.
#[test]
fn gains_are_stated_in_the_form_of_a_drive() {
    let folder = folder("tune-form");
    let asked = with(&["--for", "odrive"]);
    let output = tune(&folder, &result(), &asked);
    assert_done(&output);
    let page = String::from_utf8(output.stdout).expect("text");
    let form = &printed_json(&tune(
        &folder,
        &result(),
        &[&asked[..], &["--json", "-"]].concat(),
    ))["form"];
    for parameter in form["parameters"].as_array().expect("parameters") {
        let of = |key: &str| parameter[key].as_str().expect("a text");
        let line = format!(
            "{} = {} {}",
            of("name"),
            parameter["value"].as_f64().expect("a number"),
            of("unit")
        );
        assert!(page.contains(line.trim_end()), "{line}: {page}");
    }
    assert_eq!(form["name"], json!("odrive"));
    assert_eq!(form["exactness"], json!("needs ki cut"));
    assert!(form["margins"]["sensitivity"].as_f64().expect("a number") < 1.61);
    assert!(page.contains("needs ki cut"), "{page}");
    assert!(page.contains("assumed to be in Nm"), "{page}");
}

#[test]
fn what_a_form_lacks_is_named() {
    for (arguments, part) in [
        (
            "--for vesc",
            "--for: vesc needs --max-current for its command, a number above 0: for example",
        ),
        ("--for sparkmax --bus-voltage -1", "--bus-voltage 12"),
        ("--for esc", "one of pid, cascade, simplefoc"),
        ("--max-current 60", "--for"),
        (
            "--for odrive --response-time 0.002",
            "--response-time 0.002: ",
        ),
    ] {
        let arguments: Vec<&str> = KNOWN.into_iter().chain(arguments.split(' ')).collect();
        let message = refusal("tune-form-asked", &result(), &arguments);
        assert!(message.contains(part), "{message}");
    }
}

/// The report of a log, the verb tune on its result, and the playground: one function, with the largest command as limit.
#[test]
fn a_report_tune_and_the_playground_have_the_same_gains() {
    let folder = folder("tune-report");
    let log = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../host-sim/logs/simulated-servo.csv.gz")
        .display()
        .to_string();
    let [result, report] =
        ["result.json", "report.html"].map(|name| folder.join(name).display().to_string());
    let outputs = ["--json", &result, "--report", &report];
    assert_done(&servo_id(&[&["identify", &log][..], &outputs].concat()));
    let of_tune = servo_id(&["tune", &result]);
    assert_done(&of_tune);
    let of_tune = String::from_utf8(of_tune.stdout).expect("text");
    let report = std::fs::read_to_string(&report).expect("a report");
    let gains = |text: &str| -> Vec<String> {
        let lines = text
            .lines()
            .map(|line| line.rsplit('>').next().unwrap_or(line).trim());
        let lines = lines.filter(|line| {
            ["kp = ", "kd = ", "ki = "]
                .iter()
                .any(|name| line.starts_with(name))
        });
        lines.map(str::to_owned).collect()
    };
    assert_eq!(gains(&of_tune).len(), 3, "{of_tune}");
    assert_eq!(gains(&report), gains(&of_tune));
    let limit = "the largest command of the log";
    assert!(report.contains(limit), "said beside the gains");
    let text = committed_log().into_bytes();
    let found = playground::log::identify(text, &LogOptions::default()).expect("identified");
    let tuning = found.tuned.expect("gains").tuning;
    let of_tune = printed_json(&servo_id(&["tune", &result, "--json", "-"]));
    for (name, gain) in [("kp", tuning.kp), ("kd", tuning.kd), ("ki", tuning.ki)] {
        assert_eq!(of_tune[name], json!(gain), "{name}");
    }
}
