//! What a tuning found and what it promises: in words, as JSON and as a picture.

use std::fmt::Write as _;

use comfy_table::{CellAlignment, Table, presets};
use identifier_core::tuning::{Cap, PredictedSample, Promise, Tuner, Tuning, TuningError};
use serde::Serialize;

use super::plot::{self, Curve, Panel};
use crate::tune::Tuned;

/// The result of a tuning as the command line promises it.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct Document {
    pub sample_time: f64,
    pub kp: f64,
    pub kd: f64,
    pub ki: f64,
    pub cutoff: f64,
    pub bandwidth: f64,
    pub cap: Option<&'static str>,
    pub promise: PromiseDocument,
    pub feed_forward: FeedForwardDocument,
    pub servo: ServoDocument,
    pub conditions: ConditionsDocument,
}

/// What is promised.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct PromiseDocument {
    pub step: f64,
    pub rise_time: f64,
    pub quickest_rise_time: f64,
    pub slowest_rise_time: f64,
    pub overshoot: f64,
    pub settling_time: f64,
    pub sensitivity: f64,
    pub gain_margins: [f64; 2],
    pub command_share: f64,
    pub noise: f64,
    pub compliance: f64,
    pub stiffness: f64,
}

/// Coefficients of the reference's motion in the command, command units per SI unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct FeedForwardDocument {
    pub acceleration: f64,
    pub velocity: f64,
    pub sign: f64,
    pub constant: f64,
    pub gravity_sine: f64,
    pub gravity_cosine: f64,
    pub lead: f64,
}

/// The servo that was tuned for.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct ServoDocument {
    pub a: f64,
    pub b: f64,
    pub coulomb: f64,
    pub load: f64,
    pub delay: f64,
}

/// What was tuned under; null for no limit and for no known resonance.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct ConditionsDocument {
    pub resolution: f64,
    pub command: Option<f64>,
    pub command_delay: f64,
    pub most_sensitivity: f64,
    pub most_noise: f64,
    pub resonance: Option<f64>,
}

impl Document {
    /// The document of a tuning.
    #[must_use]
    pub fn new(tuned: &Tuned) -> Self {
        let Tuned {
            servo,
            settings,
            tuning,
            ..
        } = tuned;
        let promise = &tuning.promise;
        let finite = |value: f64| value.is_finite().then_some(value);
        Self {
            sample_time: settings.sample_time,
            kp: tuning.kp,
            kd: tuning.kd,
            ki: tuning.ki,
            cutoff: tuning.cutoff,
            bandwidth: tuning.bandwidth,
            cap: tuning.cap.map(Cap::name),
            promise: PromiseDocument {
                step: promise.step,
                rise_time: promise.rise_time,
                quickest_rise_time: promise.quickest_rise_time,
                slowest_rise_time: promise.slowest_rise_time,
                overshoot: promise.overshoot,
                settling_time: promise.settling_time,
                sensitivity: promise.sensitivity,
                gain_margins: promise.gain_margins,
                command_share: promise.command_share,
                noise: promise.noise,
                compliance: promise.compliance,
                stiffness: 1.0 / promise.compliance,
            },
            feed_forward: FeedForwardDocument::new(tuned),
            servo: ServoDocument {
                a: servo.parameters.a,
                b: servo.parameters.b,
                coulomb: servo.parameters.coulomb,
                load: servo.parameters.load,
                delay: servo.delay,
            },
            conditions: ConditionsDocument {
                resolution: settings.resolution,
                command: finite(settings.command),
                command_delay: settings.command_delay,
                most_sensitivity: settings.most_sensitivity,
                most_noise: settings.most_noise,
                resonance: settings.resonance,
            },
        }
    }
}

impl FeedForwardDocument {
    fn new(tuned: &Tuned) -> Self {
        let Tuned {
            servo,
            gravity: [sine, cosine],
            settings,
            tuning,
        } = tuned;
        let parameters = servo.parameters;
        let b = parameters.b;
        Self {
            acceleration: 1.0 / b,
            velocity: parameters.a / b + tuning.kd,
            sign: parameters.coulomb / b,
            // Without a zero's sign.
            constant: 0.0 - parameters.load / b,
            gravity_sine: 0.0 - sine / b,
            gravity_cosine: 0.0 - cosine / b,
            lead: servo.delay + settings.command_delay + settings.sample_time / 2.0,
        }
    }
}

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

/// What the gains promise, a row for each figure.
#[must_use]
pub fn table(tuning: &Tuning) -> String {
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
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY);
    table.set_header(["response", "promised", "unit"]);
    for (name, promised, unit) in [
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
    ] {
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
pub fn feed_forward(tuned: &Tuned) -> String {
    let FeedForwardDocument {
        acceleration,
        velocity,
        sign,
        constant,
        gravity_sine,
        gravity_cosine,
        lead,
    } = FeedForwardDocument::new(tuned);
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

/// The predicted step, its command, and the sensitivity with its limit.
///
/// # Errors
/// None for what was tuned.
pub fn panels(tuned: &Tuned) -> Result<Vec<Panel>, TuningError> {
    /// How long the step is shown, in 1/ω.
    const SHOWN: f64 = 12.0;
    /// What a panel shows, in what its dashed line stands at: room for the curve and its names.
    const ROOM: f64 = 2.0;
    let Tuned {
        settings, tuning, ..
    } = tuned;
    let tuner = tuned.tuner()?;
    let until = SHOWN / tuning.bandwidth;
    let samples: Vec<_> = tuner
        .step(tuning)?
        .take_while(|sample| sample.time <= until)
        .collect();
    let curve = |points: Vec<(f64, f64)>, name: Option<&str>| Curve {
        name: name.map(str::to_owned),
        points,
        band: Vec::new(),
    };
    let of_step = |value: fn(&PredictedSample) -> f64| {
        let points = samples.iter();
        vec![curve(
            points.map(|sample| (sample.time, value(sample))).collect(),
            None,
        )]
    };
    let panel = |title: &str, axis: &str, curves| Panel {
        title: title.to_owned(),
        abscissa: plot::TIME.to_owned(),
        axis: axis.to_owned(),
        logarithmic: false,
        curves,
        nominal: None,
        range: None,
    };
    let mut position = panel(
        "Predicted step",
        "q [rad]",
        of_step(|sample| sample.position),
    );
    position.nominal = Some(("reference".to_owned(), settings.step));
    position.range = Some((0.0, ROOM * settings.step));
    let command = panel(
        "Command beyond what holds the load",
        "u [command units]",
        of_step(|sample| sample.command),
    );
    let mut sensitivity = panel(
        "Sensitivity",
        "|S|",
        sensitivities(&tuner, tuned)
            .into_iter()
            .zip(["identified", "worst that it may be"])
            .map(|(points, name)| curve(points, Some(name)))
            .collect(),
    );
    sensitivity.abscissa = "frequency over ω".to_owned();
    sensitivity.nominal = Some(("allowed".to_owned(), settings.most_sensitivity));
    sensitivity.range = Some((0.0, ROOM * settings.most_sensitivity));
    Ok(vec![position, command, sensitivity])
}

/// |S| of the identified servo and of the worst, over the frequency in ω.
fn sensitivities(tuner: &Tuner, tuned: &Tuned) -> [Vec<(f64, f64)>; 2] {
    /// Up to where it is shown, in ω, and how finely.
    const HIGHEST: f64 = 12.0;
    const POINTS: u32 = 600;
    let mut curves = [Vec::new(), Vec::new()];
    for i in 1..=POINTS {
        let frequency = HIGHEST * f64::from(i) / f64::from(POINTS);
        let found = tuner.sensitivity(&tuned.tuning, frequency * tuned.tuning.bandwidth);
        for (curve, value) in curves.iter_mut().zip(found.into_iter().flatten()) {
            curve.push((frequency, value));
        }
    }
    curves
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
