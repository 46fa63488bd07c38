//! Logs from which nothing can be learnt: each is refused with one sentence and its remedy, and none has a result.

use std::fmt::Write;
use std::path::Path;

use crate::support::{folder, refusal_message, servo_id};

const LAWS: [&str; 2] = ["fit", "gauss-newton"];

/// Rows of time, position in counts of 10 000 to a turn, and command of a servo with friction.
fn rows(samples: usize, command: impl Fn(f64) -> f64) -> Vec<[String; 3]> {
    const PARTS: u32 = 4;
    let step = 1e-3 / f64::from(PARTS);
    let [mut position, mut velocity] = [0.0_f64; 2];
    (0..samples)
        .map(|k| {
            let time = k as f64 * 1e-3;
            let command = command(time);
            let count = (position * 10_000.0 / std::f64::consts::TAU).round();
            for _ in 0..PARTS {
                let push = 200.0 * command - 0.5 * velocity;
                let direction = if velocity == 0.0 {
                    push.signum()
                } else {
                    velocity.signum()
                };
                velocity += step * (push - 4.0 * direction);
                position += step * velocity;
            }
            [
                format!("{time:.6}"),
                count.to_string(),
                format!("{command:.6}"),
            ]
        })
        .collect()
}

fn both_ways(samples: usize) -> Vec<[String; 3]> {
    rows(samples, |time| {
        0.5 * (9.0 * time).sin() + 0.3 * (31.0 * time).sin()
    })
}

/// The refusal of a log by a law.
fn refusal(log: &Path, law: &str) -> String {
    let scenario = log.with_extension("toml");
    let text = format!(
        "[encoder]\ncounts_per_rev = 10000\n[identifier]\nlaw = \"{law}\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n[log]\ntime = \"t\"\n\
         position = \"q\"\nposition_unit = \"counts\"\ncommand = \"u\"\n"
    );
    std::fs::write(&scenario, text).expect("written");
    let json = log.with_extension("json");
    let [log, scenario, result] = [log, &scenario, &json].map(|path| path.display().to_string());
    let output = servo_id(&["identify", &log, "--scenario", &scenario, "--json", &result]);
    assert!(!json.exists(), "{law}: a result of {log}");
    refusal_message(&output)
}

#[test]
fn a_log_that_is_none_is_refused_with_the_remedy() {
    let change = |place: usize, column: usize, text: &str| {
        let mut rows = both_ways(6000);
        text.clone_into(&mut rows[place][column]);
        rows
    };
    let later = |offset: f64| {
        let mut rows = both_ways(6000);
        for row in &mut rows[3000..] {
            let time: f64 = row[0].parse().expect("a time");
            row[0] = format!("{:.6}", time + offset);
        }
        rows
    };
    let mut gap = both_ways(6000);
    gap.drain(3000..3400);
    let noise = (0..6000_u64).map(|k| {
        let mix = |by: u64| (k.wrapping_mul(by).wrapping_add(by >> 7) >> 33) % 2000;
        let [q, u] = [
            mix(6_364_136_223_846_793_005),
            mix(2_862_933_555_777_941_757),
        ];
        [
            format!("{:.6}", k as f64 * 1e-3),
            (q / 50).to_string(),
            (u as f64 * 1e-3 - 1.0).to_string(),
        ]
    });
    let one_way = rows(6000, |time| {
        0.2 + 0.15 * (9.0 * time).sin() + 0.05 * (31.0 * time).sin()
    });
    for (name, rows, said, remedy) in [
        ("short", both_ways(60), "60 samples", "100"),
        ("one-way", one_way, "one direction", "turn round"),
        ("noise", noise.collect(), "", "log."),
        (
            "not-a-number",
            change(4000, 1, "nan"),
            ":4002: column q",
            "log.cut",
        ),
        (
            "text",
            change(4000, 2, "error"),
            ":4002: column u",
            "log.cut",
        ),
        ("gap", gap, "400 samples are missing", "log.bridge_gaps"),
        ("ahead", later(100.0), "samples are missing", "log.cut"),
        ("back", later(-2.0), "must advance", "log.sample_time"),
    ] {
        let log = folder(&format!("bad-{name}")).join("log.csv");
        let mut text = String::from("t,q,u\n");
        for [time, position, command] in rows {
            writeln!(text, "{time},{position},{command}").expect("in memory");
        }
        std::fs::write(&log, text).expect("written");
        for law in LAWS {
            let message = refusal(&log, law);
            assert_eq!(message.trim_end().lines().count(), 1, "{law}: {message}");
            assert!(
                message.contains(said) && message.contains(remedy),
                "{law}, {name}: {message}"
            );
        }
    }
}
