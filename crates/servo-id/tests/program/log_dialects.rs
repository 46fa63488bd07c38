//! Formats of logs: one log in many dialects, units and clocks gives the same estimates.

use std::f64::consts::TAU;

use crate::support::{Folder, committed_log, estimate, number, own_folder, scenario_text, table};
use serde_json::Value;

/// Time, reference, position and command of the committed log, SI.
fn samples() -> Vec<[f64; 4]> {
    let log = committed_log();
    let row = |line: &str| {
        let mut fields = line
            .split(',')
            .map(|field| field.parse().expect("a number"));
        std::array::from_fn(|_| fields.next().expect("four columns"))
    };
    log.lines().skip(1).take(4000).map(row).collect()
}

const PLAIN: &str = "time = \"t\"\nreference = \"r\"\nposition = \"q\"\ncommand = \"u\"";

const REPLAY: &str = "identify log.csv --scenario scenario.toml";

/// A log, and the committed scenario with these columns.
fn files(log: impl AsRef<[u8]>, columns: &str) -> Folder {
    let folder = own_folder();
    let text = scenario_text("replay.toml");
    let (before, _) = text.split_once("[log]").expect("it has columns");
    folder.write("log.csv", log);
    folder.write("scenario.toml", format!("{before}[log]\n{columns}\n"));
    folder
}

fn result(log: &str, columns: &str) -> Value {
    files(log, columns).json(REPLAY)
}

fn refusal(log: impl AsRef<[u8]>, columns: &str) -> String {
    files(log, columns).refused(REPLAY)
}

/// Asserts that a log is refused with a part of the message.
fn assert_refused(log: impl AsRef<[u8]>, columns: &str, part: &str) {
    let answer = refusal(log, columns);
    assert!(answer.contains(part), "{part}: {answer}");
    assert!(answer.len() < 700, "{answer}");
}

/// A log of comma-separated columns t, r, q, u.
fn text(samples: &[[f64; 4]]) -> String {
    let row = |[t, r, q, u]: &[f64; 4]| format!("{t},{r},{q},{u}\n");
    "t,r,q,u\n".to_owned() + &samples.iter().map(row).collect::<String>()
}

/// The samples by the plain heading, each row written by hand.
fn rows(row: impl Fn([f64; 4]) -> String) -> String {
    headed("t,r,q,u", row)
}

/// The same by another heading.
fn headed(heading: &str, row: impl Fn([f64; 4]) -> String) -> String {
    let rows: String = samples()
        .into_iter()
        .map(|sample| row(sample) + "\n")
        .collect();
    format!("{heading}\n{rows}")
}

fn assert_alike(test: &str, found: &Value, wanted: &Value, tolerance: f64) {
    for name in ["a", "b", "coulomb", "load"] {
        let [found, wanted] = [found, wanted].map(|result| estimate(result, name));
        let off = (found - wanted).abs();
        assert!(off <= tolerance * wanted.abs(), "{test}: {found}, {wanted}");
    }
}

/// Logs by name, and the columns that are stated for them.
fn dialects() -> Vec<(&'static str, String, String)> {
    let plain = text(&samples());
    let with = |heading: &str| plain.replace("t,r,q,u\n", heading);
    let comma = |x: f64| x.to_string().replace('.', ",");
    let degrees = |[t, r, q, u]: [f64; 4]| {
        let [r, q] = [r, q].map(f64::to_degrees);
        format!("{t},{r:.9},{q:.9},{u}")
    };
    let turns = |factor: f64| {
        rows(move |[t, r, q, u]| {
            let [r, q] = [r, q].map(|angle| factor * angle / TAU);
            format!("{t},{r:.12},{q:.12},{u}")
        })
    };
    let counts = |[t, r, q, u]: [f64; 4]| format!("{t},{r},{},{u}", (q / TAU * 1e4).round());
    let timed = |factor: f64, from: f64, decimals: usize| {
        rows(move |[t, r, q, u]| format!("{:.decimals$},{r},{q},{u}", factor * t + from))
    };
    let quoted = |sample: [f64; 4]| sample.map(|x| format!("\"{}\"", comma(x))).join(",");
    let unit = |lines: &str| format!("{PLAIN}\n{lines}");
    let by_number = || "time = 1\nreference = 2\nposition = 3\ncommand = 4".to_owned();
    vec![
        ("degrees", rows(degrees), unit("position_unit = \"deg\"")),
        ("turns", turns(1.0), unit("position_unit = \"turns\"")),
        (
            "counts, and a reference in rad",
            rows(counts),
            unit("position_unit = \"counts\"\nreference_unit = \"rad\""),
        ),
        (
            "millimetres, m for rad",
            rows(|[t, r, q, u]| format!("{t},{:.9},{:.9},{u}", 1e3 * r, 1e3 * q)),
            unit("position_unit = \"mm\""),
        ),
        (
            "millimetres of a screw of 5 mm a turn, backwards",
            turns(-5.0),
            unit("position_unit = \"turns\"\nposition_scale = -0.2"),
        ),
        (
            "milliseconds",
            timed(1e3, 0.0, 3),
            unit("time_unit = \"ms\""),
        ),
        (
            "microseconds since long ago",
            timed(1e6, 1.7e15, 0),
            unit("time_unit = \"us\""),
        ),
        (
            "a counter",
            timed(1e3, 0.0, 0),
            unit("time_unit = \"samples\""),
        ),
        (
            "no time",
            headed("r,q,u", |[_, r, q, u]| format!("{r},{q},{u}")),
            PLAIN.replace("time = \"t\"\n", ""),
        ),
        (
            "quoted names and numbers, decimal commas between commas",
            headed("\"time, s\",\"r\",\"q\",\"u\"", quoted),
            PLAIN.replace("\"t\"", "\"time, s\""),
        ),
        ("columns by number without a heading", with(""), by_number()),
        (
            "columns by number below a heading and units",
            with("t,q,q,q\n[s],[rad],[rad],[V]\n"),
            by_number(),
        ),
    ]
}

#[test]
fn every_dialect_and_unit_gives_the_estimates_of_the_plain_log() {
    let plain = result(&text(&samples()), PLAIN);
    for (test, text, columns) in dialects() {
        let found = result(&text, &columns);
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
        // Double precision resolves times since 1970 to a quarter of a microsecond.
        let jitter = number(log, "/jitter_max");
        assert!(jitter < 5e-3, "{test}: {jitter}");
    }
}

#[test]
fn commands_are_scaled_and_turned_round() {
    let plain = result(&text(&samples()), PLAIN);
    let per_cent = rows(|[t, r, q, u]| format!("{t},{r},{q},{:.12}", 10.0 * u));
    let scaled = result(&per_cent, &format!("{PLAIN}\ncommand_scale = 0.1"));
    assert_alike("per cent", &scaled, &plain, 1e-5);
    let turned = rows(|[t, r, q, u]| format!("{t},{r},{q},{}", -u));
    let back = result(&turned, &format!("{PLAIN}\ncommand_scale = -1"));
    assert_eq!(back["estimates"], plain["estimates"]);
    // Without its scale the log contradicts its scenario.
    let found = result(&turned, PLAIN);
    assert_ne!(found["status"], "converged", "{found}");
}

/// An excluded range may have any content: identification continues after it as before.
#[test]
fn excluded_ranges_neither_teach_nor_move_the_model() {
    let plain = result(&text(&samples()), PLAIN);
    let mut broken = samples();
    for sample in &mut broken[2001..=2499] {
        // The encoder's plug is out, and the clock is set back.
        sample[2] = 1e300;
        sample[0] = 2.2;
    }
    let broken = text(&broken);
    let answer = refusal(&broken, PLAIN);
    assert!(answer.contains("log.csv:2003: column q"), "{answer}");
    assert!(answer.contains("log.cut"), "{answer}");
    let cut = format!("{PLAIN}\ncut = [[2.0005, 2.4995]]");
    let found = result(&broken, &cut);
    assert_eq!(found["logs"][0]["left_out_rows"], 499);
    assert_alike("cut", &found, &plain, 0.01);
    assert_eq!(found["agreement"]["holds"], true, "{}", found["agreement"]);
    // A gap is a break like a range that is left out.
    let rows = broken.lines().enumerate();
    let left = rows.filter(|(line, _)| !(2002..=2500).contains(line));
    let gap: String = left.map(|(_, line)| format!("{line}\n")).collect();
    let without = result(&gap, &cut);
    assert_eq!(without["estimates"], found["estimates"]);
    assert_alike("uncut-gap", &result(&gap, PLAIN), &found, 0.01);
}

/// After each of many breaks the model has nearly the servo's velocity: the difference is the delay of the
/// velocity estimate. A model with its velocity from before would be off a hundred times as much.
#[test]
fn the_model_takes_up_the_motion_after_a_break() {
    let plain = result(&text(&samples()), PLAIN);
    let from = (0..10).map(|k| 2.0 + 0.19 * f64::from(k));
    let ranges = from.map(|from| format!("[{from:.4}, {:.4}]", from + 0.0905));
    let ranges = ranges.collect::<Vec<_>>().join(", ");
    let broken = result(&text(&samples()), &format!("{PLAIN}\ncut = [{ranges}]"));
    let rms = |result: &Value| number(result, "/residual/rms");
    assert!(rms(&broken) < 5.0 * rms(&plain), "{broken}\n{plain}");
    assert_alike("joined", &broken, &plain, 0.02);
}

/// Lines behind the columns, and what the answer names.
const WRONG: &str = r#"
position_unit = "degree" | log.position_unit
position_scale = 0.0 | log.position_scale
time_unit = "ms" | log.time_unit
sample_time = 0.002 | log.sample_time
cut = [[1.0, 2.0], [1.5, 3.0]] | [1, 3]
cut = [[2.0, 1.0]] | log.cut
cut = [[-1.0, 100.0]] | log.cut
"#;

#[test]
fn files_that_are_no_logs_are_answered_with_place_and_remedy() {
    let rows = text(&samples());
    for row in table(WRONG) {
        assert_refused(&rows, &format!("{PLAIN}\n{}", row[0]), &row[1]);
    }
    let row = |k: i32| format!("{},0,0.5,1\n", 1e-3 * f64::from(k));
    let constant: String = (0..100).map(row).collect();
    assert_refused(format!("t,r,q,u\n{constant}"), PLAIN, "column q");
    assert_refused("# nothing\n", PLAIN, "log.csv");
    let twice = rows.replace("t,r,q,u", "t,q,q,u");
    let without = |line: &str| PLAIN.replace(line, "");
    assert_refused(&twice, &without("reference = \"r\"\n"), "column q");
    assert_refused(&rows, &PLAIN.replace("\"q\"", "7"), "column 7");
    let cut = without("\ncommand = \"u\"") + "\ncut = [[1.0, 2.0]]";
    assert_refused(&rows, &cut, "log.cut");
}

#[test]
fn a_position_that_begins_again_is_continued_and_the_result_says_so() {
    let plain = result(&text(&samples()), PLAIN);
    assert!(plain["logs"][0]["wrapped"].is_null(), "{plain}");
    let columns = format!("{PLAIN}\nposition_unit = \"deg\"");
    let wrapped = rows(|[t, r, q, u]| {
        let [r, q] = [r, q].map(|angle| angle.to_degrees().rem_euclid(360.0));
        format!("{t},{r:.9},{q:.9},{u}")
    });
    let continued = result(&wrapped, &columns);
    assert_alike("wrapped", &continued, &plain, 1e-4);
    assert_eq!(continued["agreement"]["holds"], true, "{continued}");
    let period = number(&continued, "/logs/0/wrapped");
    assert!((period - TAU).abs() < 1e-9, "{period}");
    let stated = result(&wrapped, &format!("{columns}\nwrap = 360"));
    assert_alike("wrap-stated", &stated, &continued, 1e-12);
    // Stated not to begin again, it jumps.
    let jumping = result(&wrapped, &format!("{columns}\nwrap = 0"));
    assert_ne!(jumping["status"], "converged", "{jumping}");
}
