//! A list of the mistakes that logs have, each made in the log of a simulated servo.

mod broken_cells;
mod columns;
mod dialects;
mod times;
mod units;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::Value;

use super::GAIN;
use crate::support::{Folder, folder, standard_error};

/// A log with a mistake or a peculiarity.
struct Case {
    name: &'static str,
    bytes: Vec<u8>,
    options: &'static str,
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
    fn identify(&self, folder: &Folder) -> (Answer, String) {
        folder.write("log.csv", &self.bytes);
        let output = folder.call(&format!("identify log.csv --json - {}", self.options));
        let is_named =
            |sentence: &str| matches!(self.expected, Named(words) if sentence.contains(words));
        let not_right = |sentence: &str| match is_named(sentence) {
            true => Answer::Named,
            false => Answer::Unclear,
        };
        if output.status.code() != Some(0) {
            let message = standard_error(&output);
            let message = message.trim_start_matches("error: ").trim().to_owned();
            return (not_right(&message), message);
        }
        let result: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let text = |key: &str| result[key].as_str().unwrap_or_default().to_owned();
        let gain = result["estimates"]["b"]["value"]
            .as_f64()
            .unwrap_or(f64::NAN);
        let is_right = matches!(self.expected, Gain(right) if (gain / right - 1.0).abs() < 0.05);
        let sentence = format!("{}: {}", text("status"), text("reason"));
        match (text("status") == "converged", is_right) {
            (true, true) => (Answer::Right, format!("b = {gain:.0}")),
            (true, false) => (Answer::Wrong, format!("b = {gain:.1}; {sentence}")),
            _ => (not_right(&sentence), sentence),
        }
    }
}

/// Numbers from −1 to 1 in no order.
fn noise(k: usize) -> f64 {
    let k = k as u64 + 1;
    let mixed = (k ^ (k >> 7)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11;
    (mixed as f64) / (1_u64 << 52) as f64 - 1.0
}

/// Numbers by a function of each and its place.
fn map_at(of: &[f64], by: impl Fn(usize, f64) -> f64) -> Vec<f64> {
    of.iter().enumerate().map(|(k, x)| by(k, *x)).collect()
}

/// A text with the lines that are kept; the heading is line 0.
fn kept(text: &str, is_kept: impl Fn(usize) -> bool) -> String {
    let lines = text.lines().enumerate().filter(|(k, _)| is_kept(*k));
    lines.map(|(_, line)| format!("{line}\n")).collect()
}

#[derive(Default)]
struct Cases(Vec<Case>);

impl Cases {
    /// A log that gives the gain of the servo.
    fn right(&mut self, name: &'static str, log: impl Into<Vec<u8>>) {
        self.stated(name, log, "", Gain(GAIN));
    }

    /// A log that gives another gain, in units that it names or that nobody stated.
    fn gain(&mut self, name: &'static str, log: impl Into<Vec<u8>>, gain: f64) {
        self.stated(name, log, "", Gain(gain));
    }

    /// A log whose mistake is named by these words.
    fn named(&mut self, name: &'static str, log: impl Into<Vec<u8>>, words: &'static str) {
        self.stated(name, log, "", Named(words));
    }

    /// A log with options that state something about it.
    fn stated(
        &mut self,
        name: &'static str,
        log: impl Into<Vec<u8>>,
        options: &'static str,
        expected: Expected,
    ) {
        let bytes = log.into();
        self.0.push(Case {
            name,
            bytes,
            options,
            expected,
        });
    }
}

#[test]
fn mistakes_are_named_or_taken_right_and_never_converge() {
    /// Threads that identify.
    const THREADS: usize = 2;
    let mut cases = Cases::default();
    cases.dialects();
    cases.times();
    cases.units();
    cases.signs_and_columns();
    cases.broken_cells();
    let all = &cases.0;
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
        let done = |thread: std::thread::ScopedJoinHandle<'_, _>| thread.join().expect("done");
        threads.into_iter().flat_map(done).collect()
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
