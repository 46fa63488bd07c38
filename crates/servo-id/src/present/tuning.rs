//! Gains for an identified servo, with their predicted response.

use std::fmt::Write as _;

use identifier_core::parameters::IdentifiedServo;
use identifier_core::settings::ControllerSettings;
use identifier_core::tuning::{
    Cap, EncoderSide, PredictedResponse, PredictedSample, Resonance, StepMeasure, Tuning,
    TuningError, TuningSettings,
};
use identifier_log::result::FeedForward;
use identifier_log::scenario::{Estimator, Options};
use identifier_log::tune::{Conditions, KnownConditions, Tuned};

use super::number::{DASH, figure, plain, sentence};
use super::sensitivity::sensitivity;
use super::{Block, Column, Figure, Page, Section, Table, TimeSpan, Tone, Trace, Verdict};
use crate::SIDES;

/// The horizontal axis of a step.
const SINCE: &str = "time since the step [s]";

/// What the errors of the estimates cost, in a sentence without an end.
#[must_use]
pub fn cost_of_errors(tuned: &Tuned) -> Option<String> {
    let b = IdentifiedServo::B;
    let part = SIDES * tuned.model.servo.standard_error(b) / tuned.model.servo.parameters.b;
    let bandwidth = tuned.bandwidth_without_errors()?;
    Some(format!(
        "b is known within ± {:.1} %: the bandwidth is {:.0} rad/s instead of {bandwidth:.0}",
        100.0 * part,
        tuned.tuning.bandwidth
    ))
}

/// The page of a tuning; `warnings` are the reservations about its input.
///
/// # Errors
/// None for a tuned servo.
pub fn tuning(
    title: &str,
    command: &str,
    tuned: &Tuned,
    warnings: &[String],
) -> Result<Page, TuningError> {
    let figures = figures(tuned)?;
    let predicted_response = &tuned.tuning.predicted_response;
    let step = tuned.form.as_ref().and_then(|form| form.steps.last());
    let (rise_time, overshoot) = match step {
        Some(step) => (step.rise_time.unwrap_or(f64::INFINITY), step.overshoot),
        None => (predicted_response.rise_time, predicted_response.overshoot),
    };
    let verdict = Verdict {
        tone: match warnings {
            [] => Tone::Good,
            _ => Tone::Doubtful,
        },
        status: "tuned".to_owned(),
        headline: format!(
            "Predicted: rise time {} ms, overshoot at most {} %.",
            figure(1e3 * rise_time),
            figure(100.0 * overshoot)
        ),
        detail: match warnings {
            [] => "This is the simulated response of the identified servo.".to_owned(),
            _ => "The predicted response is uncertain: see the warning.".to_owned(),
        },
    };
    let warnings = warnings.iter().cloned().map(Block::Warning);
    let found = match &tuned.form {
        Some(form) => warnings
            .chain(super::form::form(form, &remarks(tuned)))
            .collect(),
        None => warnings.chain(gains(tuned)).collect(),
    };
    let sections = [
        Section::brief("Result", found),
        Section::full("Plots", vec![Block::Figures(figures)]),
        Section::full(
            "Conditions",
            vec![conditions(tuned), Block::List(read_as(tuned))],
        ),
    ];
    Ok(Page::new(title, command, verdict, sections))
}

/// The predicted step, its command, and the sensitivity with its limit.
///
/// # Errors
/// None for a tuned servo.
pub(super) fn figures(tuned: &Tuned) -> Result<Vec<Figure>, TuningError> {
    /// Time that is shown: in 1/ω, and in settling times, the longer of the two.
    const SHOWN: f64 = 12.0;
    const SETTLING_TIMES: f64 = 1.3;
    let Tuned {
        settings, tuning, ..
    } = tuned;
    let tuner = tuned.tuner()?;
    let settling_time = tuning.predicted_response.settling_time;
    let until = (SHOWN / tuning.bandwidth).max(SETTLING_TIMES * settling_time);
    let own = tuner
        .step(tuning)?
        .take_while(|sample| sample.time <= until);
    let in_form = tuned.form.as_ref().map(|form| form.response.clone());
    let samples = in_form.unwrap_or_else(|| own.collect());
    let course = |name: &str, value: fn(&PredictedSample) -> f64| {
        let points = samples.iter().map(|sample| (sample.time, value(sample)));
        vec![Trace::new(name, points.collect())]
    };
    let position = course("position", |sample| sample.position);
    let command = course("command", |sample| sample.command);
    let step = Figure::new("Predicted step", SINCE, "q [rad]", position)
        .with_level("reference", settings.step)
        .from_zero();
    let mut figures = vec![
        step,
        Figure::new(
            "Command minus holding command",
            SINCE,
            "u [command units]",
            command,
        ),
    ];
    // The design as known, without its form.
    if let (None, Some(last)) = (&tuned.form, samples.last()) {
        figures[0].time_spans.push(TimeSpan {
            name: format!("settled within {}", settling_band(settings)),
            extent: [settling_time.min(last.time), last.time],
            colour: 7,
        });
        figures.push(sensitivity(&tuner, tuning, settings, &[]));
    }
    Ok(figures)
}

fn conditions(tuned: &Tuned) -> Block {
    let parameters = &tuned.model.servo.parameters;
    let settings = &tuned.settings;
    let facts = [
        ("a", parameters.a, "1/s"),
        ("b", parameters.b, "rad/s² per command unit"),
        ("c", parameters.coulomb, "rad/s²"),
        ("d", parameters.load, "rad/s²"),
        (
            "Delay",
            tuned.model.servo.delay + settings.command_delay,
            "s",
        ),
        ("Encoder", settings.resolution, "rad per count"),
        ("Command", settings.command, "command units beyond holding"),
        ("Sample time", settings.sample_time, "s"),
        ("Sensitivity", settings.max_sensitivity, "at most"),
    ];
    let facts = facts.map(|(name, value, unit)| (name, format!("{} {unit}", plain(value))));
    let resonance = match &tuned.model.resonance {
        Some(Resonance { mode, .. }) => {
            let side = match mode.ratio < 0.0 {
                true => "encoder on the load".to_owned(),
                false => format!("load {} of the motor's inertia", figure(mode.ratio)),
            };
            let (frequency, damping) = (figure(mode.frequency), figure(mode.damping));
            format!("{frequency} rad/s, damping {damping}, {side}")
        }
        None => "none found".to_owned(),
    };
    let hidden = match tuned.hidden_from() {
        Some(from) => format!(
            "any from {} rad/s on, load up to {} times the motor's inertia{}, damping from {}",
            figure(from),
            TuningSettings::HIDDEN_RATIO,
            match (tuned.settings.encoder, &tuned.model.resonance) {
                (EncoderSide::Unknown, None) => " or encoder on the load",
                _ => "",
            },
            TuningSettings::HIDDEN_DAMPING
        ),
        None => "none, as stated".to_owned(),
    };
    let facts = facts.into_iter();
    Block::facts(facts.chain([("Resonance", resonance), ("Resonance not shown", hidden)]))
}

/// How the log was read.
fn read_as(tuned: &Tuned) -> Vec<String> {
    let reading = tuned.reading.as_ref();
    reading.map_or_else(Vec::new, |reading| reading.lines())
}

/// The stiffest gains for a result, with what they assume.
pub(super) fn advice(tuned: &Tuned, known: &KnownConditions) -> Vec<Block> {
    let assumed = Conditions::default().assumptions(known).into_iter();
    assumed.map(Block::Warning).chain(gains(tuned)).collect()
}

/// Gains that were found: the controller, its predicted response, the feed-forward.
fn gains(tuned: &Tuned) -> Vec<Block> {
    let mut blocks = vec![
        Block::Code {
            caption: "Controller for a scenario".to_owned(),
            text: tuned_controller(tuned),
        },
        Block::Table(predicted_response(tuned)),
    ];
    let unlimited = tuned.without_limit().map(|Tuning { kp, kd, ki, .. }| {
        let [kp, kd, ki] = [kp, kd, ki].map(figure);
        format!("without the limit of the command: kp = {kp}, kd = {kd}, ki = {ki}")
    });
    let remarks = unlimited.into_iter().chain(remarks(tuned));
    blocks.extend(remarks.map(|remark| Block::Text(sentence(&remark))));
    blocks.extend(first_trial(tuned).map(|trial| Block::Text(sentence(&trial))));
    let feed_forward = feed_forward(&tuned.feed_forward());
    blocks.push(Block::Text(sentence(&feed_forward)));
    blocks
}

/// The controller of a tuning as a scenario has it.
#[must_use]
pub fn tuned_controller(tuned: &Tuned) -> String {
    controller(&tuned.tuning, tuned.settings.sample_time)
}

/// The controller as a scenario has it.
pub(super) fn controller(tuning: &Tuning, sample_time: f64) -> String {
    let mut controller = ControllerSettings::tuned(tuning, [f64::NEG_INFINITY, f64::INFINITY]);
    let mut options = Options::blank();
    options.stated.sample_time = sample_time;
    options.stated.cutoff = tuning.cutoff;
    let mut rounded = vec![
        &mut controller.kp,
        &mut controller.kd,
        &mut controller.ki,
        &mut controller.reference_filter,
        &mut controller.notch,
        &mut options.stated.cutoff,
    ];
    if let Some(led) = &mut controller.feed_forward {
        rounded.extend([
            &mut led.bandwidth,
            &mut led.acceleration,
            &mut led.velocity,
            &mut led.coulomb,
            &mut led.coulomb_speed,
        ]);
    }
    for gain in rounded {
        *gain = seven_digits(*gain);
    }
    options.stated.controller = Some(controller);
    options.identifier.set_estimator(Estimator::Gradient);
    options.text()
}

/// A gain as a scenario needs it, with seven digits.
fn seven_digits(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// The band around a step's end in which it has settled: a part of the step, or counts where these are more.
fn settling_band(settings: &TuningSettings) -> String {
    type Measure = StepMeasure<f64>;
    let counts = Measure::MIN_BAND_COUNTS * settings.resolution / settings.step;
    let per_cent = plain(100.0 * Measure::BAND.max(counts));
    match counts > Measure::BAND {
        true => format!("{per_cent} % ({} counts)", Measure::MIN_BAND_COUNTS),
        false => format!("{per_cent} %"),
    }
}

/// Names of the figures that a trial measures.
pub(super) const RISE_TIME: &str = "rise time, 10 to 90 %";
pub(super) const OVERSHOOT: &str = "largest overshoot";

/// A figure of a predicted response: its name, the figure, its unit.
type PredictedFigure = (&'static str, String, &'static str);

/// The figures of a predicted response.
pub(super) fn predicted_figures(tuning: &Tuning) -> [PredictedFigure; 12] {
    let of = &tuning.predicted_response;
    let [least, most] = of.gain_margins;
    let rises = [of.quickest_rise_time, of.slowest_rise_time];
    let [quickest, slowest] = rises.map(|time| figure(1e3 * time));
    let longest = PredictedResponse::MAX_TIME / tuning.bandwidth;
    let settling = if of.settling_time < longest {
        figure(1e3 * of.settling_time)
    } else {
        format!("above {}", figure(1e3 * longest))
    };
    let percent = |part: f64| figure(100.0 * part);
    [
        ("bandwidth", figure(tuning.bandwidth), "rad/s"),
        ("step", figure(of.step), "rad"),
        (RISE_TIME, figure(1e3 * of.rise_time), "ms"),
        ("with friction", format!("{quickest} to {slowest}"), "ms"),
        (OVERSHOOT, percent(of.overshoot), "%"),
        ("settling time", settling, "ms"),
        ("largest sensitivity Ms", figure(of.sensitivity), ""),
        ("lower gain margin", figure(least), "times"),
        ("upper gain margin", figure(most), "times"),
        (
            "command of the step",
            percent(of.command_share),
            "% of the limit",
        ),
        ("noise of the command", figure(of.noise), "command units"),
        ("stiffness", figure(1.0 / of.compliance), "rad/s² per rad"),
    ]
}

/// What to try before the gains themselves.
fn first_trial(tuned: &Tuned) -> Option<String> {
    let first = tuned.first_trial()?;
    let Tuning { kp, kd, ki, .. } = first;
    let [kp, kd, ki, cutoff] = [kp, kd, ki, first.cutoff].map(figure);
    let predicted = &first.predicted_response;
    Some(format!(
        "first trial, a quarter of the bandwidth: kp = {kp}, kd = {kd}, ki = {ki}, cutoff = {cutoff}, reference_filter = {}; \
         make a step of {} rad and see that it rises in {} ms, overshoots by {} % at most and comes to rest; if it does not, \
         the full gains will not either",
        figure(first.reference_filter),
        figure(predicted.step),
        figure(1e3 * predicted.rise_time),
        figure(100.0 * predicted.overshoot)
    ))
}

/// A row for each figure of the predicted response.
fn predicted_response(tuned: &Tuned) -> Table {
    let columns = Column::all(&["response"], &["predicted"], &["unit"]);
    let rows = predicted_figures(&tuned.tuning).map(|(name, predicted, unit)| {
        let (name, predicted) = match name {
            "settling time" => {
                let band = settling_band(&tuned.settings);
                (format!("{name}, {band}"), settling_range(tuned, predicted))
            }
            "command of the step" if tuned.settings.command.is_infinite() => {
                (name.to_owned(), DASH.to_owned())
            }
            _ => (name.to_owned(), predicted),
        };
        vec![name, predicted, unit.to_owned()]
    });
    Table::new("", columns, rows.into())
}

/// A settling time with its range, where friction makes one.
fn settling_range(tuned: &Tuned, predicted: String) -> String {
    let [shortest, longest] = tuned.settling_times();
    if longest < 1.05 * shortest {
        return predicted;
    }
    match longest.is_finite() {
        true => format!("{} to {}", figure(1e3 * shortest), figure(1e3 * longest)),
        false => format!("{} or longer", figure(1e3 * shortest)),
    }
}

/// The reason why the loop is not faster, and the effect of friction on its rise time.
fn remarks(tuned: &Tuned) -> Vec<String> {
    /// The trial's own tolerance of a rise time.
    const TOLERANCE: f64 = 1.15;
    let mut remarks = vec![match tuned.tuning.cap {
        Some(cap) => format!("the loop is as fast as {cap} allows"),
        None => "the loop is as fast as was asked for".to_owned(),
    }];
    let is_hidden = tuned.tuning.cap == Some(Cap::UnseenResonance);
    if let Some((from, bandwidth)) = tuned.hidden_from().zip(tuned.bandwidth_without_hidden())
        && is_hidden
    {
        remarks.push(format!(
            "a log with quick steps or a chirp up to {} rad/s would show whether there is a resonance; without one the loop \
             reaches {bandwidth:.0} rad/s (--resonance inf if you know that there is none, --encoder-on motor if the encoder \
             is on the motor)",
            figure(3.0 * from)
        ));
    }
    remarks.extend(
        tuned
            .model
            .bounds
            .iter()
            .map(|bound| bound.sentence(&tuned.tuning)),
    );
    if depends_on_friction(&tuned.tuning, TOLERANCE) {
        remarks.push(
            "with friction the rise time depends on the previous motion, within the range shown: a larger step or a \
             faster response depends less on it"
                .to_owned(),
        );
    }
    remarks
}

/// True if a rise takes this many times as long where the integral pushes against it.
fn depends_on_friction(tuning: &Tuning, times: f64) -> bool {
    tuning.predicted_response.slowest_rise_time
        > times * tuning.predicted_response.quickest_rise_time
}

/// The feed-forward as a formula.
pub(super) fn feed_forward(of: &FeedForward) -> String {
    let FeedForward {
        acceleration,
        velocity,
        sign,
        constant,
        gravity_sine,
        gravity_cosine,
        ripple_sine,
        ripple_cosine,
        ripple_order,
        dead_band,
        lead,
    } = *of;
    let mut formula = format!("u = {} q̈r", figure(acceleration));
    for (coefficient, factor) in [
        (velocity, " q̇r"),
        (sign, " s(q̇r)"),
        (constant, ""),
        (gravity_sine, " sin qr"),
        (gravity_cosine, " cos qr"),
        (ripple_sine, &format!(" sin {ripple_order} qr")),
        (ripple_cosine, &format!(" cos {ripple_order} qr")),
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
        "; leave the constant out if the integral already holds the load"
    };
    let swallowed = if dead_band == 0.0 {
        String::new()
    } else {
        format!(", and {} in its direction", figure(dead_band))
    };
    format!(
        "feed-forward: {formula}{swallowed}, of the reference {:.4} ms ahead{held}",
        1e3 * lead
    )
}

#[cfg(test)]
mod tests {
    use super::seven_digits;

    #[test]
    fn gains_of_a_scenario_have_seven_digits() {
        for (value, shown) in [
            (98.027_123_456, "98.02712"),
            (2e-7, "2e-7"),
            (4000.0, "4000.0"),
        ] {
            assert_eq!(format!("{:?}", seven_digits(value)), shown);
        }
    }
}
