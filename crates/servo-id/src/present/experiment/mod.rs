//! The page of a run or a replay.

use host_sim::scenario::Scenario;
use identifier_core::parameters::{Parameter, Unknown};
use identifier_log::MotionUnit;
use identifier_log::analysis::Seen;
use identifier_log::result::{BrakingForce, FitNotes, SensorNoise, Summary};
use identifier_log::tune::Tuned;
use identifier_log::verdict::{Residual, State, Status};

mod traces;

pub use traces::ExperimentTraces;

use super::estimates::{self, Estimated};
use super::log::Sentence;
use super::number::{figure, fixed, known_to, per_cent, plain, rough, sentence, with_error};
use super::remedies::remedies;
use super::tuning::{self, advice};
use super::{Block, Figure, Page, Section, Tone, Verdict, physical};

/// A run or a replay.
#[derive(Debug, Clone, Copy)]
pub struct Experiment<'a> {
    /// The experiment and its object.
    pub title: &'a str,
    /// The command line.
    pub command: &'a str,
    /// The scenario.
    pub scenario: &'a Scenario,
    /// The result.
    pub summary: &'a Summary,
    /// Signals over time; none for a page whose brief form is enough.
    pub traces: Option<&'a ExperimentTraces>,
    /// The samples beside a model that was fitted to all of them.
    pub seen: Option<&'a Seen>,
}

/// The page of an experiment.
#[must_use]
pub fn experiment(of: &Experiment<'_>) -> Page {
    let rows = rows(of);
    let mut sections = vec![
        Section::brief("The logs", logs(of.summary)),
        Section::brief("Result", found(of, &rows)),
    ];
    let steps = remedies(of.summary);
    if let Some(traces) = of.traces {
        let heading = match of.summary.fit {
            Some(_) => "Plots",
            None => "Over time",
        };
        let mut figures = traces::figures(of.summary, traces, of.seen);
        let gains = steps.is_empty().then(|| gains(of));
        if of.seen.is_some() {
            figures.extend(traces::how_well_known(&rows));
            figures.extend(gains.iter().flat_map(|(_, figures)| figures.clone()));
        }
        sections.push(Section::full(heading, vec![Block::Figures(figures)]));
        sections.extend(gains.map(|(blocks, _)| Section::full("Gains", blocks)));
    }
    if !steps.is_empty() {
        let why = match of.summary.status() {
            Status::Partial if of.summary.estimates.b.state == State::Rough => {
                "The verb tune computes gains for all of the interval of b."
            }
            Status::Partial => {
                "The verb tune computes gains if two standard errors of b are within 8 %."
            }
            _ => "No gains: for this result they would be a guess.",
        };
        let steps = vec![Block::List(steps), Block::Text(why.to_owned())];
        sections.push(Section::brief("Remedies", steps));
    }
    Page::new(of.title, of.command, verdict(of.summary, &rows), sections)
}

fn verdict(summary: &Summary, rows: &[Estimated]) -> Verdict {
    let known: Vec<String> = rows
        .iter()
        .filter(|row| row.is_sure())
        .filter_map(|row| Some((row.unknown.name(), known_to(row.value?, row.std_error))))
        .filter(|(_, part)| part.ends_with('%'))
        .map(|(name, part)| format!("{name} to {part}"))
        .collect();
    let headline = match summary.status() {
        Status::Converged if known.is_empty() => "The servo is identified.".to_owned(),
        Status::Converged => format!("The servo is identified: {}.", known.join(", ")),
        Status::Partial if summary.estimates.b.state == State::Rough => {
            "A rough answer: the exact fit has none.".to_owned()
        }
        Status::Partial => format!(
            "Within tolerance: {}. This motion does not determine the rest.",
            known.join(", ")
        ),
        Status::Unexplained => {
            "The estimates have settled, but the model lacks an effect that shifts them.".to_owned()
        }
        Status::NoInformation => {
            "The motion contains too little information about the servo.".to_owned()
        }
        Status::Moving => "The estimates have not settled yet.".to_owned(),
        Status::Aborted => "The run ended early: there is no result.".to_owned(),
    };
    Verdict {
        tone: Tone::from(summary.status()),
        status: summary.status().name().to_owned(),
        headline,
        detail: summary.reason.clone(),
    }
}

/// The estimates, then the optional terms that have entered.
fn rows(of: &Experiment<'_>) -> Vec<Estimated> {
    let summary = of.summary;
    let has_none = matches!(summary.status(), Status::NoInformation | Status::Aborted);
    let is_fit = summary.fit.is_some();
    let parameters = Parameter::ALL.into_iter().filter_map(|parameter| {
        let estimate = summary.estimate(parameter)?;
        // One that never left its first value was not found.
        let is_known = estimate.value.is_finite()
            && estimate.std_error.is_none_or(f64::is_finite)
            && match is_fit {
                true => estimate.state != State::Unknown,
                false => !(has_none && estimate.tail_std <= 0.0),
            };
        let settled = match parameter {
            Parameter::A => Some(summary.settling_time.a),
            Parameter::B => Some(summary.settling_time.b),
            _ => None,
        };
        let mut row = Estimated::new(parameter.into(), estimate.value, estimate.std_error);
        row.unit = estimate.unit;
        row.value = is_known.then_some(estimate.value);
        row.is_at_bound = estimate.at_bound;
        // One fit to the whole record does not wander.
        row.wander = (is_known && summary.fit.is_none()).then_some(estimate.tail_std);
        row.truth = summary.truth.map(|truth| truth.get(parameter));
        row.settled = settled.filter(|_| summary.truth.is_some() && summary.fit.is_none());
        Some(row)
    });
    let truth = summary.truth.map(|_| &of.scenario.effects);
    let sizes = summary.estimates.terms.iter().map(|term| Estimated {
        truth: truth.map(|effects| effects.size_of(term.unknown)),
        unit: term.unit,
        since: Some(term.since).filter(|_| summary.fit.is_none()),
        ..Estimated::new(term.unknown, term.value, Some(term.std_error))
    });
    parameters.chain(sizes).collect()
}

/// True for a log of velocities, which has no encoder.
fn is_velocity(scenario: &Scenario) -> bool {
    (scenario.log.as_ref()).is_some_and(|log| log.is_velocity)
}

fn logs(summary: &Summary) -> Vec<Block> {
    let notes = &summary.replay;
    let logs = notes.logs.iter();
    let logs = logs.map(|log| Block::Text(Sentence(log).to_string()));
    let agreement = notes.agreement.map(|agreement| match agreement.holds {
        true => Block::Text(sentence(&agreement.to_string())),
        false => Block::Warning(agreement.to_string()),
    });
    logs.chain(agreement).collect()
}

fn found(of: &Experiment<'_>, rows: &[Estimated]) -> Vec<Block> {
    let (summary, unit) = (of.summary, of.summary.position_unit);
    let mut blocks = if rows.is_empty() {
        vec![Block::text("There are no estimates.")]
    } else {
        vec![Block::Table(estimates::table(rows))]
    };
    blocks.extend(physical::tables(summary));
    let entered = summary.terms_entered.iter();
    let without_size = entered.filter(|(term, _)| {
        let mut sizes = rows.iter();
        !sizes.any(|row| row.unknown.term() == Some(*term))
    });
    blocks.extend(without_size.map(|(term, since)| {
        let since = fixed(*since, 2);
        Block::Text(format!(
            "The term {} is in the model since {since} s.",
            term.name()
        ))
    }));
    blocks.extend(
        sensor_noise(&summary.noise, unit)
            .filter(|_| !is_velocity(of.scenario))
            .map(|noise| Block::Text(format!("Encoder noise, standard deviation: {noise}."))),
    );
    // The model of a fit without a result shows nothing about the log.
    if let Some(fit) = summary
        .fit
        .as_ref()
        .filter(|_| !summary.verdict.hides_all())
    {
        blocks.extend(fit_notes(fit, unit));
    }
    blocks.extend(
        of.seen
            .map(|seen| Block::Text(left_by_fit(seen, unit.name()))),
    );
    if let Some(residual) = &summary.residual {
        blocks.push(Block::Text(left_over(residual, summary)));
    }
    let predictions = summary.replay.predictions.iter();
    blocks.extend(
        predictions.map(|prediction| Block::Text(sentence(&Sentence(prediction).to_string()))),
    );
    blocks
}

/// The clock of the command, and the effects that a fit needed.
fn fit_notes(fit: &FitNotes, unit: MotionUnit) -> Vec<Block> {
    let mut lines = Vec::new();
    if let Some(late) = fit.command_recorded_late {
        lines.push(format!(
            "The command was recorded {} samples late; the estimates take this into account.",
            fixed(late, 2)
        ));
    }
    if let Some(between) = fit.command_between_rows {
        lines.push(format!(
            "The loop is faster than the log: its command is {between}, and runs on smoothly between the rows."
        ));
    }
    if let Some(BrakingForce { value, std_error }) = fit.braking {
        lines.push(format!(
            "Friction and load together brake the motion with {} {}.",
            with_error(value, Some(std_error)),
            unit.of(Unknown::Coulomb)
        ));
    }
    for effect in &fit.effects {
        let sizes: Vec<String> = (effect.sizes.iter())
            .map(|(name, value)| format!("{name} {}", plain(*value)))
            .collect();
        let sizes = match sizes.as_slice() {
            [] => String::new(),
            sizes => format!(" ({})", sizes.join(", ")),
        };
        lines.push(match effect.or {
            None => format!("The log shows {}{sizes}.", effect.meaning),
            Some(other) => format!(
                "The log shows {}{sizes}, or {other}, which explains it nearly as well.",
                effect.meaning
            ),
        });
    }
    lines.into_iter().map(Block::Text).collect()
}

/// The residuals of a fitted model over its log.
fn left_by_fit(seen: &Seen, unit: &str) -> String {
    let sized = |error: f64| match seen.count {
        Some(count) => format!("{} counts", rough(error / count)),
        None => format!("{} {unit}", rough(error)),
    };
    let ahead = match &seen.free_run {
        Some(ran) => format!(
            "{} s ahead, by the command alone, {} rms",
            rough(ran.window),
            sized(ran.deviation)
        ),
        None => {
            "where it starts is never known well enough to run it by the command alone".to_owned()
        }
    };
    format!(
        "Model beside the log: {} rms off from one sample to the next, autocorrelation {}; {ahead}.",
        sized(seen.innovation),
        fixed(seen.correlation, 2)
    )
}

/// The remaining output error, beside that of the encoder.
fn left_over(residual: &Residual, summary: &Summary) -> String {
    let times = residual.rms / residual.resolution_rms;
    let begin = format!(
        "Residual: {} {} rms, {} times quantisation, autocorrelation {}: ",
        figure(residual.rms),
        summary.position_unit.name(),
        fixed(times, 1),
        fixed(residual.correlation, 2)
    );
    let end = if residual.is_the_encoders() {
        "the model explains all that the encoder shows.".to_owned()
    } else if let Some(finding) = &summary.cause {
        format!(
            "{} of {} {} explains {} of it.",
            finding.cause.meaning(),
            figure(finding.size),
            finding.unit,
            per_cent(finding.share)
        )
    } else if !residual.is_large() {
        "no larger than the encoder's noise; no single effect explains it.".to_owned()
    } else if residual.is_autocorrelated() {
        "the model lacks something, and no single effect explains it.".to_owned()
    } else {
        "white like sensor noise; no single effect explains it.".to_owned()
    };
    begin + &end
}

/// Gains for the servo that was found, and their predicted response as figures.
fn gains(of: &Experiment<'_>) -> (Vec<Block>, Vec<Figure>) {
    match Tuned::stiffest(of.scenario, of.summary) {
        Ok((tuned, known)) => {
            let blocks = advice(&tuned, &known);
            (blocks, tuning::figures(&tuned).unwrap_or_default())
        }
        Err(why) => {
            let why = sentence(&format!("there are no gains: {why}"));
            (vec![Block::Text(why)], Vec::new())
        }
    }
}

/// The noise in motion and at standstill, standard deviations; none where neither is known.
fn sensor_noise(noise: &SensorNoise, unit: MotionUnit) -> Option<String> {
    let parts = [
        (noise.moving_counts.zip(noise.moving), "in motion"),
        (
            noise.standstill_counts.zip(noise.standstill),
            "at standstill",
        ),
    ];
    let known = parts.into_iter().filter_map(|(noise, when)| {
        let (counts, size) = noise?;
        Some(format!(
            "{} counts ({} {}) {when}",
            fixed(counts, 2),
            figure(size),
            unit.name()
        ))
    });
    let known: Vec<String> = known.collect();
    (!known.is_empty()).then(|| known.join(", "))
}
