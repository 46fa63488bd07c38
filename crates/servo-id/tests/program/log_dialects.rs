//! Formats of logs: one log in many dialects, units and clocks gives the same estimates.

use std::fmt::Write as _;
use std::path::PathBuf;

use crate::support::{committed_log, folder, printed_json, refusal_message, servo_id};
use serde_json::Value;

const SCENARIO: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../host-sim/scenarios/replay.toml"
);

/// Time, reference, position and command of the committed log, SI.
fn samples() -> Vec<[f64; 4]> {
    let row = |line: &str| {
        let mut fields = line
            .split(',')
            .map(|field| field.parse().expect("a number"));
        std::array::from_fn(|_| fields.next().expect("four columns"))
    };
    committed_log()
        .lines()
        .skip(1)
        .take(4000)
        .map(row)
        .collect()
}

/// The committed scenario with these columns.
fn scenario(columns: &str) -> String {
    let text = std::fs::read_to_string(SCENARIO).expect("the scenario is committed");
    let (before, _) = text.split_once("[log]").expect("it has columns");
    format!("{before}[log]\n{columns}\n")
}

const PLAIN: &str = "time = \"t\"\nreference = \"r\"\nposition = \"q\"\ncommand = \"u\"";

struct Files {
    log: PathBuf,
    scenario: PathBuf,
}

fn files(test: &str, text: &str, columns: &str) -> Files {
    let folder = folder(&format!("dialect-{test}"));
    let files = Files {
        log: folder.join("log.csv"),
        scenario: folder.join("scenario.toml"),
    };
    std::fs::write(&files.log, text).expect("the log is written");
    std::fs::write(&files.scenario, scenario(columns)).expect("the scenario is written");
    files
}

fn replay(test: &str, text: &str, columns: &str) -> std::process::Output {
    let files = files(test, text, columns);
    let [log, scenario] = [files.log, files.scenario].map(|path| path.display().to_string());
    servo_id(&["identify", &log, "--scenario", &scenario, "--json", "-"])
}

fn result(test: &str, text: &str, columns: &str) -> Value {
    printed_json(&replay(test, text, columns))
}

fn refusal(test: &str, text: &str, columns: &str) -> String {
    refusal_message(&replay(test, text, columns))
}

/// A log of comma-separated columns t, r, q, u.
fn text(samples: &[[f64; 4]]) -> String {
    let mut text = "t,r,q,u\n".to_owned();
    for [t, r, q, u] in samples {
        writeln!(text, "{t},{r},{q},{u}").expect("a string takes it");
    }
    text
}

/// The same rows, each written by hand.
fn rows(heading: &str, row: impl Fn(&[f64; 4]) -> String) -> String {
    let rows: String = samples().iter().map(|sample| row(sample) + "\n").collect();
    format!("{heading}\n{rows}")
}

fn estimates(result: &Value) -> [f64; 4] {
    ["a", "b", "coulomb", "load"].map(|name| {
        result["estimates"][name]["value"]
            .as_f64()
            .expect("a number")
    })
}

fn assert_alike(test: &str, found: &Value, wanted: &Value, tolerance: f64) {
    let [found, wanted] = [found, wanted].map(estimates);
    for (found, wanted) in found.iter().zip(&wanted) {
        let off = (found - wanted).abs();
        assert!(off <= tolerance * wanted.abs(), "{test}: {found}, {wanted}");
    }
}

#[test]
fn every_dialect_and_unit_gives_the_estimates_of_the_plain_log() {
    let plain = result("plain", &text(&samples()), PLAIN);
    let in_deg = |x: f64| x.to_degrees();
    let comma = |x: f64| x.to_string().replace('.', ",");
    let count = |q: f64| (q / std::f64::consts::TAU * 10_000.0).round();
    let unit = |lines: &str| format!("{PLAIN}\n{lines}");
    let all: Vec<(&str, String, String)> = vec![
        (
            "degrees",
            rows("t,r,q,u", |[t, r, q, u]| {
                format!("{t},{:.9},{:.9},{u}", in_deg(*r), in_deg(*q))
            }),
            unit("position_unit = \"deg\""),
        ),
        (
            "turns",
            rows("t,r,q,u", |[t, r, q, u]| {
                format!(
                    "{t},{:.12},{:.12},{u}",
                    in_deg(*r) / 360.0,
                    in_deg(*q) / 360.0
                )
            }),
            unit("position_unit = \"turns\""),
        ),
        (
            "counts, and a reference in rad",
            rows("t,r,q,u", |[t, r, q, u]| {
                format!("{t},{r},{},{u}", count(*q))
            }),
            unit("position_unit = \"counts\"\nreference_unit = \"rad\""),
        ),
        (
            "millimetres, m for rad",
            rows("t,r,q,u", |[t, r, q, u]| {
                format!("{t},{:.9},{:.9},{u}", 1e3 * r, 1e3 * q)
            }),
            unit("position_unit = \"mm\""),
        ),
        (
            "millimetres of a screw of 5 mm a turn, backwards",
            rows("t,r,q,u", |[t, r, q, u]| {
                let mm = |x: &f64| -5.0 * x / std::f64::consts::TAU;
                format!("{t},{:.12},{:.12},{u}", mm(r), mm(q))
            }),
            unit("position_unit = \"turns\"\nposition_scale = -0.2"),
        ),
        (
            "milliseconds",
            rows("t,r,q,u", |[t, r, q, u]| {
                format!("{:.3},{r},{q},{u}", 1e3 * t)
            }),
            unit("time_unit = \"ms\""),
        ),
        (
            "microseconds since long ago",
            rows("t,r,q,u", |[t, r, q, u]| {
                format!("{:.0},{r},{q},{u}", 1e6 * t + 1_700_000_000_000_000.0)
            }),
            unit("time_unit = \"us\""),
        ),
        (
            "a counter",
            rows("t,r,q,u", |[t, r, q, u]| {
                format!("{:.0},{r},{q},{u}", 1e3 * t)
            }),
            unit("time_unit = \"samples\""),
        ),
        (
            "no time",
            rows("r,q,u", |[_, r, q, u]| format!("{r},{q},{u}")),
            PLAIN.replace("time = \"t\"\n", ""),
        ),
        (
            "semicolons and decimal commas",
            rows("t;r;q;u", |sample| sample.map(comma).join(";")),
            PLAIN.to_owned(),
        ),
        (
            "tabs and decimal commas",
            rows("t\tr\tq\tu", |sample| sample.map(comma).join("\t")),
            PLAIN.to_owned(),
        ),
        (
            "quoted names and numbers, decimal commas between commas",
            rows("\"time, s\",\"r\",\"q\",\"u\"", |sample| {
                sample.map(|x| format!("\"{}\"", comma(x))).join(",")
            }),
            PLAIN.replace("\"t\"", "\"time, s\""),
        ),
        (
            "comments and a row of units",
            rows(
                "# drive 7, \"bench\n%\n\nt,r,q,u\ns,rad,rad,V\n// begins",
                |[t, r, q, u]| {
                    format!(
                        "{t},{r},{q},{u}{}",
                        if *t > 0.9995 && *t < 1.0005 {
                            "\n  # half"
                        } else {
                            ""
                        }
                    )
                },
            ),
            PLAIN.to_owned(),
        ),
        (
            "a mark, returns and separators at the end",
            rows("\u{feff}t,r,q,u\r", |[t, r, q, u]| {
                format!("{t},{r},{q},{u},\r")
            }),
            PLAIN.to_owned(),
        ),
        (
            "columns in any order, with others",
            rows("u,note,q,t,r", |[t, r, q, u]| {
                format!("{u},\"a, b\",{q},{t},{r}")
            }),
            PLAIN.to_owned(),
        ),
        (
            "columns by number without a heading",
            text(&samples()).replace("t,r,q,u\n", ""),
            "time = 1\nreference = 2\nposition = 3\ncommand = 4".to_owned(),
        ),
        (
            "columns by number below a heading and units",
            text(&samples()).replace("t,r,q,u\n", "t,q,q,q\n[s],[rad],[rad],[V]\n"),
            "time = 1\nreference = 2\nposition = 3\ncommand = 4".to_owned(),
        ),
    ];
    for (number, (test, text, columns)) in all.iter().enumerate() {
        let found = result(&format!("same-{number}"), text, columns);
        if test.ends_with("backwards") {
            // A position of counts on the other side of zero is the same position.
            assert_alike(test, &found, &plain, 1e-6);
        } else {
            // Standard errors are of double precision, in which nine decimals of a degree show.
            for key in ["value", "tail_std", "at_bound"] {
                for parameter in ["a", "b", "coulomb", "load"] {
                    let of = |result: &Value| result["estimates"][parameter][key].clone();
                    assert_eq!(of(&found), of(&plain), "{test}: {parameter}.{key}");
                }
            }
        }
        assert_eq!(found["samples"], plain["samples"], "{test}");
        assert_eq!(found["agreement"]["holds"], true, "{test}");
        let log = &found["logs"][0];
        let is = |name: &str| test.contains(name);
        assert_eq!(log["decimal_commas"], is("decimal commas"), "{test}");
        let separator = match () {
            () if is("semicolons") => "semicolon",
            () if is("tabs") => "tab",
            () => "comma",
        };
        assert_eq!(log["separator"], separator, "{test}");
        assert_eq!(log["units_row"].is_string(), is("units"), "{test}");
        // Double precision resolves times since 1970 to a quarter of a microsecond.
        let jitter = log["jitter_max"].as_f64().expect("a number");
        assert!(jitter < 5e-3, "{test}: {jitter}");
    }
}

#[test]
fn commands_are_scaled_and_turned_round() {
    let plain = result("command", &text(&samples()), PLAIN);
    let per_cent = rows("t,r,q,u", |[t, r, q, u]| {
        format!("{t},{r},{q},{:.12}", 10.0 * u)
    });
    let scaled = result(
        "per-cent",
        &per_cent,
        &format!("{PLAIN}\ncommand_scale = 0.1"),
    );
    assert_alike("per cent", &scaled, &plain, 1e-5);
    let turned = rows("t,r,q,u", |[t, r, q, u]| format!("{t},{r},{q},{}", -u));
    let back = result("turned", &turned, &format!("{PLAIN}\ncommand_scale = -1"));
    assert_eq!(back["estimates"], plain["estimates"]);
}

/// A number from −1 to 1, of no order.
fn noise(k: usize) -> f64 {
    let mixed = ((k as u64) ^ ((k as u64) >> 5)).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11;
    (mixed as f64) / (1_u64 << 52) as f64 - 1.0
}

#[test]
fn time_stamps_that_jitter_count_as_even_and_are_reported() {
    let plain = result("even", &text(&samples()), PLAIN);
    let mut jittering = samples();
    for (k, sample) in jittering.iter_mut().enumerate() {
        sample[0] += 1e-4 * noise(k);
    }
    let found = result("jitter", &text(&jittering), PLAIN);
    assert_eq!(found["estimates"], plain["estimates"]);
    let rms = found["logs"][0]["jitter_rms"].as_f64().expect("a number");
    assert!((rms / (0.1 / 3_f64.sqrt()) - 1.0).abs() < 0.1, "{rms}");
    // Stamps of a millisecond on samples of 1.25 ms, without a declared sample time.
    let coarse = rows("t,q,u", |[t, _, q, u]| {
        format!("{:.0},{q},{u}", (1.25e3 * t).floor())
    });
    let alone = "time = \"t\"\ntime_unit = \"ms\"\nposition = \"q\"\ncommand = \"u\"";
    let files = files("coarse", &coarse, alone);
    let bare = std::fs::read_to_string(&files.scenario).expect("written");
    let (before, after) = bare.split_once("[amplifier]").expect("an amplifier");
    let (_, identifier) = after.split_once("[identifier]").expect("an identifier");
    std::fs::write(&files.scenario, format!("{before}[identifier]{identifier}")).expect("written");
    let [log, scenario] = [files.log, files.scenario].map(|path| path.display().to_string());
    let found = printed_json(&servo_id(&[
        "identify",
        &log,
        "--scenario",
        &scenario,
        "--json",
        "-",
    ]));
    let time = found["sample_time"].as_f64().expect("a number");
    assert!((time * 800.0 - 1.0).abs() < 1e-3, "{found}");
    let rms = found["logs"][0]["jitter_rms"].as_f64().expect("a number");
    // Cut by 0, 0.2, 0.4 and 0.6 of a sample.
    assert!((0.22..0.23).contains(&rms), "{found}");
}

/// An excluded range may have any content: identification continues after it as before.
#[test]
fn excluded_ranges_neither_teach_nor_move_the_model() {
    let plain = result("whole", &text(&samples()), PLAIN);
    let mut broken = samples();
    for sample in &mut broken[2001..=2499] {
        // The encoder's plug is out, and the clock is set back.
        sample[2] = 1e300;
        sample[0] = 2.2;
    }
    let broken = text(&broken);
    let answer = refusal("uncut", &broken, PLAIN);
    assert!(answer.contains("log.csv:2003: column q"), "{answer}");
    assert!(answer.contains("log.cut"), "{answer}");
    let found = result(
        "cut",
        &broken,
        &format!("{PLAIN}\ncut = [[2.0005, 2.4995]]"),
    );
    assert_eq!(found["logs"][0]["left_out_rows"], 499);
    assert_alike("cut", &found, &plain, 0.01);
    assert_eq!(found["agreement"]["holds"], true, "{}", found["agreement"]);
    // A gap is a break like a range that is left out.
    let gap: String = broken
        .lines()
        .enumerate()
        .filter(|(line, _)| !(2002..=2500).contains(line))
        .map(|(_, line)| format!("{line}\n"))
        .collect();
    let without = result("gap", &gap, &format!("{PLAIN}\ncut = [[2.0005, 2.4995]]"));
    assert_eq!(without["estimates"], found["estimates"]);
    let uncut = result("uncut-gap", &gap, PLAIN);
    assert_alike("uncut-gap", &uncut, &found, 0.01);
}

/// After each of many breaks the model has nearly the servo's velocity: the difference is the delay of the
/// velocity estimate. A model with its velocity from before would be off a hundred times as much.
#[test]
fn the_model_takes_up_the_motion_after_a_break() {
    let plain = result("unbroken", &text(&samples()), PLAIN);
    let ranges: Vec<String> = (0..10)
        .map(|k| 2.0 + 0.19 * f64::from(k))
        .map(|from| format!("[{from:.4}, {:.4}]", from + 0.0905))
        .collect();
    let cut = format!("{PLAIN}\ncut = [{}]", ranges.join(", "));
    let broken = result("joined", &text(&samples()), &cut);
    let rms = |result: &Value| result["residual"]["rms"].as_f64().expect("a number");
    assert!(rms(&broken) < 5.0 * rms(&plain), "{broken}\n{plain}");
    assert_alike("joined", &broken, &plain, 0.02);
}

#[test]
fn files_that_are_no_logs_are_answered_with_place_and_remedy() {
    let rows = text(&samples());
    let with = |line: usize, row: &str| -> String {
        let lines = rows.lines().enumerate();
        lines
            .map(|(k, old)| format!("{}\n", if k + 1 == line { row } else { old }))
            .collect()
    };
    let refused = |text: &str, columns: &str, part: &str| {
        let answer = refusal("none", text, columns);
        assert!(answer.contains(part), "{part}: {answer}");
        assert!(answer.len() < 700, "{answer}");
    };
    for row in [
        "50 | 0.048,0,1e308,0 | :50: column q: ",
        "2 | fast,0,0,0 | :2: column t: ",
    ] {
        let [line, text, place] =
            <[&str; 3]>::try_from(row.split(" | ").collect::<Vec<_>>()).expect("three cells");
        refused(&with(line.parse().expect("a line"), text), PLAIN, place);
    }
    for (line, part) in [
        ("position_unit = \"degree\"", "log.position_unit"),
        ("position_scale = 0.0", "log.position_scale"),
        ("time_unit = \"ms\"", "log.time_unit"),
        ("sample_time = 0.002", "log.sample_time"),
        ("cut = [[1.0, 2.0], [1.5, 3.0]]", "[1, 3]"),
        ("cut = [[2.0, 1.0]]", "log.cut"),
        ("cut = [[-1.0, 100.0]]", "log.cut"),
    ] {
        refused(&rows, &format!("{PLAIN}\n{line}"), part);
    }
    let row = |k: i32| format!("{},0,0.5,1\n", 1e-3 * f64::from(k));
    let constant: String = (0..100).map(row).collect();
    refused(&format!("t,r,q,u\n{constant}"), PLAIN, "column q");
    for none in [
        "t,r,q,u\n0,0,0,0\n0.001,0,1,0\n",
        "t,r,q,u\n",
        "",
        "# nothing\n",
    ] {
        refused(none, PLAIN, "log.csv");
    }
    let twice = rows.replace("t,r,q,u", "t,q,q,u");
    let without = |line: &str| PLAIN.replace(line, "");
    refused(&twice, &without("reference = \"r\"\n"), "column q");
    refused(&rows, &PLAIN.replace("\"q\"", "7"), "column 7");
    let cut = without("\ncommand = \"u\"") + "\ncut = [[1.0, 2.0]]";
    refused(&rows, &cut, "log.cut");
    let utf16: Vec<u8> = rows.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let files = files("utf-16", "", PLAIN);
    std::fs::write(&files.log, [vec![0xff, 0xfe], utf16].concat()).expect("written");
    let [log, scenario] = [files.log, files.scenario].map(|path| path.display().to_string());
    let answer = refusal_message(&servo_id(&["identify", &log, "--scenario", &scenario]));
    assert!(answer.contains("UTF-8"), "{answer}");
}

#[test]
fn a_position_that_begins_again_is_continued_and_the_result_says_so() {
    let plain = result("unwrapped", &text(&samples()), PLAIN);
    assert!(plain["logs"][0]["wrapped"].is_null(), "{plain}");
    let columns = format!("{PLAIN}\nposition_unit = \"deg\"");
    let wrapped = rows("t,r,q,u", |[t, r, q, u]| {
        let [r, q] = [r, q].map(|angle| angle.to_degrees().rem_euclid(360.0));
        format!("{t},{r:.9},{q:.9},{u}")
    });
    let continued = result("wrapped", &wrapped, &columns);
    assert_alike("wrapped", &continued, &plain, 1e-4);
    assert_eq!(continued["agreement"]["holds"], true, "{continued}");
    let period = continued["logs"][0]["wrapped"].as_f64().expect("a period");
    assert!((period - std::f64::consts::TAU).abs() < 1e-9, "{period}");
    let stated = result("wrap-stated", &wrapped, &format!("{columns}\nwrap = 360"));
    assert_alike("wrap-stated", &stated, &continued, 1e-12);
    // Stated not to begin again, it jumps.
    let jumping = result("wrap-none", &wrapped, &format!("{columns}\nwrap = 0"));
    assert_ne!(jumping["status"], "converged", "{jumping}");
}

#[test]
fn a_log_that_contradicts_its_scenario_is_not_converged() {
    let reversed = rows("t,r,q,u", |[t, r, q, u]| format!("{t},{r},{q},{}", -u));
    let found = result("reversed", &reversed, PLAIN);
    assert_ne!(found["status"], "converged", "{found}");
}
