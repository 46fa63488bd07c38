//! Tables for a terminal.

use identifier_core::parameters::{Parameter, ServoParameters};

use crate::analysis::Status;
use crate::render::terminal::table::Rows;
use crate::result::{Estimate, Summary};

/// One row for each experiment, named in the first column; friction only where some law estimates
/// it, deviations and settling times only where some truth is known, and where `width` characters have room.
#[must_use]
pub fn estimates(rows: &[(&str, &Summary)], width: u16) -> String {
    let friction = rows
        .iter()
        .any(|(_, summary)| summary.estimate(Parameter::Coulomb).is_some());
    let truth = rows.iter().any(|(_, summary)| summary.truth.is_some());

    let mut table = Rows::default().words("experiment").figures("â [1/s]");
    if truth {
        table = table.figures("â − a").dispensable(1);
    }
    table = table.figures("b̂ [rad/s²/u]");
    if truth {
        table = table.figures("b̂/b − 1").dispensable(0);
    }
    if friction {
        table = table.figures("ĉ [rad/s²]");
    }
    table = table.figures("d̂ [rad/s²]");
    if truth {
        table = table.figures("settled a, b [s]").dispensable(2);
    }
    table = table.words("status");
    for (name, summary) in rows {
        let is_known = |estimate: &&Estimate| !is_unknown(summary.status(), estimate);
        let cell =
            |parameter, digits| with_spread(summary.estimate(parameter).filter(is_known), digits);
        let deviation = |of: &dyn Fn(&ServoParameters) -> String| {
            truth.then(|| summary.truth.as_ref().map_or_else(dash, of))
        };
        let (a, b) = (&summary.estimates.a, &summary.estimates.b);
        let [off_a, off_b] = [a, b].map(|estimate| is_known(&estimate));
        let mut row = vec![(*name).to_owned(), cell(Parameter::A, 4)];
        row.extend(deviation(&|truth| {
            let off = a.tail_mean - truth.a;
            if off_a && off.is_finite() {
                format!("{off:+.4}")
            } else {
                dash()
            }
        }));
        row.push(cell(Parameter::B, 2));
        row.extend(deviation(&|truth| {
            let off = 100.0 * (b.tail_mean / truth.b - 1.0);
            if off_b && off.is_finite() {
                format!("{off:+.3} %")
            } else {
                dash()
            }
        }));
        row.extend(friction.then(|| cell(Parameter::Coulomb, 3)));
        row.push(cell(Parameter::Load, 2));
        row.extend(deviation(&|_| {
            format!(
                "{}, {}",
                seconds(summary.settling_time.a),
                seconds(summary.settling_time.b)
            )
        }));
        row.push(summary.status().name().to_owned());
        table.row(row);
    }
    table.within(width)
}

/// Whether nothing was found: the data say nothing of it, or it never left where it began.
fn is_unknown(status: Status, estimate: &Estimate) -> bool {
    let is_none = matches!(status, Status::NoInformation | Status::Aborted);
    let is_endless = |error: f64| !error.is_finite();
    estimate.std_error.is_some_and(is_endless) || is_none && estimate.tail_std <= 0.0
}

fn dash() -> String {
    "–".to_owned()
}

/// Mean ± standard deviation over the tail; + 0.0 turns a negative zero into zero. So many digits
/// behind the point, or as many as it takes to show three of a mean that stands out of its spread.
fn with_spread(estimate: Option<&Estimate>, digits: usize) -> String {
    /// Digits behind the point that a table has room for.
    const MOST_DIGITS: f64 = 7.0;
    let known = estimate.filter(|estimate| estimate.last.is_finite());
    known.map_or_else(dash, |estimate| {
        let Estimate {
            tail_mean,
            tail_std,
            ..
        } = estimate;
        let digits = if tail_mean.abs() > *tail_std {
            let needed = (2.0 - tail_mean.abs().log10().floor()).min(MOST_DIGITS);
            digits.max(needed as usize)
        } else {
            digits
        };
        let scale = 10_f64.powi(digits as i32);
        let mean = (tail_mean * scale).round() / scale + 0.0;
        format!("{mean:.digits$} ± {tail_std:.digits$}")
    })
}

fn seconds(time: Option<f64>) -> String {
    time.map_or_else(|| "not".to_owned(), |time| format!("{time:.2}"))
}
