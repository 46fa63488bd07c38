//! A unit that nobody stated is no radian, through every door.

use std::f64::consts::TAU;
use std::path::Path;

use serde_json::Value;

use super::{COUNTS, GAIN, Motion, cells, log, text};
use crate::support::{argument, folder, printed, printed_json, servo_id, standard_error};

/// The sentence with which a call is refused.
fn refusal(call: &[&str]) -> String {
    let output = servo_id(call);
    assert_eq!(output.status.code(), Some(2), "{call:?}");
    let message = standard_error(&output);
    assert_eq!(message.matches("error:").count(), 1, "{message}");
    message
}

/// A log of some positions, or velocities, with the time and the command of a motion.
fn log_of(test: &str, motion: &Motion, name: &str, values: &[f64], decimals: usize) -> String {
    let columns = [
        ("t_s", cells(&motion.time, 4)),
        (name, cells(values, decimals)),
        ("u", cells(&motion.command, 5)),
    ];
    let columns = columns.each_ref().map(|(name, cells)| (*name, &cells[..]));
    log(test, &text(",", &columns))
}

fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|value| value * factor).collect()
}

/// Velocities by differences over eight samples, rpm.
fn rpm(motion: &Motion) -> Vec<f64> {
    let q = &motion.position;
    let last = q.len() - 1;
    let at = |k: usize| (q[(k + 4).min(last)] - q[k.saturating_sub(4)]) / 0.008;
    (0..q.len()).map(|k| at(k) * 60.0 / TAU).collect()
}

/// The gain of a result in rad/s².
fn gain(result: &Value) -> f64 {
    let b = &result["estimates"]["b"];
    assert_eq!(b["unit"], "rad/s² per command unit");
    assert_eq!(result["position_unit"], "rad");
    b["value"].as_f64().expect("a number")
}

#[test]
fn no_door_has_a_physical_unit_that_nobody_stated() {
    let motion = Motion::new();
    let counts = scaled(&motion.position, COUNTS / TAU);
    let degrees = scaled(&motion.position, 360.0 / TAU);
    let of_counts = log_of("unstated-counts", &motion, "q", &counts, 0);
    let of_degrees = log_of("unstated-degrees", &motion, "angle", &degrees, 2);
    let of_rpm = log_of("unstated-rpm", &motion, "velocity", &rpm(&motion), 3);
    for (log, unit, of_b, stated) in [
        (&of_counts, "counts", "counts/s²", "--counts-per-rev 10000"),
        (
            &of_degrees,
            "own units",
            "own units/s²",
            "--position-unit deg",
        ),
        (
            &of_rpm,
            "own units·s",
            "own units/s",
            "--position-unit turns --position-scale 0.016666666666666666",
        ),
    ] {
        let folder = folder(&format!("unstated-out-{}", unit.replace(' ', "-")));
        let file = |name: &str| argument(&folder.join(name));
        let [json, csv, html, scenario] =
            ["result.json", "trace.csv", "page.html", "servo.toml"].map(file);
        // Table, JSON, trace and report.
        let outputs = [
            "--json",
            &json,
            "--csv",
            &csv,
            "--report",
            &html,
            "--save-scenario",
            &scenario,
        ];
        let page = printed(&servo_id(&[&["identify", log], &outputs[..]].concat()));
        let report = std::fs::read_to_string(&html).expect("a report");
        for text in [&page, &report] {
            assert!(text.contains(&format!("{of_b} per command unit")), "{text}");
            for physical in [
                "rad/s²",
                "rad rms",
                "[rad]",
                "kg·m²",
                "command units per rad",
            ] {
                assert!(!text.contains(physical), "{unit}: {physical}");
            }
        }
        assert!(
            page.contains("--counts-per-rev") && page.contains("--position-unit"),
            "{page}"
        );
        let heading = std::fs::read_to_string(&csv).expect("a trace");
        assert!(!heading.lines().next().expect("a heading").contains("rad"));
        let result: Value =
            serde_json::from_str(&std::fs::read_to_string(&json).expect("a file")).expect("JSON");
        assert_eq!(result["position_unit"], unit);
        assert_eq!(result["logs"][0]["unit"], unit);
        assert_eq!(
            result["estimates"]["b"]["unit"],
            format!("{of_b} per command unit")
        );
        assert_eq!(result["estimates"]["coulomb"]["unit"], of_b);
        assert!(result.get("physical").is_none() && result.get("voltage_gains").is_none());
        // What is physical is refused, with the option.
        let with_torque = file("torque.toml");
        let text = std::fs::read_to_string(&scenario).expect("saved");
        std::fs::write(&with_torque, text + "\n[physical]\ntorque_constant = 0.5\n")
            .expect("written");
        for call in [
            &["identify", log, "--torque-constant", "0.5"][..],
            &["identify", log, "--inertia", "0.5"],
            &["identify", log, "--command-unit", "Nm"],
            &["identify", log, "--scenario", &with_torque],
            &["tune", &json, "--accept-unconverged"],
            &["tune", &json, "--for", "simplefoc", "--accept-unconverged"],
            &[
                "export",
                &json,
                "--format",
                "mjcf",
                "--ratios",
                "--accept-unconverged",
            ],
            &[
                "export",
                &json,
                "--format",
                "json",
                "--torque-constant",
                "0.5",
                "--accept-unconverged",
            ],
            &["export", &json, "--firmware", "c", "--accept-unconverged"],
        ] {
            let message = refusal(call);
            let named = message.contains("--counts-per-rev") && message.contains("--position-unit");
            assert!(named && message.contains(unit), "{call:?}: {message}");
        }
        // The saved scenario keeps the unit; a statement gives it.
        let again = ["identify", log, "--scenario", &scenario, "--json", "-"];
        let again = printed_json(&servo_id(&again));
        assert_eq!(again["estimates"]["b"], result["estimates"]["b"]);
        let call = ["identify", log, "--torque-constant", "0.5", "--json", "-"];
        let call: Vec<_> = call.into_iter().chain(stated.split(' ')).collect();
        let found = printed_json(&servo_id(&call));
        assert!(
            (gain(&found) / GAIN - 1.0).abs() < 0.03,
            "{unit}: {}",
            gain(&found)
        );
        let inertia = found["physical"]["inertia"]["value"]
            .as_f64()
            .expect("a number");
        assert!((inertia * gain(&found) / 0.5 - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_unit_in_the_heading_is_stated() {
    let motion = Motion::new();
    let q = &motion.position;
    for (name, values, unit) in [
        ("angle_deg", scaled(q, 360.0 / TAU), "rad"),
        ("q [turns]", scaled(q, 1.0 / TAU), "rad"),
        ("speed (rpm)", rpm(&motion), "rad"),
        ("velocity [m/s]", scaled(&rpm(&motion), TAU / 60.0), "m"),
        ("x_mm", scaled(q, 1e3), "m"),
    ] {
        let log = log_of("unstated-heading", &motion, name, &values, 6);
        for sign in ["1", "-1"] {
            let call = ["identify", &log, "--position-scale", sign, "--json", "-"];
            let result = printed_json(&servo_id(&call));
            assert_eq!(result["position_unit"], unit, "{name}");
            let b = &result["estimates"]["b"];
            assert_eq!(b["unit"], format!("{unit}/s² per command unit"), "{name}");
            let off = b["value"].as_f64().expect("a number") / GAIN - 1.0;
            assert!(off.abs() < 0.03, "{name} {sign}: {off}");
        }
    }
}

#[test]
fn a_position_that_begins_again_after_a_power_of_two_states_its_counts() {
    let motion = Motion::new();
    let wrapped = |test: &str, name: &str, counts: f64, period: f64| {
        let values = motion.position.iter();
        let values = values.map(|q| (q * counts / TAU).round().rem_euclid(period));
        log_of(test, &motion, name, &values.collect::<Vec<_>>(), 0)
    };
    for name in ["q", "encoder_counts"] {
        let log = wrapped("unstated-wrap", name, 4096.0, 4096.0);
        let output = servo_id(&["identify", &log]);
        assert!(printed(&output).contains("4096 counts per revolution"));
        let result = printed_json(&servo_id(&["identify", &log, "--json", "-"]));
        assert!(
            (gain(&result) / GAIN - 1.0).abs() < 0.02,
            "{}",
            gain(&result)
        );
    }
    // A register overflows anywhere.
    let log = wrapped("unstated-wrap-register", "q", COUNTS, 65536.0);
    let result = printed_json(&servo_id(&["identify", &log, "--json", "-"]));
    assert_eq!(
        result["estimates"]["b"]["unit"],
        "counts/s² per command unit"
    );
    // Another period may be anything.
    let log = wrapped("unstated-wrap-1000", "q", 1000.0, 1000.0);
    let message = refusal(&["identify", &log]);
    assert!(
        message.contains("--counts-per-rev") && message.contains("--wrap"),
        "{message}"
    );
    let call = ["identify", &log, "--counts-per-rev", "1000", "--json", "-"];
    let result = printed_json(&servo_id(&call));
    assert!(
        (gain(&result) / GAIN - 1.0).abs() < 0.05,
        "{}",
        gain(&result)
    );
}

#[test]
fn a_log_of_two_rows_is_one_sentence() {
    let log = log("unstated-rows", "t_s,q_rad,u\n0,0,1\n0.001,0.1,1\n");
    let message = refusal(&["identify", &log]);
    assert!(message.contains("2 rows"), "{message}");
}

/// Goals in steps at the rates of robot-learning data sets.
#[test]
fn stated_goals_at_a_low_rate_are_identified() {
    let scenario = folder("unstated-goals-run").join("servo.toml");
    let text = "[plant]\na = 2.0\nb = 500.0\ncoulomb = 20.0\n[encoder]\ncounts_per_rev = 4096\n\
                [amplifier]\nlimit = 1.5\n[controller]\nkp = 6.0\nkd = 0.15\nki = 0.0\nsample_time = 0.001\n\
                velocity_filter = { kind = \"difference\" }\n[excitation]\nkind = \"prbs\"\namplitude = 0.4\n\
                hold = 0.3\norder = 10\n[identifier]\nlaw = \"fit\"\n[run]\nduration = 20.0\n";
    std::fs::write(&scenario, text).expect("written");
    let motion = Motion::of(Path::new(&scenario));
    for rows in [10, 20, 33] {
        let of = |values: &[f64], factor: f64, decimals| {
            let few: Vec<f64> = values
                .iter()
                .step_by(rows)
                .map(|value| value * factor)
                .collect();
            cells(&few, decimals)
        };
        let degree = 360.0 / TAU;
        let columns = [
            ("time", of(&motion.time, 1.0, 4)),
            ("goal_deg", of(&motion.reference, degree, 4)),
            ("position_deg", of(&motion.position, degree, 4)),
        ];
        let columns = columns.each_ref().map(|(name, cells)| (*name, &cells[..]));
        let log = log(
            &format!("unstated-goals-{rows}"),
            &super::text(",", &columns),
        );
        let stated = "--position position_deg --goal goal_deg --kp 6 --kd 0.15 --limit 1.5 --loop-time 0.001 --json -";
        let call: Vec<_> = ["identify", &log]
            .into_iter()
            .chain(stated.split(' '))
            .collect();
        let result = printed_json(&servo_id(&call));
        // At 33 ms the delay is longer than the fit tests, which is an answer.
        let b = &result["estimates"]["b"];
        let (value, error) = (b["value"].as_f64(), b["std_error"].as_f64());
        let off = value
            .zip(error)
            .map(|(value, error)| (value - 500.0).abs() / error);
        assert!(
            rows == 33 || off.is_some_and(|off| off < 3.0),
            "{rows}: {b}"
        );
        assert!(
            rows > 10 || result["status"] == "converged",
            "{}",
            result["reason"]
        );
    }
}

/// A goal servo whose loop filters its velocity, and the remedy of who does not state that.
#[test]
fn a_loop_that_is_stated_without_its_filter_is_another_until_the_filter_is_stated() {
    let scenario = folder("unstated-filter-run").join("servo.toml");
    let text = "[plant]\na = 4.0\nb = 25.0\ncoulomb = 20.0\n[encoder]\ncounts_per_rev = 16384\n\
                [amplifier]\nlimit = 12.0\n[controller]\nkp = 36.0\nkd = 1.9\nki = 0.0\nsample_time = 0.001\n\
                velocity_filter = { kind = \"low-pass\", cutoff = 120.0 }\n[excitation]\nkind = \"prbs\"\n\
                amplitude = 1.0\nhold = 0.3\norder = 10\n[identifier]\nlaw = \"fit\"\n[run]\nduration = 10.0\n";
    std::fs::write(&scenario, text).expect("written");
    let motion = Motion::of(Path::new(&scenario));
    let columns = [
        ("time_s", cells(&motion.time, 4)),
        ("goal_rad", cells(&motion.reference, 6)),
        ("position_rad", cells(&motion.position, 7)),
    ];
    let columns = columns.each_ref().map(|(name, cells)| (*name, &cells[..]));
    let log = log("unstated-filter", &super::text(",", &columns));
    let stated = [
        "--goal", "goal_rad", "--kp", "36", "--kd", "1.9", "--limit", "12",
    ];
    let call = |further: &[&str]| {
        let call = [&["identify", &log, "--json", "-"], &stated[..], further].concat();
        printed_json(&servo_id(&call))
    };
    let without = call(&[]);
    assert_eq!(
        (&without["status"], &without["code"]),
        (&"unexplained".into(), &45.into())
    );
    let with = call(&["--cutoff", "120"]);
    assert_eq!(with["status"], "converged", "{}", with["reason"]);
    let b = with["estimates"]["b"]["value"].as_f64().expect("a number");
    assert!((b / 25.0 - 1.0).abs() < 0.02, "{b}");
}
