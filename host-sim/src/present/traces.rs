//! The panels that show an experiment.

use identifier_core::parameters::{Parameter, Unknown};

use super::Envelope;
use crate::experiment::Sample;
use crate::render::chart::plot::{self, Panel};
use crate::result::Summary;

/// Standard errors to each side of an estimate that its band shows.
const BAND: f64 = 2.0;

/// The part of a run at its beginning in which an estimate may be so wild that nothing else would be
/// seen beside it.
const WILD: f64 = 0.01;

/// The estimates that have a panel, in their order.
const ESTIMATES: [(Parameter, &str); 4] = [
    (Parameter::A, "Viscous friction over inertia"),
    (Parameter::B, "Gain over inertia"),
    (Parameter::Coulomb, "Coulomb friction over inertia"),
    (Parameter::Load, "Load over inertia"),
];

/// What the panels are drawn from, gathered sample by sample in bounded memory.
#[derive(Debug, Clone, Default)]
pub struct Traces {
    estimates: [Envelope; 4],
    position: Envelope,
    model: Envelope,
    reference: Envelope,
    output_error: Envelope,
    command: Envelope,
}

impl Traces {
    /// Takes in a sample.
    pub fn add(&mut self, sample: &Sample) {
        let time = sample.time;
        for (envelope, (parameter, _)) in self.estimates.iter_mut().zip(ESTIMATES) {
            let errors = sample.standard_errors.as_ref();
            let half_width = errors.map(|errors| BAND * parameter.of(errors));
            envelope.add(time, parameter.of(&sample.estimates), half_width);
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
#[must_use]
pub fn experiment(summary: &Summary, traces: &Traces) -> Vec<Panel> {
    let mut panels: Vec<Panel> = ESTIMATES
        .into_iter()
        .zip(&traces.estimates)
        .filter(|((parameter, _), _)| summary.estimate(*parameter).is_some())
        .map(|((parameter, title), envelope)| estimate(parameter, title, summary, envelope))
        .collect();
    let mut position = signal("Position", "q [rad]", &traces.position);
    position.curves[0].name = Some("measured".to_owned());
    for (name, envelope) in [("reference", &traces.reference), ("model", &traces.model)] {
        if !envelope.is_empty() {
            position.curves.push(envelope.curve(Some(name)));
        }
    }
    panels.push(position);
    if summary.output_error.is_some() {
        panels.push(signal("Output error", "ε [rad]", &traces.output_error));
    }
    panels.push(signal("Command", "u [command units]", &traces.command));
    panels
}

fn estimate(parameter: Parameter, title: &str, summary: &Summary, envelope: &Envelope) -> Panel {
    let mut curve = envelope.curve(None);
    let banded = !curve.band.is_empty();
    curve.name = Some(match banded {
        true => format!("estimate ± {BAND} standard errors"),
        false => "estimate".to_owned(),
    });
    let scale = summary
        .estimate(parameter)
        .map(|estimate| estimate.last)
        .filter(|last| last.is_finite());
    Panel {
        title: title.to_owned(),
        abscissa: plot::TIME.to_owned(),
        logarithmic_abscissa: false,
        axis: format!(
            "{} [{}]",
            symbol(parameter),
            Unknown::from(parameter).unit()
        ),
        curves: vec![curve],
        nominal: summary
            .truth
            .map(|truth| ("true".to_owned(), parameter.of(&truth))),
        range: scale.and_then(|last| around(last, envelope)),
    }
}

/// What an estimate is called in equations.
fn symbol(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::A => "â",
        Parameter::B => "b̂",
        Parameter::Coulomb => "ĉ",
        Parameter::Load => "d̂",
    }
}

/// A range that shows the estimate's course but not a start so wild that nothing else is seen.
fn around(last: f64, envelope: &Envelope) -> Option<(f64, f64)> {
    let (low, high) = envelope.range_after(WILD)?;
    let (low, high) = (low.min(last), high.max(last));
    let room = 0.15 * (high - low).max(0.02 * last.abs());
    (room > 0.0).then_some((low - room, high + room))
}

fn signal(title: &str, axis: &str, envelope: &Envelope) -> Panel {
    Panel {
        title: title.to_owned(),
        abscissa: plot::TIME.to_owned(),
        logarithmic_abscissa: false,
        axis: axis.to_owned(),
        curves: vec![envelope.curve(None)],
        nominal: None,
        range: None,
    }
}
