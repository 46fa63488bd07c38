//! What is said of a commissioning at a terminal.

use std::fmt::Write as _;

use comfy_table::{CellAlignment, Table};
use drive_link::NoGains;
use identifier_core::commission::{
    HoldingGains, IdentifiedServo, LargestMotion, StopReason, TrialResult,
};
use identifier_core::tuning::Tuning;

use super::{UNKNOWNS, truth, values};
use crate::commission::Outcome;
use crate::render::terminal::table;
use crate::scenario::Scenario;

/// What is printed before anything moves.
#[must_use]
pub fn largest_motion(motion: &LargestMotion) -> String {
    let [low, high] = motion.travel;
    format!(
        "Until the servo is known it moves at most from {low:.4} to {high:+.4} rad of where it stands, at \
         {:.4} rad/s at most.",
        motion.speed
    )
}

/// A line for each phase.
#[must_use]
pub fn phases(outcome: &Outcome) -> String {
    let mut lines = String::new();
    for stretch in &outcome.course.phases {
        let name = stretch.phase.name();
        let (begin, lasting) = (stretch.begin, stretch.end - stretch.begin);
        // Nothing can fail that is written into memory.
        let _ = if stretch.phase.is_end() {
            writeln!(lines, "{begin:>9.4} s  {name}")
        } else {
            writeln!(lines, "{begin:>9.4} s  {name:<15}{lasting:>9.4} s long")
        };
    }
    lines
}

/// What was identified beside the truth.
#[must_use]
pub fn servo(scenario: &Scenario, servo: &IdentifiedServo) -> String {
    let mut table = heading(["servo", "identified", "unit", "true", "error"]);
    let known = values(&servo.parameters, servo.delay);
    let truth = truth(scenario);
    for (i, (name, unit, place)) in UNKNOWNS.into_iter().enumerate() {
        let (value, std_error) = (known[i], servo.standard_error(place));
        let digits = digits(std_error, value);
        let (actual, error) = match truth.map(|truth| truth[i]) {
            Some(actual) => {
                let off = value - actual;
                let relative = 100.0 * off / actual;
                let error = match actual {
                    0.0 => format!("{off:+.digits$}"),
                    _ => format!("{relative:+.2} %"),
                };
                (format!("{actual}"), error)
            }
            None => (dash(), dash()),
        };
        table.add_row([
            name.to_owned(),
            format!("{value:.digits$} ± {std_error:.digits$}"),
            unit.to_owned(),
            actual,
            error,
        ]);
    }
    right_aligned(&mut table, &[1, 3, 4]);
    table.to_string()
}

/// The gains before and the new ones.
#[must_use]
pub fn gains(before: Option<&HoldingGains>, tuning: &Tuning) -> String {
    let mut table = heading(["gain", "before", "new", "unit"]);
    table.add_rows(gain_rows(before, tuning));
    right_aligned(&mut table, &[1, 2]);
    table.to_string()
}

/// A row for each gain: its name, what it was, what it is, its unit.
#[must_use]
pub fn gain_rows(before: Option<&HoldingGains>, tuning: &Tuning) -> [[String; 4]; 4] {
    let gain = |of: fn(&HoldingGains) -> f64| before.map_or_else(dash, |before| figure(of(before)));
    [
        (
            "kp",
            gain(|g| g.controller.kp),
            tuning.kp,
            "command units per rad",
        ),
        (
            "kd",
            gain(|g| g.controller.kd),
            tuning.kd,
            "command units per rad/s",
        ),
        (
            "ki",
            gain(|g| g.controller.ki),
            tuning.ki,
            "command units per rad s",
        ),
        ("cutoff", gain(|g| g.cutoff), tuning.cutoff, "rad/s"),
    ]
    .map(|(name, before, new, unit)| [name.to_owned(), before, figure(new), unit.to_owned()])
}

/// What the new gains promise, beside what was measured in the trial.
#[must_use]
pub fn promise(servo: &IdentifiedServo, tuning: &Tuning, trial: Option<&TrialResult>) -> String {
    let mut table = heading(["response", "promised", "measured", "unit"]);
    table.add_rows(promise_rows(servo, tuning, trial));
    right_aligned(&mut table, &[1, 2]);
    table.to_string()
}

/// A row for each figure: its name, what is promised, what was measured, its unit.
#[must_use]
pub fn promise_rows(
    servo: &IdentifiedServo,
    tuning: &Tuning,
    trial: Option<&TrialResult>,
) -> [[String; 4]; 10] {
    let promise = &tuning.promise;
    let [least, most] = promise.gain_margins;
    let measured =
        |of: &dyn Fn(&TrialResult) -> Option<f64>| trial.and_then(of).map_or_else(dash, figure);
    let rise = measured(&|trial| trial.rise_time.map(|time| 1e3 * time));
    let overshoot = measured(&|trial| trial.rise_time.map(|_| 100.0 * trial.overshoot));
    let excursion = measured(&|trial| Some(trial.excursion));
    // A command acts as a load of b times itself.
    let moved = trial.map_or_else(dash, |trial| {
        figure(promise.compliance * servo.parameters.b * trial.disturbance.abs())
    });
    let bandwidth = match tuning.cap {
        Some(cap) => format!("{} by {}", figure(tuning.bandwidth), cap.name()),
        None => figure(tuning.bandwidth),
    };
    [
        ("bandwidth", bandwidth, dash(), "rad/s"),
        ("step", figure(promise.step), dash(), "rad"),
        ("rise time", figure(1e3 * promise.rise_time), rise, "ms"),
        (
            "overshoot",
            figure(100.0 * promise.overshoot),
            overshoot,
            "%",
        ),
        ("moved by the disturbance", moved, excursion, "rad"),
        (
            "settling time",
            figure(1e3 * promise.settling_time),
            dash(),
            "ms",
        ),
        (
            "largest sensitivity",
            figure(promise.sensitivity),
            dash(),
            "",
        ),
        ("gain margins", format!("{least:.2}, {most:.2}"), dash(), ""),
        (
            "command of the step",
            figure(100.0 * promise.command_share),
            dash(),
            "% of the limit",
        ),
        (
            "noise of the command",
            figure(promise.noise),
            dash(),
            "command units",
        ),
    ]
    .map(|(name, promised, measured, unit)| [name.to_owned(), promised, measured, unit.to_owned()])
}

/// How it ended, in a sentence.
#[must_use]
pub fn verdict(before: bool, outcome: &Outcome) -> String {
    let Some(end) = &outcome.end else {
        return "unfinished: it did not end by itself".to_owned();
    };
    match end.reason {
        None => format!(
            "{}: the new gains hold since {:.4} s",
            end.phase.name(),
            end.time
        ),
        Some(reason) => {
            let since = if before {
                "the gains before hold again"
            } else {
                "the servo is let go"
            };
            format!(
                "{} in {}: {} ({since} since {:.4} s)",
                end.phase.name(),
                end.within.name(),
                why(reason, outcome.no_gains.as_ref()),
                end.time
            )
        }
    }
}

/// A reason, with the figure that would do where there is one.
pub(crate) fn why(reason: StopReason, no_gains: Option<&NoGains>) -> String {
    match no_gains {
        Some(no_gains) => format!("{reason}: {no_gains}"),
        None => reason.to_string(),
    }
}

fn heading<const N: usize>(names: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_style(table::STYLE);
    table.set_header(names);
    table
}

fn right_aligned(table: &mut Table, columns: &[usize]) {
    for &column in columns {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
}

fn dash() -> String {
    "–".to_owned()
}

/// Four digits that count.
fn figure(value: f64) -> String {
    format!("{value:.*}", digits(value.abs() / 1e3, value))
}

/// The digits behind the point that show two of a standard error, or four of a value known exactly.
fn digits(std_error: f64, value: f64) -> usize {
    /// Digits behind the point that a table has room for.
    const MOST: f64 = 9.0;
    let smallest = if std_error > 0.0 {
        std_error / 10.0
    } else {
        value.abs() / 1e3
    };
    match smallest {
        0.0 => 0,
        smallest => (-smallest.log10().floor()).clamp(0.0, MOST) as usize,
    }
}
