//! A unit that nobody stated is no radian, through every door.

use std::f64::consts::TAU;

use serde_json::Value;

use super::{COUNTS, GAIN, MOTION, Motion, log, map, text};
use crate::support::{Folder, estimate, number};

/// A log of some positions, or velocities, with the time and the command of the motion.
fn log_of(test: &str, name: &str, values: &[f64], decimals: usize) -> Folder {
    let columns: [(&str, &[f64], usize); 3] = [
        ("t_s", &MOTION.time, 4),
        (name, values, decimals),
        ("u", &MOTION.command, 5),
    ];
    log(test, &text(&columns))
}

/// Velocities by differences over eight samples, rpm.
fn rpm() -> Vec<f64> {
    let q = &MOTION.position;
    let last = q.len() - 1;
    let at = |k: usize| (q[(k + 4).min(last)] - q[k.saturating_sub(4)]) / 0.008;
    (0..q.len()).map(|k| at(k) * 60.0 / TAU).collect()
}

/// The gain of a result in rad/s².
fn gain(result: &Value) -> f64 {
    let unit = &result["estimates"]["b"]["unit"];
    assert_eq!(*unit, "rad/s² per command unit");
    assert_eq!(result["position_unit"], "rad");
    estimate(result, "b")
}

/// Calls for what is physical.
const PHYSICAL: [&str; 9] = [
    "identify log.csv --torque-constant 0.5",
    "identify log.csv --inertia 0.5",
    "identify log.csv --command-unit Nm",
    "identify log.csv --scenario torque.toml",
    "tune result.json --accept-unconverged",
    "tune result.json --for simplefoc --accept-unconverged",
    "export result.json --format mjcf --ratios --accept-unconverged",
    "export result.json --format json --torque-constant 0.5 --accept-unconverged",
    "export result.json --firmware c --accept-unconverged",
];

#[test]
fn no_door_has_a_physical_unit_that_nobody_stated() {
    let counts = map(&MOTION.position, |q| q * COUNTS / TAU);
    let degrees = map(&MOTION.position, |q| q * 360.0 / TAU);
    let of_counts = log_of("unstated-counts", "q", &counts, 0);
    let of_degrees = log_of("unstated-degrees", "angle", &degrees, 2);
    let of_rpm = log_of("unstated-rpm", "velocity", &rpm(), 3);
    let turns = "--position-unit turns --position-scale 0.016666666666666666";
    for (log, unit, of_b, stated) in [
        (of_counts, "counts", "counts/s²", "--counts-per-rev 10000"),
        (
            of_degrees,
            "own units",
            "own units/s²",
            "--position-unit deg",
        ),
        (of_rpm, "own units·s", "own units/s", turns),
    ] {
        // Table, JSON, trace and report.
        let page = log.done(
            "identify log.csv --json result.json --csv trace.csv --report page.html --save-scenario servo.toml",
        );
        for text in [&page, &log.read("page.html")] {
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
        let names_both =
            |text: &str| text.contains("--counts-per-rev") && text.contains("--position-unit");
        assert!(names_both(&page), "{page}");
        let trace = log.read("trace.csv");
        assert!(!trace.lines().next().expect("a heading").contains("rad"));
        let result = log.read_json("result.json");
        assert_eq!(result["position_unit"], unit);
        assert_eq!(result["logs"][0]["unit"], unit);
        let b = &result["estimates"]["b"];
        assert_eq!(b["unit"], format!("{of_b} per command unit"));
        assert_eq!(result["estimates"]["coulomb"]["unit"], of_b);
        assert!(result.get("physical").is_none() && result.get("voltage_gains").is_none());
        // What is physical is refused, with the option.
        let physical = "\n[physical]\ntorque_constant = 0.5\n";
        log.write("torque.toml", log.read("servo.toml") + physical);
        for call in PHYSICAL {
            let message = log.refused(call);
            assert_eq!(message.matches("error:").count(), 1, "{message}");
            assert!(
                names_both(&message) && message.contains(unit),
                "{call}: {message}"
            );
        }
        // The saved scenario keeps the unit; a statement gives it.
        let again = log.json("identify log.csv --scenario servo.toml");
        assert_eq!(again["estimates"]["b"], *b);
        let found = log.json(&format!("identify log.csv --torque-constant 0.5 {stated}"));
        let gain = gain(&found);
        assert!((gain / GAIN - 1.0).abs() < 0.03, "{unit}: {gain}");
        let inertia = number(&found, "/physical/inertia/value");
        assert!((inertia * gain / 0.5 - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_position_that_begins_again_after_a_power_of_two_states_its_counts() {
    let wrapped = |name: &str, counts: f64, period: f64| {
        let values = map(&MOTION.position, |q| {
            (q * counts / TAU).round().rem_euclid(period)
        });
        log_of("unstated-wrap", name, &values, 0)
    };
    for name in ["q", "encoder_counts"] {
        let log = wrapped(name, 4096.0, 4096.0);
        let page = log.done("identify log.csv --json result.json");
        assert!(page.contains("4096 counts per revolution"));
        let gain = gain(&log.read_json("result.json"));
        assert!((gain / GAIN - 1.0).abs() < 0.02, "{gain}");
    }
    // A register overflows anywhere.
    let result = wrapped("q", COUNTS, 65536.0).json("identify log.csv");
    let unit = &result["estimates"]["b"]["unit"];
    assert_eq!(*unit, "counts/s² per command unit");
    // Another period may be anything.
    let log = wrapped("q", 1000.0, 1000.0);
    let message = log.refused("identify log.csv --quiet");
    let named = message.contains("--counts-per-rev") && message.contains("--wrap");
    assert!(named, "{message}");
    let gain = gain(&log.json("identify log.csv --counts-per-rev 1000"));
    assert!((gain / GAIN - 1.0).abs() < 0.05, "{gain}");
}

/// A goal servo whose loop filters its velocity, and the remedy of who does not state that.
#[test]
fn a_loop_that_is_stated_without_its_filter_is_another_until_the_filter_is_stated() {
    let text = "[plant]\na = 4.0\nb = 25.0\ncoulomb = 20.0\n[encoder]\ncounts_per_rev = 16384\n\
                [amplifier]\nlimit = 12.0\n[controller]\nkp = 36.0\nkd = 1.9\nki = 0.0\nsample_time = 0.001\n\
                velocity_filter = { kind = \"low-pass\", cutoff = 120.0 }\n[excitation]\nkind = \"prbs\"\n\
                amplitude = 1.0\nhold = 0.3\norder = 10\n[identifier]\nlaw = \"fit\"\n[run]\nduration = 10.0\n";
    let motion = Motion::of("unstated-filter-run", text);
    let columns = super::text(&[
        ("time_s", &motion.time, 4),
        ("goal_rad", &motion.reference, 6),
        ("position_rad", &motion.position, 7),
    ]);
    let log = log("unstated-filter", &columns);
    let call = "identify log.csv --goal goal_rad --kp 36 --kd 1.9 --limit 12";
    let without = log.json(call);
    assert_eq!(without["status"], "unexplained");
    assert_eq!(without["code"], 45);
    let with = log.json(&format!("{call} --cutoff 120"));
    assert_eq!(with["status"], "converged", "{}", with["reason"]);
    let b = estimate(&with, "b");
    assert!((b / 25.0 - 1.0).abs() < 0.02, "{b}");
}
