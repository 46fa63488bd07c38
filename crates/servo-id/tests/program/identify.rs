//! Logs without a scenario: what is taken right, what is named, and what is never taken for converged.

mod mistakes;
mod units;
mod unstated_unit;

use std::f64::consts::TAU;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::support::{Folder, estimate, folder, printed, standard_error};

/// A simulated motion under control.
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

/// 3 s at 1 kHz.
static MOTION: LazyLock<Motion> = LazyLock::new(|| {
    let text = format!(
        "[plant]\na = 8.0\nb = {GAIN:?}\ncoulomb = 3.0\nload = 5.0\n[encoder]\ncounts_per_rev = {COUNTS:?}\n\
         [amplifier]\nlimit = 10.0\n[controller]\nkp = 9.0\nkd = 0.5\nki = 4.0\nsample_time = 0.001\n\
         velocity_filter = {{ kind = \"low-pass\", cutoff = 500.0 }}\n[excitation]\nkind = \"prbs\"\n\
         amplitude = 0.3\nhold = 0.1\norder = 10\n[identifier]\nlaw = \"gauss-newton\"\n\
         parameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n[run]\nduration = 2.0\n"
    );
    Motion::of("identify-motion", &text)
});

impl Motion {
    /// That of a scenario.
    fn of(test: &str, scenario: &str) -> Self {
        let folder = folder(test);
        folder.write("servo.toml", scenario);
        let trace = folder.done("run servo.toml --csv -");
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
        text(&[
            ("t_s", &self.time, 4),
            ("q_rad", &self.position, 6),
            ("u_V", &self.command, 5),
        ])
    }
}

/// Numbers by a function.
fn map(of: &[f64], by: impl Fn(f64) -> f64) -> Vec<f64> {
    of.iter().map(|x| by(*x)).collect()
}

/// Numbers with so many decimals.
fn cells(numbers: &[f64], decimals: usize) -> Vec<String> {
    let cells = numbers.iter().map(|number| format!("{number:.decimals$}"));
    cells.collect()
}

/// The text of columns of numbers: name, numbers, decimals.
fn text(columns: &[(&str, &[f64], usize)]) -> String {
    let cells = columns
        .iter()
        .map(|(name, numbers, decimals)| (*name, cells(numbers, *decimals)));
    text_of_cells(&cells.collect::<Vec<_>>())
}

fn text_of_cells(columns: &[(&str, Vec<String>)]) -> String {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let rows = (0..columns[0].1.len()).map(|place| {
        let row = columns.iter().map(|(_, cells)| cells[place].as_str());
        row.collect::<Vec<_>>().join(",") + "\n"
    });
    names.join(",") + "\n" + &rows.collect::<String>()
}

/// A folder with a log, `log.csv`.
fn log(test: &str, text: &str) -> Folder {
    let folder = folder(test);
    folder.write("log.csv", text);
    folder
}

/// A JSON result without the call that made it.
fn without_call(mut result: Value) -> Value {
    for key in ["command", "scenario"] {
        result["origin"][key].take();
    }
    // A column that a scenario states has no other evidence.
    result["reading"].take();
    result
}

/// The geared axis has effects that enter one after the other, among candidates that are fitted at once.
#[test]
fn a_fit_is_the_same_for_any_number_of_threads() {
    let axis = include_str!("../../../../host-sim/scenarios/geared_axis.toml");
    let axis = axis.replace("duration = 20.0", "duration = 5.0");
    let log = log(
        "identify-threads",
        &Motion::of("identify-geared", &axis).text(),
    );
    let identified = |threads: &str| {
        let mut call = log.program("identify log.csv --counts-per-rev 4096 --json -");
        printed(
            &call
                .env("RAYON_NUM_THREADS", threads)
                .output()
                .expect("it runs"),
        )
    };
    let one = identified("1");
    let result: Value = serde_json::from_str(&one).expect("JSON");
    let effects = result["fit"]["effects"].as_array().expect("effects");
    assert!(effects.len() > 1, "{one}");
    assert_eq!(one, identified("3"));
}

#[test]
fn the_saved_scenario_gives_the_same_result() {
    let motion = &*MOTION;
    let identified = saved_gives_the_same(&motion.text(), "");
    assert_eq!(identified["status"], "converged");
    // Other units, a direction, a gap that is bridged and one that is left out.
    let stamps = motion.time.iter().map(|t| format!("06:25:{t:06.3}"));
    let degrees = map(&motion.position, |q| q.to_degrees().rem_euclid(360.0));
    let odd = text_of_cells(&[
        ("Uhrzeit", stamps.collect()),
        ("Winkel \"q\"", cells(&degrees, 6)),
        ("duty [%]", cells(&map(&motion.command, |u| -10.0 * u), 4)),
    ]);
    let odd = odd.replace(',', ";").replace('.', ",");
    let rows = odd.lines().enumerate();
    let kept = rows.filter(|(k, _)| *k != 700 && !(1200..1210).contains(k));
    let odd: String = kept.map(|(_, row)| format!("{row}\n")).collect();
    saved_gives_the_same(&odd, "--command-scale -0.1");
}

/// The result of a log, asserted to be the same when it is replayed, with the right gain.
fn saved_gives_the_same(text: &str, options: &str) -> Value {
    let log = log("identify-saved", text);
    let identified = log.json(&format!(
        "identify log.csv --save-scenario log.toml {options}"
    ));
    let replayed = log.json("identify log.csv --scenario log.toml");
    assert_eq!(without_call(identified.clone()), without_call(replayed));
    let saved = log.read("log.toml");
    assert_eq!(identified["origin"]["scenario"]["text"], saved.as_str());
    let b = estimate(&identified, "b");
    assert!((b / GAIN - 1.0).abs() < 0.01, "{b}");
    identified
}

#[test]
fn a_script_may_require_a_converged_result() {
    let log = log("identify-required", &MOTION.text());
    log.done("identify log.csv --require converged");
    // The drive was off for a third of the time.
    let mut off = MOTION.clone();
    off.command[1000..2000].fill(0.0);
    log.write("off.csv", off.text());
    log.done("identify off.csv");
    let output = log.call("identify off.csv --require converged --json off.json");
    assert_eq!(output.status.code(), Some(3));
    assert!(standard_error(&output).contains("--require converged"));
    assert!(log.join("off.json").exists(), "written all the same");
}

#[test]
fn a_file_that_is_no_log_is_refused_at_once() {
    const AT_ONCE: Duration = Duration::from_secs(5);
    let folder = folder("identify-no-log");
    let large = std::fs::File::create(folder.join("large.csv")).expect("created");
    large.set_len(1 << 30).expect("sparse");
    std::fs::create_dir(folder.join("folder")).expect("created");
    let endless = vec![b'1'; 1 << 22];
    let files: [(&str, &[u8]); 8] = [
        ("empty.csv", b""),
        ("heading.csv", b"t,q,u\n"),
        ("row.csv", b"t,q,u\n0,1,2\n"),
        ("rows.csv", b"t_s,q_rad,u\n0,0,1\n0.001,0.1,1\n"),
        ("column.csv", b"q\n1\n2\n3\n"),
        ("book.csv", b"PK\x03\x04workbook"),
        ("endless.csv", &endless),
        ("words.csv", b"once upon a time\nthere was a servo\n"),
    ];
    for (name, bytes) in files {
        folder.write(name, bytes);
    }
    let written = files.map(|(name, _)| name);
    for name in ["large.csv", "folder", "none.csv"]
        .into_iter()
        .chain(written)
    {
        let begun = Instant::now();
        let message = folder.refused(&format!("identify {name}"));
        assert!(message.contains(name), "{message}");
        assert!(begun.elapsed() < AT_ONCE, "{name}");
    }
}

#[test]
fn no_question_is_asked_where_there_is_no_terminal() {
    let columns: [(&str, &[f64], usize); 2] =
        [("q", &MOTION.position, 9), ("u", &MOTION.command, 5)];
    let log = log("identify-questions", &text(&columns));
    let message = log.refused("identify log.csv");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(message.contains("--sample-time is missing"), "{message}");
    let result = log.json("identify log.csv --sample-time 0.001");
    assert_eq!(result["status"], "converged");
}

#[cfg(unix)]
#[test]
fn questions_are_asked_at_a_terminal() {
    use crate::support::terminal::Terminal;
    let counts = map(&MOTION.position, |q| (q / TAU * COUNTS).round());
    let log = log(
        "identify-asked",
        &text(&[("encoder", &counts, 0), ("u", &MOTION.command, 5)]),
    );
    let program = [
        env!("CARGO_BIN_EXE_servo-id"),
        "identify",
        "log.csv",
        "--require",
        "converged",
    ];
    let mut terminal = Terminal::start(&program, &log, 70, 40);
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
