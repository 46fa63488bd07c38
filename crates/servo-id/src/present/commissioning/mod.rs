//! The page of a commissioning.

mod traces;

pub use traces::CommissionTraces;

use std::f64::consts::TAU;

use commissioning::{HoldingGains, LargestMotion, Limits, Phase, TrialResult};
use host_sim::commission::Outcome;
use host_sim::result::commissioning::{COMMISSIONED, commissioned_truth, commissioned_values};
use host_sim::scenario::Scenario;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::tuning::{AxisForces, Resonance, Tuning};
use identifier_log::result::{FeedForward, Gains, KnownForces};
use identifier_log::verdict::Cause;

use super::estimates::{self, Estimated, dash};
use super::number::{figure, fixed, plain, sentence, signed};
use super::tuning::{OVERSHOOT, RISE_TIME, controller, feed_forward, predicted_figures};
use super::{Block, Column, Page, Section, Table, Tone, Verdict};

/// A commissioning.
#[derive(Debug, Clone, Copy)]
pub struct Commissioned<'a> {
    /// The experiment and its object.
    pub title: &'a str,
    /// The command line.
    pub command: &'a str,
    /// The scenario.
    pub scenario: &'a Scenario,
    /// Limits on the axis.
    pub limits: &'a Limits,
    /// The gains that held the servo before, if there were any.
    pub before: Option<&'a HoldingGains>,
    /// The outcome.
    pub outcome: &'a Outcome,
    /// The effects that its five numbers lack.
    pub effects: &'a [Cause],
    /// Signals over time; none for a page whose brief form is enough.
    pub traces: Option<&'a CommissionTraces>,
}

/// The page of a commissioning.
#[must_use]
pub fn commissioning(of: &Commissioned<'_>) -> Page {
    let mut sections = vec![
        Section::brief("Phases", vec![Block::Table(phases(of.outcome))]),
        Section::brief("Result", found(of)),
    ];
    if let Some(traces) = of.traces {
        let figures = traces::figures(of, traces);
        sections.extend([
            Section::full("Over time", vec![Block::Figures(figures)]),
            Section::full("Limits", vec![Block::Table(limits(of))]),
            Section::full("Remedies", remedies(of.outcome)),
            Section::full("Controller", controller_of(of)),
        ]);
    }
    Page::new(of.title, of.command, verdict(of), sections)
}

/// The bound of the motion before the servo is known, printed before anything moves.
#[must_use]
pub fn largest_motion(motion: &LargestMotion) -> String {
    let [low, high] = motion.travel;
    format!(
        "Until the servo is identified it moves at most from {low:.4} to {high:+.4} rad from the start, at {:.4} \
         rad/s at most.",
        motion.speed
    )
}

/// How far the axis can go if its encoder sticks, printed before anything moves.
#[must_use]
pub fn unseen_motion(motion: &LargestMotion) -> String {
    let found = format!(
        "The encoder is trusted: if it sticks, that is detected within {} s of commanded motion",
        LargestMotion::STUCK_ENCODER_TIME
    );
    match motion.unseen {
        Some(unseen) => format!("{found}, in which the axis can move {unseen:.4} rad."),
        None => format!(
            "{found}. State commission.max_gain to see how far the axis can move until then."
        ),
    }
}

fn verdict(of: &Commissioned<'_>) -> Verdict {
    let outcome = of.outcome;
    let detail = detail(outcome, of.effects);
    let phase = outcome.end.map(|end| end.phase);
    let is_held = outcome.end.is_some_and(|end| end.disabled.is_none());
    let (tone, headline) = match (phase, &outcome.tuning) {
        (Some(Phase::Applied), Some(tuning)) => {
            let rise = 1e3 * tuning.predicted_response.rise_time;
            let measured = outcome
                .trial
                .and_then(|trial| trial.rise_time)
                .map_or_else(String::new, |time| {
                    format!(" (measured: {} ms)", figure(1e3 * time))
                });
            (
                Tone::Good,
                format!(
                    "The servo is identified and tuned: predicted rise time {} ms{measured}.",
                    figure(rise)
                ),
            )
        }
        (Some(Phase::RolledBack), _) if is_held => (
            Tone::Doubtful,
            "No new gains: the previous ones are in force again.".to_owned(),
        ),
        _ => (
            Tone::Failed,
            "No new gains: the commissioning was aborted.".to_owned(),
        ),
    };
    Verdict {
        tone,
        status: phase.map_or("unfinished", Phase::name).to_owned(),
        headline,
        detail,
    }
}

/// The end, and its reason.
fn detail(outcome: &Outcome, effects: &[Cause]) -> String {
    let Some(end) = &outcome.end else {
        return "it did not end".to_owned();
    };
    match end.reason {
        None => format!("the new gains are in force since {:.4} s", end.time),
        Some(reason) => {
            let (state, since) = match end.disabled {
                None => ("the previous gains are in force", end.time),
                Some(time) => ("the servo is disabled", time),
            };
            format!(
                "in {}: {} ({state} since {since:.4} s)",
                end.within.name(),
                why(
                    reason,
                    outcome.no_gains.as_ref().map(|error| error as _),
                    outcome.noise,
                    effects
                ),
            )
        }
    }
}

/// A reason, with the possible figure if there is one, and with the effects that the record shows.
pub(crate) fn why(
    reason: Reason,
    no_gains: Option<&dyn std::fmt::Display>,
    noise: f64,
    effects: &[Cause],
) -> String {
    let found = effects.iter().map(|cause| cause.meaning());
    let found = match Vec::from_iter(found).join(", ") {
        none if none.is_empty() => none,
        found => format!("; the fit of the record finds {found}"),
    };
    match no_gains {
        Some(no_gains) => format!("{reason}: {no_gains}{found}"),
        None if reason == Reason::EncoderNoise => {
            format!("{reason}: the noise at standstill is identifier.noise = {noise:.3e} rad")
        }
        None => format!("{reason}{found}"),
    }
}

fn phases(outcome: &Outcome) -> Table {
    let figures = [
        "from [s]",
        "duration [s]",
        "lowest [rad]",
        "highest [rad]",
        "fastest [rad/s]",
        "command, rms",
    ];
    let rows = outcome.course.phases.iter().map(|time_span| {
        let lasting = match time_span.phase.is_end() {
            true => dash(),
            false => fixed(time_span.end - time_span.begin, 4),
        };
        let motion = time_span.excursion.map_or_else(
            || [dash(), dash(), dash(), dash()],
            |went| {
                let [lowest, highest] = went.position;
                let heating = figure(went.command_rms);
                [
                    signed(lowest, 4),
                    signed(highest, 4),
                    figure(went.speed),
                    heating,
                ]
            },
        );
        let name = time_span.phase.name().to_owned();
        let times = [name, fixed(time_span.begin, 4), lasting];
        times.into_iter().chain(motion).collect()
    });
    Table::new(
        "Phases",
        Column::all(&["phase"], &figures, &[]),
        rows.collect(),
    )
}

fn found(of: &Commissioned<'_>) -> Vec<Block> {
    let outcome = of.outcome;
    let Some(servo) = outcome.servo() else {
        return vec![Block::text(
            "None: the commissioning ended before the servo was identified.",
        )];
    };
    let truth = commissioned_truth(of.scenario);
    let mut blocks = found_servo(
        servo,
        truth,
        of.before,
        outcome.tuning.as_ref(),
        outcome.trial.as_ref(),
    );
    blocks.push(Block::Text(masses(outcome)));
    blocks.extend(forces(&outcome.forces).map(Block::Text));
    blocks
}

/// The forces that were found beside the five numbers.
fn forces(found: &AxisForces) -> Option<String> {
    let (size, order) = (figure(found.wave_amplitude()), figure(found.order));
    if found.has_cogging() {
        return Some(format!(
            "Cogging: {size} rad/s², {order} periods to a revolution."
        ));
    }
    if found.has_gravity() {
        return Some(format!(
            "The load changes with the angle, by gravity or a spring: {size} rad/s²."
        ));
    }
    let (more, below) = (found.low_speed, 1.0 / found.per_low_speed_velocity);
    (more > 0.0).then(|| {
        let [more, below] = [more, below].map(figure);
        format!("Friction is higher by {more} rad/s² at rest, and below {below} rad/s.")
    })
}

/// The masses by the frequency response.
fn masses(outcome: &Outcome) -> String {
    let Some(response) = &outcome.response else {
        return "No frequency response was measured: the travel was too short for it, or the commissioning ended \
                earlier. A resonance that friction hides at standstill would not have been found."
            .to_owned();
    };
    let hertz = |omega: f64| figure(omega / TAU);
    let (lines, highest) = (response.lines.len(), hertz(response.highest_frequency()));
    let Some(Resonance { mode, errors, .. }) = &response.resonance else {
        return format!(
            "The {lines} lines of the frequency response, up to {highest} Hz, show no resonance."
        );
    };
    let [error, _] = errors;
    format!(
        "Two masses: {lines} lines of the frequency response, up to {highest} Hz, show a resonance at {} Hz \
         (standard error {} %), an antiresonance at {} Hz and an inertia ratio of {}; the damping ratio is at most \
         {}.",
        hertz(mode.frequency),
        figure(100.0 * error),
        hertz(mode.antiresonance()),
        figure(mode.ratio),
        figure(mode.damping),
    )
}

/// The identified servo beside its truth, the gains, and their predicted response beside the trial.
#[must_use]
pub fn found_servo(
    servo: &IdentifiedServo,
    truth: Option<[f64; 5]>,
    before: Option<&HoldingGains>,
    tuning: Option<&Tuning>,
    trial: Option<&TrialResult>,
) -> Vec<Block> {
    let values = commissioned_values(&servo.parameters, servo.delay);
    let unknowns = COMMISSIONED.into_iter().zip(values).enumerate();
    let rows: Vec<Estimated> = unknowns
        .map(|(i, ((unknown, place), value))| Estimated {
            truth: truth.map(|truth| truth[i]),
            ..Estimated::new(unknown, value, Some(servo.standard_error(place)))
        })
        .collect();
    let named = |caption: &str, table: Table| Table {
        caption: caption.to_owned(),
        ..table
    };
    let mut blocks = vec![Block::Table(named("Servo", estimates::table(&rows)))];
    if let Some(tuning) = tuning {
        blocks.push(Block::Table(gains(before, tuning)));
        blocks.push(Block::Table(Table::new(
            "Predicted response of the new gains, and the trial",
            Column::all(&["response"], &["predicted", "measured"], &["unit"]),
            predicted_rows(tuning, trial).into(),
        )));
    }
    blocks
}

fn gains(before: Option<&HoldingGains>, tuning: &Tuning) -> Table {
    let old = before.map(|gains| Gains::of(&gains.controller, gains.cutoff));
    let new = Gains::tuned(tuning);
    let size = |value: f64| match value {
        0.0 => "none".to_owned(),
        value => figure(value),
    };
    let row = |name: &str, of: fn(&Gains) -> f64, unit: &str| {
        let old = old.as_ref().map_or_else(dash, |old| size(of(old)));
        vec![name.to_owned(), old, size(of(&new)), unit.to_owned()]
    };
    Table::new(
        "Gains",
        Column::all(&["gain"], &["before", "new"], &["unit"]),
        vec![
            row("kp", |gains| gains.kp, "command units per rad"),
            row("kd", |gains| gains.kd, "command units per rad/s"),
            row("ki", |gains| gains.ki, "command units per rad s"),
            row("cutoff", |gains| gains.cutoff, "rad/s"),
            row("reference filter", |gains| gains.reference_filter, "s"),
            row("notch", |gains| gains.notch, "rad/s"),
            row(
                "reference model",
                |gains| gains.reference_model.map_or(0.0, |led| led.bandwidth),
                "rad/s",
            ),
        ],
    )
}

/// A row for each figure: its name, the prediction, the measurement, its unit.
fn predicted_rows(tuning: &Tuning, trial: Option<&TrialResult>) -> [Vec<String>; 12] {
    let rise = trial.and_then(|trial| Some((trial, trial.rise_time?)));
    predicted_figures(tuning).map(|(name, predicted, unit)| {
        let predicted = match (name, tuning.cap) {
            ("bandwidth", Some(cap)) => format!("{predicted} by {}", cap.name()),
            _ => predicted,
        };
        let measured = rise.and_then(|(trial, time)| match name {
            RISE_TIME => Some(1e3 * time),
            OVERSHOOT => Some(100.0 * trial.overshoot),
            _ => None,
        });
        let measured = measured.map_or_else(dash, figure);
        vec![name.to_owned(), predicted, measured, unit.to_owned()]
    })
}

/// The limits of the axis beside the largest motion.
fn limits(of: &Commissioned<'_>) -> Table {
    let limits = of.limits;
    let went = of.outcome.course.excursion();
    let range = |[low, high]: [f64; 2]| format!("{} to {}", plain(low), plain(high));
    let row = |name: &str, allowed, reached, unit: &str| {
        vec![name.to_owned(), allowed, reached, unit.to_owned()]
    };
    Table::new(
        "",
        Column::all(&["limit"], &["allowed", "reached"], &["unit"]),
        vec![
            row(
                "position",
                range(limits.travel),
                range(went.position),
                "rad",
            ),
            row("speed", plain(limits.speed), plain(went.speed), "rad/s"),
            row(
                "command",
                range(limits.command),
                range(went.command),
                "command units",
            ),
        ],
    )
}

/// The cause of a refusal, and what helps.
fn remedies(outcome: &Outcome) -> Vec<Block> {
    let Some(reason) = outcome.reason() else {
        return Vec::new();
    };
    let mut steps = vec![sentence(reason.remedy())];
    steps.extend((outcome.no_gains.as_ref()).map(|no_gains| sentence(&no_gains.to_string())));
    vec![Block::Text(sentence(reason.cause())), Block::List(steps)]
}

/// The gains in force as a table of a scenario, with the feed-forward beside them.
fn controller_of(of: &Commissioned<'_>) -> Vec<Block> {
    let (None, Some(known), Some(tuning)) =
        (of.outcome.reason(), of.outcome.servo(), &of.outcome.tuning)
    else {
        return Vec::new();
    };
    let sample_time = of.scenario.sample_time();
    let parameters = &known.parameters;
    let forces = KnownForces {
        constant: 0.0 - parameters.load / parameters.b,
        delay: known.delay,
        ..KnownForces::default()
    };
    let coefficients = FeedForward::of_servo(parameters, &forces, tuning.kd, sample_time / 2.0);
    vec![
        Block::Code {
            caption: "Controller for a scenario".to_owned(),
            text: controller(tuning, sample_time).trim_end().to_owned(),
        },
        Block::Text(sentence(&feed_forward(&coefficients))),
    ]
}
