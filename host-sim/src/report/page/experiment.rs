//! The page of a run or a replay.

use identifier_core::parameters::{Parameter, Unknown};

use super::remedies::remedies;
use super::unknowns::described;
use super::{Block, Column, Page, Section, Table, Tone, Verdict, gains};
use crate::analysis::{Residual, Status};
use crate::present::number::{
    SIDES, figure, fixed, per_cent, plain, sentence, signed, with_interval,
};
use crate::present::traces::{self, Traces};
use crate::report::terms;
use crate::result::{OutputError, Summary};
use crate::scenario::Scenario;
use crate::tune::IdentifiedResult;

/// What there is to be said of an experiment.
#[derive(Debug, Clone, Copy)]
pub struct Experiment<'a> {
    /// What was done, to what.
    pub title: &'a str,
    /// The call.
    pub command: &'a str,
    /// The scenario.
    pub scenario: &'a Scenario,
    /// What came out.
    pub summary: &'a Summary,
    /// What is shown over time.
    pub traces: &'a Traces,
}

/// The page of an experiment.
#[must_use]
pub fn experiment(of: &Experiment<'_>) -> Page {
    let figures = traces::figures(of.summary, of.traces);
    let sections = [
        Section::full("What was found", found(of)),
        Section::full("Over time", vec![Block::Figures(figures)]),
        Section::full("How sure it is", how_sure(of)),
        Section::full("What it rests on", rests_on(of)),
        Section::full("What to do next", next(of)),
    ];
    Page::new(of.title, of.command, verdict(of.summary), sections)
}

fn verdict(summary: &Summary) -> Verdict {
    let known: Vec<String> = rows(summary)
        .filter_map(|row| {
            let half = row.half?;
            (half < row.value.abs())
                .then(|| format!("{} to {}", row.unknown.name(), per_cent(half / row.value)))
        })
        .collect();
    let (tone, headline) = match summary.status() {
        Status::Converged if known.is_empty() => (Tone::Good, "The servo is known.".to_owned()),
        Status::Converged => (
            Tone::Good,
            format!("The servo is known: {}.", known.join(", ")),
        ),
        Status::Unexplained => (
            Tone::Doubtful,
            "The estimates keep still, but the model lacks something that moves them.".to_owned(),
        ),
        Status::NoInformation => (
            Tone::Doubtful,
            "The motion says too little of the servo.".to_owned(),
        ),
        Status::Moving => (Tone::Doubtful, "The estimates still move.".to_owned()),
        Status::Aborted => (
            Tone::Failed,
            "It ended early: there is no result.".to_owned(),
        ),
    };
    Verdict {
        tone,
        status: summary.status().name().to_owned(),
        headline,
        detail: sentence(&summary.reason),
    }
}

/// An estimate, SI.
struct Row {
    unknown: Unknown,
    value: f64,
    /// Half of the interval that holds it; none where it is not known.
    half: Option<f64>,
    is_at_bound: bool,
    truth: Option<f64>,
    /// Since when its term has been in the model, s.
    since: Option<f64>,
}

fn rows(summary: &Summary) -> impl Iterator<Item = Row> + '_ {
    let parameters = [
        Parameter::A,
        Parameter::B,
        Parameter::Coulomb,
        Parameter::Load,
    ];
    let half = |std_error: Option<f64>| std_error.map(|error| SIDES * error);
    let parameters = parameters.into_iter().filter_map(move |parameter| {
        let estimate = summary.estimate(parameter)?;
        Some(Row {
            unknown: parameter.into(),
            value: estimate.last,
            half: half(estimate.std_error.filter(|error| error.is_finite())),
            is_at_bound: estimate.at_bound,
            truth: summary.truth.map(|truth| parameter.of(&truth)),
            since: None,
        })
    });
    let terms = summary.outcome.terms.iter().map(move |term| Row {
        unknown: term.unknown,
        value: term.value,
        half: half(Some(term.std_error).filter(|error| error.is_finite())),
        is_at_bound: false,
        truth: None,
        since: Some(term.since as f64 * summary.sample_time),
    });
    parameters.chain(terms)
}

fn found(of: &Experiment<'_>) -> Vec<Block> {
    let Experiment {
        scenario, summary, ..
    } = of;
    let has_truth = summary.truth.is_some();
    let mut columns = vec![
        Column::words("what"),
        Column::figures("estimate"),
        Column::figures("±, 95 %"),
        Column::words("unit"),
        Column::figures("known to"),
    ];
    if has_truth {
        columns.extend([Column::figures("true"), Column::figures("off by")]);
    }
    let rows: Vec<Vec<String>> = rows(summary)
        .map(|row| {
            let (value, half) = with_interval(row.value, row.half);
            let known_to = match row.half {
                _ if row.is_at_bound => "at a bound".to_owned(),
                Some(half) if half < row.value.abs() => per_cent(half / row.value),
                Some(_) => "may be zero".to_owned(),
                None => "–".to_owned(),
            };
            let meaning = described(row.unknown);
            let mut cells = vec![
                match row.since {
                    Some(since) => format!("{meaning} (since {} s)", fixed(since, 2)),
                    None => meaning.to_owned(),
                },
                value,
                half,
                row.unknown.unit().to_owned(),
                known_to,
            ];
            if has_truth {
                let truth = row
                    .truth
                    .or_else(|| Some(terms::truth(&scenario.effects, row.unknown)));
                let is_none = matches!(summary.status(), Status::NoInformation | Status::Aborted);
                cells.extend(truth.map_or([dash(), dash()], |truth| {
                    let off = if is_none && row.half.is_none() {
                        dash()
                    } else {
                        off_by(row.value, truth)
                    };
                    [figure(truth), off]
                }));
            }
            cells
        })
        .collect();
    if rows.is_empty() {
        return vec![Block::Text("There are no estimates.".to_owned())];
    }
    vec![
        Block::Text(
            "The servo is q̈ = −a q̇ + b u + d − c sign q̇, with what else entered the model."
                .to_owned(),
        ),
        Block::Table(Table::new("The servo as it was identified", columns, rows)),
    ]
}

fn off_by(value: f64, truth: f64) -> String {
    let off = value - truth;
    if !off.is_finite() {
        dash()
    } else if truth == 0.0 {
        match figure(off.abs()) {
            size if off < 0.0 => format!("−{size}"),
            size => format!("+{size}"),
        }
    } else {
        format!("{} %", signed(100.0 * off / truth, 3))
    }
}

fn how_sure(of: &Experiment<'_>) -> Vec<Block> {
    let summary = of.summary;
    let mut blocks = Vec::new();
    if rows(summary).any(|row| row.half.is_some()) {
        blocks.push(Block::Text(
            "Of twenty intervals of ±, nineteen hold the truth. They count the encoder's rounding, chance, the \
             colour of what the model leaves over, and the way that an estimate still had to go; what the model \
             lacks they do not count."
                .to_owned(),
        ));
    }
    if let Some(residual) = &summary.residual {
        blocks.push(Block::Text(left_over(residual, summary)));
    }
    for prediction in &summary.replay.predictions {
        blocks.push(Block::Text(sentence(&prediction.to_string())));
    }
    if summary.truth.is_some() {
        blocks.push(Block::Text(
            "This servo is simulated, so its truth is known and shown beside the estimates. Neither estimates \
             nor verdict make use of it."
                .to_owned(),
        ));
    }
    blocks
}

/// What the output error says of the model.
fn left_over(residual: &Residual, summary: &Summary) -> String {
    let times = residual.rms / residual.resolution_rms;
    let begin = format!(
        "Over the end of the run the model leaves {} rad rms, {} times what the encoder's resolution alone would, \
         with a correlation of {} from sample to sample: ",
        figure(residual.rms),
        fixed(times, 1),
        fixed(residual.correlation, 2)
    );
    let end = if residual.is_the_encoders() {
        "it explains all that the encoder shows.".to_owned()
    } else if let Some(finding) = &summary.cause {
        format!(
            "{} of {} {} explains {} of the rest.",
            finding.cause.meaning(),
            figure(finding.size),
            finding.unit,
            per_cent(finding.share)
        )
    } else if !residual.is_large() {
        "that is no larger than the encoder's, and nothing stands out.".to_owned()
    } else if residual.is_coloured() {
        "the model lacks something, and nothing stands out.".to_owned()
    } else {
        "that is white, as noise of the sensor is, and nothing stands out.".to_owned()
    };
    begin + &end
}

fn rests_on(of: &Experiment<'_>) -> Vec<Block> {
    let Experiment {
        scenario, summary, ..
    } = of;
    let outcome = &summary.outcome;
    let mut facts = Vec::new();
    let mut fact = |name: &str, text: String| facts.push((name.to_owned(), text));
    fact(
        "Motion",
        format!(
            "{} samples, {} s at {} Hz",
            outcome.samples,
            plain(outcome.samples as f64 * summary.sample_time),
            plain(1.0 / summary.sample_time)
        ),
    );
    fact(
        "Encoder",
        match scenario.counts_per_rev {
            Some(counts) => format!("{counts} counts a revolution"),
            None => "ideal, without counts".to_owned(),
        },
    );
    fact(
        "Method",
        format!("{}, computed in {}", summary.law, summary.arithmetic),
    );
    if let Some(OutputError { rms, max }) = summary.output_error {
        fact(
            "Output error",
            format!("{} rad rms, {} rad at most", figure(rms), figure(max)),
        );
    }
    fact(
        "Stability",
        match (outcome.certified, outcome.gain_margin) {
            (true, Some(margin)) => format!(
                "certified for the whole box of servos; the sampled loop keeps a gain margin of {}",
                figure(margin)
            ),
            (true, None) => "certified for the whole box of servos".to_owned(),
            (false, _) => "no box of servos was stated, so none is certified".to_owned(),
        },
    );
    let events = &outcome.events;
    for (count, name, meaning) in [
        (
            events.standing,
            "Standstill",
            "samples in which nothing was learnt",
        ),
        (
            events.load_steps,
            "Load steps",
            "taken over by the observer",
        ),
        (
            events.slowed,
            "Guard",
            "samples in which it shortened the law's step",
        ),
        (
            events.restarted,
            "Model",
            "restarts after errors that were too large",
        ),
        (
            events.not_following,
            "Not following",
            "samples in which the servo did not follow its command",
        ),
    ] {
        if count > 0 {
            fact(name, format!("{count} {meaning}"));
        }
    }
    for log in &summary.replay.logs {
        fact("Log", log.to_string());
    }
    if let Some(agreement) = &summary.replay.agreement {
        fact("Controller", sentence(&agreement.to_string()));
    }
    vec![Block::Facts(facts)]
}

fn next(of: &Experiment<'_>) -> Vec<Block> {
    let Experiment {
        scenario, summary, ..
    } = of;
    let steps = remedies(&summary.verdict.reason);
    if !steps.is_empty() {
        return vec![
            Block::List(steps),
            Block::Text("Gains for this result would be a guess, so none are given.".to_owned()),
        ];
    }
    let result = serde_json::to_value(summary).map_err(|error| error.to_string());
    let result =
        result.and_then(|value| IdentifiedResult::of(&value).map_err(|error| error.to_string()));
    match result {
        Ok(result) => {
            let mut blocks = gains::advice(&result, scenario);
            blocks.push(Block::Text(
                "Another response time, or less noise: the verb tune, with what --json wrote of this result."
                    .to_owned(),
            ));
            blocks
        }
        Err(why) => vec![Block::Text(sentence(&format!("there are no gains: {why}")))],
    }
}

fn dash() -> String {
    "–".to_owned()
}
