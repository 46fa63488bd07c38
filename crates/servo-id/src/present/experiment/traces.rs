//! The course of an experiment, gathered sample by sample, and its figures.

use host_sim::experiment::Sample;
use host_sim::result::Summary;
use identifier_core::parameters::{Parameter, Unknown};

use crate::present::number::capitalised;
use crate::present::{Envelope, Figure, TIME};

/// Half-width of an estimate's band, standard errors.
const BAND_STANDARD_ERRORS: f64 = 2.0;

/// The part of a run at its beginning in which an estimate may be so far off that nothing else would be
/// seen beside it.
const TRANSIENT_PART: f64 = 0.01;

/// The course of an experiment in bounded memory.
#[derive(Debug, Clone, Default)]
pub struct ExperimentTraces {
    estimates: [Envelope; 4],
    position: Envelope,
    model: Envelope,
    reference: Envelope,
    output_error: Envelope,
    command: Envelope,
}

impl ExperimentTraces {
    /// Takes in a sample.
    pub fn add(&mut self, sample: &Sample) {
        let time = sample.time;
        for (envelope, parameter) in self.estimates.iter_mut().zip(Parameter::ALL) {
            let errors = sample.standard_errors.as_ref();
            let half_width = errors.map(|errors| BAND_STANDARD_ERRORS * parameter.value_in(errors));
            envelope.add(time, parameter.value_in(&sample.estimates), half_width);
        }
        self.position.add(time, sample.position, None);
        self.reference.add(time, sample.reference, None);
        if let Some(error) = sample.output_error {
            self.model.add(time, sample.position - error, None);
            self.output_error.add(time, error, None);
        }
        self.command.add(time, sample.command, None);
    }
}

/// Estimates with their confidence bands, then position, output error and command.
pub(super) fn figures(summary: &Summary, traces: &ExperimentTraces) -> Vec<Figure> {
    let mut figures: Vec<Figure> = Parameter::ALL
        .into_iter()
        .zip(&traces.estimates)
        .filter(|(parameter, _)| summary.estimate(*parameter).is_some())
        .map(|(parameter, envelope)| estimate(parameter, summary, envelope))
        .collect();
    let position = [
        ("measured", &traces.position),
        ("reference", &traces.reference),
        ("model", &traces.model),
    ];
    figures.push(signal("Position", "q [rad]", &position));
    let error = [("output error", &traces.output_error)];
    if summary.output_error.is_some() {
        figures.push(signal("Output error", "ε [rad]", &error).with_settled_part());
    }
    let command = [("command", &traces.command)];
    figures.push(signal("Command", "u [command units]", &command));
    figures
}

fn estimate(parameter: Parameter, summary: &Summary, envelope: &Envelope) -> Figure {
    let mut trace = envelope.trace("estimate");
    if !trace.band.is_empty() {
        trace.name = format!("estimate ± {BAND_STANDARD_ERRORS} standard errors");
    }
    let unknown = Unknown::from(parameter);
    let title = capitalised(unknown.meaning());
    let axis = format!("{} [{}]", symbol(parameter), unknown.unit());
    let last = summary.estimate(parameter).map(|estimate| estimate.last);
    let last = last.filter(|last| last.is_finite());
    let figure = Figure::new(&title, TIME, &axis, vec![trace])
        .within(last.and_then(|last| around(last, envelope)));
    let figure = match summary.truth {
        Some(truth) => figure.with_level("true", parameter.value_in(&truth)),
        None => figure,
    };
    figure.with_settled_part()
}

/// Symbol of an estimate.
fn symbol(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::A => "â",
        Parameter::B => "b̂",
        Parameter::Coulomb => "ĉ",
        Parameter::Load => "d̂",
    }
}

/// A range that shows the estimate's course, but not a start so far off that nothing else is seen.
fn around(last: f64, envelope: &Envelope) -> Option<[f64; 2]> {
    let (low, high) = envelope.range_after(TRANSIENT_PART)?;
    let (low, high) = (low.min(last), high.max(last));
    let room = 0.15 * (high - low).max(0.02 * last.abs());
    (room > 0.0).then_some([low - room, high + room])
}

fn signal(title: &str, axis: &str, envelopes: &[(&str, &Envelope)]) -> Figure {
    let known = envelopes
        .iter()
        .filter(|(_, envelope)| !envelope.is_empty());
    let traces = known.map(|(name, envelope)| envelope.trace(name));
    Figure::new(title, TIME, axis, traces.collect())
}
