//! A list of the mistakes that logs have, each made in the log of a simulated servo.

mod broken_cells;
mod columns;
mod dialects;
mod times;
mod units;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;

use super::{Motion, cells};
use crate::support::{folder, servo_id, standard_error};

/// A log with a mistake or a peculiarity.
struct Case {
    name: &'static str,
    bytes: Vec<u8>,
    options: &'static [&'static str],
    expected: Expected,
}

/// The right answer.
enum Expected {
    /// This gain, to 5 %.
    Gain(f64),
    /// A sentence with these words.
    Named(&'static str),
}

use Expected::{Gain, Named};

/// The answer to a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Answer {
    Right,
    Named,
    /// Neither, and not called converged.
    Unclear,
    /// Called converged with a wrong gain.
    Wrong,
}

impl Case {
    /// Identifies it: the answer, and the sentence that was printed or the gain.
    fn identify(&self, folder: &Path) -> (Answer, String) {
        let log = folder.join("log.csv");
        std::fs::write(&log, &self.bytes).expect("written");
        let log = log.display().to_string();
        let arguments = [&["identify", &log, "--json", "-"], self.options].concat();
        let output = servo_id(&arguments);
        if output.status.code() != Some(0) {
            let message = standard_error(&output).replace(&format!("{}/", folder.display()), "");
            let message = message.trim_start_matches("error: ").trim().to_owned();
            let is_named = matches!(self.expected, Named(words) if message.contains(words));
            let answer = if is_named {
                Answer::Named
            } else {
                Answer::Unclear
            };
            return (answer, message);
        }
        let result: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let text = |key: &str| result[key].as_str().unwrap_or_default().to_owned();
        let gain = result["estimates"]["b"]["value"]
            .as_f64()
            .unwrap_or(f64::NAN);
        let is_right = matches!(self.expected, Gain(right) if (gain / right - 1.0).abs() < 0.05);
        let sentence = format!("{}: {}", text("status"), text("reason"));
        let is_named = matches!(self.expected, Named(words) if sentence.contains(words));
        let answer = match (text("status") == "converged", is_right) {
            (true, true) => Answer::Right,
            (true, false) => Answer::Wrong,
            _ if is_named => Answer::Named,
            _ => Answer::Unclear,
        };
        let shown = match answer {
            Answer::Right => format!("b = {gain:.0}"),
            Answer::Wrong => format!("b = {gain:.1}; {sentence}"),
            _ => sentence,
        };
        (answer, shown)
    }
}

/// Numbers from −1 to 1 in no order.
fn noise(k: usize) -> f64 {
    let k = k as u64 + 1;
    let mixed = (k ^ (k >> 7)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11;
    (mixed as f64) / (1_u64 << 52) as f64 - 1.0
}

fn map(of: &[f64], by: impl Fn(f64) -> f64) -> Vec<f64> {
    of.iter().map(|x| by(*x)).collect()
}

fn utf16(text: &str) -> Vec<u8> {
    let units = std::iter::once(0xfeff).chain(text.encode_utf16());
    units.flat_map(u16::to_le_bytes).collect()
}

/// A text with some lines changed; the heading is line 0.
fn lines(text: &str, change: impl Fn(usize, &str) -> Option<String>) -> String {
    let lines = text.lines().enumerate();
    lines
        .filter_map(|(k, line)| Some(change(k, line)? + "\n"))
        .collect()
}

/// A cell of the row 1500 replaced.
fn with_cell(text: &str, place: usize, cell: &str) -> String {
    lines(text, |k, line| {
        let mut cells: Vec<_> = line.split(',').collect();
        if k == 1500 {
            cells[place] = cell;
        }
        Some(cells.join(","))
    })
}

struct Cases {
    motion: Motion,
    all: Vec<Case>,
}

impl Cases {
    fn add(&mut self, name: &'static str, text: impl Into<Vec<u8>>, expected: Expected) {
        self.with(name, text, &[], expected);
    }

    fn with(
        &mut self,
        name: &'static str,
        text: impl Into<Vec<u8>>,
        options: &'static [&'static str],
        expected: Expected,
    ) {
        self.all.push(Case {
            name,
            bytes: text.into(),
            options,
            expected,
        });
    }

    /// Time, position and command as cells.
    fn usual(&self) -> [Vec<String>; 3] {
        let of = &self.motion;
        [
            cells(&of.time, 4),
            cells(&of.position, 6),
            cells(&of.command, 5),
        ]
    }
}

#[test]
fn mistakes_are_named_or_taken_right_and_never_converge() {
    /// Threads that identify.
    const THREADS: usize = 2;
    let mut cases = Cases {
        motion: Motion::new(),
        all: Vec::new(),
    };
    cases.dialects();
    cases.times();
    cases.units();
    cases.signs_and_columns();
    cases.broken_cells();
    let all = &cases.all;
    let identified: BTreeMap<usize, (Answer, String)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS)
            .map(|thread| {
                let folder = folder(&format!("identify-mistakes-{thread}"));
                scope.spawn(move || {
                    let own = (thread..all.len()).step_by(THREADS);
                    own.map(|k| (k, all[k].identify(&folder)))
                        .collect::<Vec<_>>()
                })
            })
            .collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().expect("done"))
            .collect()
    });
    let count = |answer: Answer| identified.values().filter(|(of, _)| *of == answer).count();
    let mut table = String::new();
    for (case, (answer, sentence)) in all.iter().zip(identified.values()) {
        println!("{}: {sentence}", case.name);
        let _ = writeln!(table, "{:33} {answer:?}", case.name);
    }
    let counts = [Answer::Right, Answer::Named, Answer::Unclear, Answer::Wrong].map(count);
    let [right, named, unclear, wrong] = counts;
    let _ = writeln!(
        table,
        "\n{} logs: {right} right, {named} named, {unclear} unclear, {wrong} wrong",
        all.len()
    );
    println!("{table}");
    assert!(all.len() >= 60 && wrong == 0, "{counts:?}");
    assert!((right + named) * 60 >= 55 * all.len(), "{counts:?}");
    insta::assert_snapshot!(table);
}
