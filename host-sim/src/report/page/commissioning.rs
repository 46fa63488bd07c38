//! The page of a commissioning.

use identifier_core::commission::{HoldingGains, IdentifiedServo, Limits, Phase};
use identifier_core::tuning::Tuning;

use super::unknowns::{COMMISSIONED, described};
use super::{Block, Column, Page, Section, Table, Tone, Verdict};
use crate::commission::{Outcome, StepResponse};
use crate::present::number::{
    SIDES, figure, fixed, per_cent, plain, sentence, signed, with_interval,
};
use crate::report::commission::{self as report, Traces, UNKNOWNS};
use crate::report::promise::{self, FeedForwardDocument};
use crate::scenario::Scenario;

/// What there is to be said of a commissioning.
#[derive(Debug, Clone, Copy)]
pub struct Commissioned<'a> {
    /// What was done, to what.
    pub title: &'a str,
    /// The call.
    pub command: &'a str,
    /// The scenario.
    pub scenario: &'a Scenario,
    /// What it was allowed to do.
    pub limits: &'a Limits,
    /// The gains that held the servo before, if there were any.
    pub before: Option<&'a HoldingGains>,
    /// How it went.
    pub outcome: &'a Outcome,
    /// What is shown over time.
    pub traces: &'a Traces,
}

/// The page of a commissioning.
#[must_use]
pub fn commissioning(of: &Commissioned<'_>) -> Page {
    let promised = StepResponse::promised(of.scenario, of.outcome);
    let figures = report::figures(of.limits, of.outcome, of.traces, promised.as_ref());
    let sections = [
        Section::full("What was found", found(of)),
        Section::full("Over time", vec![Block::Figures(figures)]),
        Section::full("How sure it is", how_sure(of)),
        Section::full("What it rests on", rests_on(of)),
        Section::full("What to do next", next(of)),
    ];
    Page::new(of.title, of.command, verdict(of), sections)
}

fn verdict(of: &Commissioned<'_>) -> Verdict {
    let outcome = of.outcome;
    let told = sentence(&report::verdict(of.before.is_some(), outcome));
    let phase = outcome.end.map(|end| end.phase);
    let (tone, headline) = match (phase, &outcome.tuning) {
        (Some(Phase::Applied), Some(tuning)) => {
            let rise = 1e3 * tuning.promise.rise_time;
            let measured = outcome
                .trial
                .and_then(|trial| trial.rise_time)
                .map_or_else(String::new, |time| {
                    format!(" and in {} ms as measured", figure(1e3 * time))
                });
            (
                Tone::Good,
                format!(
                    "The servo is known and tuned: a step rises in {} ms by promise{measured}.",
                    figure(rise)
                ),
            )
        }
        (Some(Phase::RolledBack), _) => (
            Tone::Doubtful,
            "No new gains: what held before holds again.".to_owned(),
        ),
        (None, _) => (Tone::Underway, "The servo is not known yet.".to_owned()),
        _ => (Tone::Failed, "No new gains: it was aborted.".to_owned()),
    };
    Verdict {
        tone,
        status: phase.map_or("unfinished", Phase::name).to_owned(),
        headline,
        detail: told,
    }
}

fn found(of: &Commissioned<'_>) -> Vec<Block> {
    let Some(known) = of.outcome.servo() else {
        let why = match of.outcome.end {
            Some(_) => "Nothing: it ended before the servo was known.",
            None => "Nothing yet: what is known is told when it ends.",
        };
        return vec![Block::Text(why.to_owned())];
    };
    let mut blocks = vec![Block::Table(servo(of.scenario, known))];
    if let Some(tuning) = &of.outcome.tuning {
        let rows = report::gain_rows(of.before, tuning);
        blocks.push(Block::Table(Table::new(
            "Gains",
            vec![
                Column::words("gain"),
                Column::figures("before"),
                Column::figures("new"),
                Column::words("unit"),
            ],
            rows.into_iter().map(Vec::from).collect(),
        )));
        let rows = report::promise_rows(known, tuning, of.outcome.trial.as_ref());
        blocks.push(Block::Table(Table::new(
            "What the new gains promise, and what the trial measured",
            vec![
                Column::words("response"),
                Column::figures("promised"),
                Column::figures("measured"),
                Column::words("unit"),
            ],
            rows.into_iter().map(Vec::from).collect(),
        )));
    }
    blocks
}

fn servo(scenario: &Scenario, known: &IdentifiedServo) -> Table {
    let values = report::values(&known.parameters, known.delay);
    let truth = report::truth(scenario);
    let rows = UNKNOWNS.iter().enumerate().map(|(i, (_, unit, place))| {
        let value = values[i];
        let half = SIDES * known.standard_error(*place);
        let (shown, interval) = with_interval(value, Some(half));
        let known_to = if half < value.abs() {
            per_cent(half / value)
        } else {
            "may be zero".to_owned()
        };
        let (actual, off) = match truth.map(|truth| truth[i]) {
            Some(0.0) => ("0".to_owned(), figure(value)),
            Some(actual) => (
                figure(actual),
                format!("{} %", signed(100.0 * (value / actual - 1.0), 2)),
            ),
            None => ("–".to_owned(), "–".to_owned()),
        };
        vec![
            described(COMMISSIONED[i]).to_owned(),
            shown,
            interval,
            (*unit).to_owned(),
            known_to,
            actual,
            off,
        ]
    });
    Table::new(
        "The servo as it was identified",
        vec![
            Column::words("what"),
            Column::figures("estimate"),
            Column::figures("±, 95 %"),
            Column::words("unit"),
            Column::figures("known to"),
            Column::figures("true"),
            Column::figures("off by"),
        ],
        rows.collect(),
    )
}

fn how_sure(of: &Commissioned<'_>) -> Vec<Block> {
    let outcome = of.outcome;
    let mut blocks = Vec::new();
    if let Some(known) = outcome.servo() {
        let encoder = of.scenario.stated.resolution / 12_f64.sqrt();
        blocks.push(Block::Text(format!(
            "Of twenty intervals of ±, nineteen hold the truth. The model leaves {} rad rms of the position \
             unexplained; the encoder's rounding alone leaves {}.",
            figure(known.unexplained),
            figure(encoder)
        )));
    }
    if outcome.tuning.is_some() {
        blocks.push(Block::Text(
            "The promise holds for the identified servo and, in margins and overshoot, for every servo that it may \
             be as well by these intervals."
                .to_owned(),
        ));
    }
    if outcome.trial.is_some() {
        blocks.push(Block::Text(
            "The trial is the proof: a step and a disturbance under the new gains, measured on the servo itself. It \
             is passed where the rise time is within 15 % of the promise and the overshoot at most three points above."
                .to_owned(),
        ));
    }
    blocks
}

fn rests_on(of: &Commissioned<'_>) -> Vec<Block> {
    let Commissioned {
        scenario,
        limits,
        outcome,
        ..
    } = of;
    let course = &outcome.course;
    let seconds = course.samples() as f64 * scenario.sample_time();
    let facts = [
        (
            "Motion",
            format!(
                "{} samples, {} s at {} Hz",
                course.samples(),
                plain(seconds),
                plain(1.0 / scenario.sample_time())
            ),
        ),
        (
            "Encoder",
            format!("{} rad a count", figure(scenario.stated.resolution)),
        ),
        (
            "Arithmetic",
            scenario.identifier.arithmetic.name().to_owned(),
        ),
    ];
    let facts = facts.map(|(name, text)| (name.to_owned(), text));
    let range = |[low, high]: [f64; 2]| format!("{} to {}", plain(low), plain(high));
    let went = &course.excursion;
    let row = |name: &str, allowed, reached, unit: &str| {
        vec![name.to_owned(), allowed, reached, unit.to_owned()]
    };
    let kept = Table::new(
        "What it was allowed to do, and what it did",
        vec![
            Column::words("limit"),
            Column::figures("allowed"),
            Column::figures("reached"),
            Column::words("unit"),
        ],
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
    );
    let phases = Table::new(
        "Phases",
        vec![
            Column::words("phase"),
            Column::figures("from [s]"),
            Column::figures("lasting [s]"),
        ],
        course
            .phases
            .iter()
            .map(|stretch| {
                vec![
                    stretch.phase.name().to_owned(),
                    fixed(stretch.begin, 3),
                    fixed(stretch.end - stretch.begin, 3),
                ]
            })
            .collect(),
    );
    vec![
        Block::Facts(facts.into()),
        Block::Table(kept),
        Block::Table(phases),
    ]
}

fn next(of: &Commissioned<'_>) -> Vec<Block> {
    if let Some(reason) = of.outcome.reason() {
        let mut steps = vec![sentence(reason.remedy())];
        if let Some(no_gains) = &of.outcome.no_gains {
            steps.push(sentence(&no_gains.to_string()));
        }
        return vec![Block::Text(sentence(reason.cause())), Block::List(steps)];
    }
    match (of.outcome.servo(), &of.outcome.tuning) {
        (Some(known), Some(tuning)) => keep(known, tuning, of.scenario),
        _ => Vec::new(),
    }
}

fn keep(known: &IdentifiedServo, tuning: &Tuning, scenario: &Scenario) -> Vec<Block> {
    let sample_time = scenario.sample_time();
    let feed_forward = FeedForwardDocument::of(known, [0.0; 2], tuning.kd, sample_time / 2.0);
    vec![
        Block::Text("The new gains hold, and nothing must be done. To keep them, write them down.".to_owned()),
        Block::Code {
            caption: "Controller, as a scenario has it".to_owned(),
            text: promise::controller(tuning, sample_time).trim_end().to_owned(),
        },
        Block::Text(sentence(&promise::feed_forward(&feed_forward))),
        Block::Text(
            "Commission again when load, supply or friction have changed: the drive starts from these gains then."
                .to_owned(),
        ),
    ]
}
