//! Logs without a scenario: what is taken right, what is named, and what is never taken for converged.

mod mistakes;
mod units;
mod unstated_unit;

use std::f64::consts::TAU;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::support::{
    argument, assert_done, folder, printed, printed_json, refusal_message, servo_id, standard_error,
};

/// A simulated motion under control, 3 s at 1 kHz.
#[derive(Clone)]
struct Motion {
    time: Vec<f64>,
    reference: Vec<f64>,
    position: Vec<f64>,
    command: Vec<f64>,
}

/// Gain of the simulated servo, rad/s² per command unit.
const GAIN: f64 = 200.0;

/// Counts of its encoder.
const COUNTS: f64 = 10_000.0;

impl Motion {
    fn new() -> Self {
        let folder = folder("identify-motion");
        let scenario = folder.join("servo.toml");
        let text = format!(
            "[plant]\na = 8.0\nb = {GAIN:?}\ncoulomb = 3.0\nload = 5.0\n[encoder]\ncounts_per_rev = {COUNTS:?}\n\
             [amplifier]\nlimit = 10.0\n[controller]\nkp = 9.0\nkd = 0.5\nki = 4.0\nsample_time = 0.001\n\
             velocity_filter = {{ kind = \"low-pass\", cutoff = 500.0 }}\n[excitation]\nkind = \"prbs\"\n\
             amplitude = 0.3\nhold = 0.1\norder = 10\n[identifier]\nlaw = \"gauss-newton\"\n\
             parameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n[run]\nduration = 3.0\n"
        );
        std::fs::write(&scenario, text).expect("written");
        Self::of(&scenario)
    }

    /// That of a scenario.
    fn of(scenario: &Path) -> Self {
        let trace = printed(&servo_id(&["run", &argument(scenario), "--csv", "-"]));
        let column = |place: usize| -> Vec<f64> {
            let cells = trace.lines().skip(1).map(|row| row.split(',').nth(place));
            cells
                .map(|cell| cell.and_then(|cell| cell.parse().ok()).expect("a number"))
                .collect()
        };
        Self {
            time: column(0),
            reference: column(1),
            position: column(2),
            command: column(3),
        }
    }

    /// The text of time, position and command.
    fn text(&self) -> String {
        text(
            ",",
            &[
                ("t_s", &cells(&self.time, 4)),
                ("q_rad", &cells(&self.position, 6)),
                ("u_V", &cells(&self.command, 5)),
            ],
        )
    }
}

/// Numbers with so many decimals.
fn cells(numbers: &[f64], decimals: usize) -> Vec<String> {
    numbers
        .iter()
        .map(|number| format!("{number:.decimals$}"))
        .collect()
}

fn text(separator: &str, columns: &[(&str, &[String])]) -> String {
    let names: Vec<_> = columns.iter().map(|(name, _)| *name).collect();
    let mut text = names.join(separator) + "\n";
    for row in 0..columns[0].1.len() {
        let row: Vec<_> = columns
            .iter()
            .map(|(_, cells)| cells[row].as_str())
            .collect();
        text += &(row.join(separator) + "\n");
    }
    text
}

/// A log in a folder of its own.
fn log(test: &str, text: &str) -> String {
    let log = folder(test).join("log.csv");
    std::fs::write(&log, text).expect("written");
    argument(&log)
}

/// A JSON result without the call that made it.
fn without_call(mut result: Value) -> Value {
    for key in ["command", "scenario"] {
        result["origin"][key].take();
    }
    result
}

/// The geared axis has effects that enter one after the other, among candidates that are fitted at once.
#[test]
fn a_fit_is_the_same_for_any_number_of_threads() {
    let axis =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../host-sim/scenarios/geared_axis.toml");
    let axis = std::fs::read_to_string(axis).expect("the scenario is there");
    let scenario = folder("identify-threads").join("servo.toml");
    std::fs::write(&scenario, axis.replace("duration = 20.0", "duration = 5.0")).expect("written");
    let log = log("identify-threads", &Motion::of(&scenario).text());
    let identified = |threads: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_servo-id"))
            .env("RAYON_NUM_THREADS", threads)
            .args(["identify", &log, "--counts-per-rev", "4096", "--json", "-"])
            .output()
            .expect("the program runs");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let one = identified("1");
    let result: Value = serde_json::from_str(&one).expect("JSON");
    let effects = result["fit"]["effects"].as_array().expect("effects");
    assert!(effects.len() > 1, "{one}");
    assert_eq!(one, identified("3"));
}

#[test]
fn a_log_of_a_relay_of_one_size_is_not_converged() {
    let folder = folder("identify-relay");
    let scenario = folder.join("servo.toml");
    let text = format!(
        "[plant]\na = 8.0\nb = {GAIN:?}\ncoulomb = 100.0\nload = 5.0\n[encoder]\ncounts_per_rev = {COUNTS:?}\n\
         [amplifier]\nlimit = 10.0\n[controller]\nkp = 9.0\nkd = 0.5\nki = 4.0\nsample_time = 0.001\n\
         [identifier]\nlaw = \"relay-least-squares\"\n[run]\nduration = 5.0\n"
    );
    std::fs::write(&scenario, text).expect("written");
    let log = log("identify-relay", &Motion::of(&scenario).text());
    let result = printed_json(&servo_id(&["identify", &log, "--json", "-"]));
    assert_eq!(result["code"], 23, "{result}");
}

#[test]
fn the_saved_scenario_gives_the_same_result() {
    let motion = Motion::new();
    let identified = saved_gives_the_same(&motion.text(), &[]);
    assert_eq!(identified["status"], "converged");
    // Other units, a direction, a gap that is bridged and one that is left out.
    let stamp = |t: &f64| format!("06:25:{t:06.3}");
    let stamps: Vec<_> = motion.time.iter().map(stamp).collect();
    let degrees: Vec<_> = motion
        .position
        .iter()
        .map(|q| q.to_degrees().rem_euclid(360.0))
        .collect();
    let percent: Vec<_> = motion.command.iter().map(|u| -10.0 * u).collect();
    let odd = text(
        ";",
        &[
            ("Uhrzeit", &stamps),
            ("Winkel \"q\"", &cells(&degrees, 6)),
            ("duty [%]", &cells(&percent, 4)),
        ],
    );
    let rows = odd.lines().enumerate();
    let kept = rows.filter(|(k, _)| *k != 700 && !(1200..1210).contains(k));
    let odd: String = kept.map(|(_, row)| row.replace('.', ",") + "\n").collect();
    saved_gives_the_same(&odd, &["--command-scale", "-0.1"]);
}

/// The result of a log, asserted to be the same when it is replayed, with the right gain.
fn saved_gives_the_same(text: &str, options: &[&str]) -> Value {
    let log = log("identify-saved", text);
    let scenario = Path::new(&log).with_extension("toml");
    let scenario = argument(&scenario);
    let call = [
        "identify",
        &log,
        "--json",
        "-",
        "--save-scenario",
        &scenario,
    ];
    let identified = printed_json(&servo_id(&[&call, options].concat()));
    let replayed = printed_json(&servo_id(&[
        "identify",
        &log,
        "--scenario",
        &scenario,
        "--json",
        "-",
    ]));
    assert_eq!(without_call(identified.clone()), without_call(replayed));
    let saved = std::fs::read_to_string(&scenario).expect("saved");
    assert_eq!(identified["origin"]["scenario"]["text"], saved.as_str());
    let b = identified["estimates"]["b"]["value"]
        .as_f64()
        .expect("a number");
    assert!((b / GAIN - 1.0).abs() < 0.01, "{b}");
    identified
}

#[test]
fn nothing_is_written_that_was_not_asked_for() {
    let motion = Motion::new();
    let log = log("identify-alone", &motion.text());
    let folder = Path::new(&log).parent().expect("a folder");
    let output = Command::new(env!("CARGO_BIN_EXE_servo-id"))
        .args(["identify", "log.csv"])
        .current_dir(folder)
        .output()
        .expect("it starts");
    assert_done(&output);
    assert_eq!(std::fs::read_dir(folder).expect("a folder").count(), 1);
}

#[test]
fn a_script_may_require_a_converged_result() {
    let motion = Motion::new();
    let log = log("identify-required", &motion.text());
    // The drive was off for a third of the time.
    let mut off = motion;
    off.command[1000..2000].fill(0.0);
    let off = self::log("identify-required-off", &off.text());
    assert_done(&servo_id(&["identify", &log, "--require", "converged"]));
    assert_done(&servo_id(&["identify", &off]));
    let json = Path::new(&off).with_extension("json");
    let output = servo_id(&[
        "identify",
        &off,
        "--require",
        "converged",
        "--json",
        &argument(&json),
    ]);
    assert_eq!(output.status.code(), Some(3));
    assert!(standard_error(&output).contains("--require converged"));
    assert!(json.exists(), "the result is written all the same");
}

#[test]
fn gains_follow_from_the_result_alone() {
    let motion = Motion::new();
    let log = log("identify-tune", &motion.text());
    let json = argument(&Path::new(&log).with_extension("json"));
    assert_done(&servo_id(&["identify", &log, "--json", &json]));
    let tuned = printed_json(&servo_id(&["tune", &json, "--json", "-"]));
    assert!(tuned["kp"].as_f64().is_some_and(|kp| kp > 0.0), "{tuned}");
}

#[test]
fn a_file_that_is_no_log_is_refused_at_once() {
    const AT_ONCE: Duration = Duration::from_secs(5);
    let folder = folder("identify-no-log");
    let large = folder.join("large.csv");
    let file = std::fs::File::create(&large).expect("created");
    file.set_len(1 << 30).expect("sparse");
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).expect("written");
        path
    };
    for path in [
        large,
        folder.clone(),
        folder.join("none.csv"),
        write("empty.csv", b""),
        write("heading.csv", b"t,q,u\n"),
        write("row.csv", b"t,q,u\n0,1,2\n"),
        write("column.csv", b"q\n1\n2\n3\n"),
        write("book.csv", b"PK\x03\x04workbook"),
        write("endless.csv", &vec![b'1'; 1 << 22]),
        write("words.csv", b"once upon a time\nthere was a servo\n"),
    ] {
        let begun = Instant::now();
        let message = refusal_message(&servo_id(&["identify", &argument(&path)]));
        assert!(message.contains(&argument(&path)), "{message}");
        assert!(begun.elapsed() < AT_ONCE, "{}", path.display());
    }
}

#[test]
fn no_question_is_asked_where_there_is_no_terminal() {
    let motion = Motion::new();
    let log = log(
        "identify-questions",
        &text(
            ",",
            &[
                ("q", &cells(&motion.position, 9)),
                ("u", &cells(&motion.command, 5)),
            ],
        ),
    );
    let output = Command::new(env!("CARGO_BIN_EXE_servo-id"))
        .args(["identify", &log])
        .stdin(Stdio::null())
        .output()
        .expect("it starts");
    let message = refusal_message(&output);
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(message.contains("--sample-time is missing"), "{message}");
    let answered = ["identify", &log, "--sample-time", "0.001", "--json", "-"];
    let result = printed_json(&servo_id(&answered));
    assert_eq!(result["status"], "converged");
}

#[cfg(unix)]
#[test]
fn questions_are_asked_at_a_terminal() {
    use crate::support::terminal::Terminal;
    let motion = Motion::new();
    let columns: [(&str, &[String]); 2] = [
        (
            "encoder",
            &cells(
                &motion
                    .position
                    .iter()
                    .map(|q| (q / TAU * COUNTS).round())
                    .collect::<Vec<_>>(),
                0,
            ),
        ),
        ("u", &cells(&motion.command, 5)),
    ];
    let log = log("identify-asked", &text(",", &columns));
    let folder = Path::new(&log).parent().expect("a folder");
    let program = [
        env!("CARGO_BIN_EXE_servo-id"),
        "identify",
        "log.csv",
        "--require",
        "converged",
    ];
    let mut terminal = Terminal::start(&program, folder, 70, 40);
    terminal.answers("no time column", "many");
    terminal.answers("0.05 or 5e-2", "0.001");
    terminal.shows("converged: all estimates");
    let (code, screen) = terminal.ends();
    assert_eq!(code, 0, "{screen}");
    assert!(
        screen.lines().all(|line| line.chars().count() <= 70),
        "{screen}"
    );
}
