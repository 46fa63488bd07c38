use std::fmt::Write as _;

use comfy_table::{CellAlignment, Table};
use identifier_core::tuning::{Promise, Tuning};

use super::FeedForwardDocument;
use crate::render::terminal::table;
use crate::tune::Tuned;

/// The controller as a scenario has it.
#[must_use]
pub fn controller(tuning: &Tuning, sample_time: f64) -> String {
    format!(
        "[controller]\n\
         kp = {}\n\
         kd = {}\n\
         ki = {}\n\
         sample_time = {sample_time:?}\n\
         velocity_filter = {{ kind = \"low-pass\", cutoff = {} }}\n",
        pasted(tuning.kp),
        pasted(tuning.kd),
        pasted(tuning.ki),
        pasted(tuning.cutoff)
    )
}

/// A gain with the digits that a scenario needs: seven that count.
fn pasted(value: f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// What the gains promise, a row for each figure: its name, the figure, its unit.
#[must_use]
pub fn rows(tuning: &Tuning) -> Vec<(&'static str, String, &'static str)> {
    let promise = &tuning.promise;
    let [least, most] = promise.gain_margins;
    let percent = |part: f64| figure(100.0 * part);
    let rise = figure(1e3 * promise.rise_time);
    let rise = if depends_on_friction(tuning, 1.02) {
        let [quickest, slowest] =
            [promise.quickest_rise_time, promise.slowest_rise_time].map(|time| figure(1e3 * time));
        format!("{rise} ({quickest} to {slowest})")
    } else {
        rise
    };
    let longest = Promise::LONGEST / tuning.bandwidth;
    let settling = if promise.settling_time < longest {
        figure(1e3 * promise.settling_time)
    } else {
        format!("above {}", figure(1e3 * longest))
    };
    vec![
        ("bandwidth", figure(tuning.bandwidth), "rad/s"),
        ("step", figure(promise.step), "rad"),
        ("rise time, 10 to 90 %", rise, "ms"),
        ("overshoot, at most", percent(promise.overshoot), "%"),
        ("settling time, 2 %", settling, "ms"),
        ("largest sensitivity Ms", figure(promise.sensitivity), ""),
        ("gain may fall to", figure(least), "times"),
        ("gain may rise to", figure(most), "times"),
        (
            "command of the step",
            percent(promise.command_share),
            "% of what there is",
        ),
        (
            "noise of the command",
            figure(promise.noise),
            "command units",
        ),
        (
            "stiffness",
            figure(1.0 / promise.compliance),
            "rad/s² per rad",
        ),
    ]
}

/// What the gains promise as a table.
#[must_use]
pub fn table(tuning: &Tuning) -> String {
    let mut table = Table::new();
    table.load_style(table::STYLE);
    table.set_header(["response", "promised", "unit"]);
    for (name, promised, unit) in rows(tuning) {
        table.add_row([name.to_owned(), promised, unit.to_owned()]);
    }
    if let Some(column) = table.column_mut(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.to_string()
}

/// What keeps the loop from being faster, in a sentence; and where friction makes the rise unsure.
#[must_use]
pub fn remarks(tuned: &Tuned) -> String {
    /// The trial's own tolerance of a rise time.
    const TOLERANCE: f64 = 1.15;
    let mut remarks = match tuned.tuning.cap {
        Some(cap) => format!("as fast as {cap} allows"),
        None => "as fast as was asked for".to_owned(),
    };
    if depends_on_friction(&tuned.tuning, TOLERANCE) {
        // Nothing can fail that is written into memory.
        let _ = write!(
            remarks,
            "\nfriction makes the rise time depend on the motion before, as far as is told in brackets: with a \
             larger step or a faster response it depends less on it"
        );
    }
    remarks
}

/// Whether a rise takes this many times as long where the integral pushes against it.
fn depends_on_friction(tuning: &Tuning, times: f64) -> bool {
    tuning.promise.slowest_rise_time > times * tuning.promise.quickest_rise_time
}

/// The feed-forward as a formula.
#[must_use]
pub fn feed_forward(of: &FeedForwardDocument) -> String {
    let FeedForwardDocument {
        acceleration,
        velocity,
        sign,
        constant,
        gravity_sine,
        gravity_cosine,
        lead,
    } = *of;
    let mut formula = format!("u = {} q̈r", figure(acceleration));
    for (coefficient, factor) in [
        (velocity, " q̇r"),
        (sign, " s(q̇r)"),
        (constant, ""),
        (gravity_sine, " sin qr"),
        (gravity_cosine, " cos qr"),
    ] {
        if coefficient != 0.0 {
            let sign = if coefficient < 0.0 { '−' } else { '+' };
            // Nothing can fail that is written into memory.
            let _ = write!(formula, " {sign} {}{factor}", figure(coefficient.abs()));
        }
    }
    let held = if constant == 0.0 {
        ""
    } else {
        "; leave the constant to the integral where it holds the load already"
    };
    format!(
        "feed-forward: {formula}, of the reference {:.4} ms ahead{held}",
        1e3 * lead
    )
}

/// A figure with four digits that count.
fn figure(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let places = (3.0 - value.abs().log10().floor()).clamp(0.0, 8.0);
    format!("{value:.0$}", places as usize)
}

#[cfg(test)]
mod tests {
    use super::{figure, pasted};

    #[test]
    fn figures_have_the_digits_that_count() {
        for (value, shown) in [
            (0.0, "0"),
            (134.2671, "134.3"),
            (0.013_81, "0.01381"),
            (30_900.0, "30900"),
        ] {
            assert_eq!(figure(value), shown);
        }
        for (value, shown) in [
            (98.027_123_456, "98.02712"),
            (2e-7, "2e-7"),
            (4000.0, "4000.0"),
        ] {
            assert_eq!(pasted(value), shown);
        }
    }
}
