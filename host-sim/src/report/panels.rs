//! The panels that show an experiment.

use identifier_core::model::ServoParameters;
use identifier_core::parameters::Parameter;

use super::plot::{self, Curve, Panel};
use super::{Summary, unit};
use crate::experiment::Sample;

/// Standard errors to each side of an estimate that its band shows.
const BAND: f64 = 2.0;

/// Estimates with their confidence bands, then position, output error and command.
#[must_use]
pub fn experiment(summary: &Summary, trace: &[Sample]) -> Vec<Panel> {
    let mut panels: Vec<Panel> = [
        (Parameter::A, "Viscous friction over inertia"),
        (Parameter::B, "Gain over inertia"),
        (Parameter::Coulomb, "Coulomb friction over inertia"),
        (Parameter::Load, "Load over inertia"),
    ]
    .into_iter()
    .filter(|(parameter, _)| summary.estimate(*parameter).is_some())
    .map(|(parameter, title)| estimate(parameter, title, summary, trace))
    .collect();
    let mut position = signal("Position", "q [rad]", trace, |s| Some(s.position));
    position.curves[0].name = Some("measured".to_owned());
    let follow = |name: &str, value: &dyn Fn(&Sample) -> Option<f64>| Curve {
        name: Some(name.to_owned()),
        ..curve(trace, value)
    };
    if summary.output_error.is_some() {
        let model = |s: &Sample| Some(s.position - s.output_error?);
        position.curves.push(follow("model", &model));
    }
    if trace.iter().any(|s| s.reference.is_finite()) {
        position
            .curves
            .push(follow("reference", &|s| Some(s.reference)));
    }
    panels.push(position);
    if summary.output_error.is_some() {
        panels.push(signal("Output error", "ε [rad]", trace, |s| {
            s.output_error
        }));
    }
    panels.push(signal("Command", "u [command units]", trace, |s| {
        Some(s.command)
    }));
    panels
}

fn estimate(parameter: Parameter, title: &str, summary: &Summary, trace: &[Sample]) -> Panel {
    let mut curve = curve(trace, &|s| Some(parameter.of(&s.estimates)));
    let half_width = |errors: ServoParameters| BAND * parameter.of(&errors);
    curve.band = trace
        .iter()
        .filter_map(|s| s.standard_errors.map(half_width))
        .collect();
    let scale = summary
        .estimate(parameter)
        .map(|estimate| estimate.last)
        .filter(|last| last.is_finite());
    Panel {
        title: title.to_owned(),
        abscissa: plot::TIME.to_owned(),
        logarithmic: false,
        axis: format!("{} [{}]", parameter.name(), unit(parameter)),
        curves: vec![curve],
        nominal: summary
            .truth
            .map(|truth| ("true".to_owned(), parameter.of(&truth))),
        range: scale.and_then(|last| around(last, trace, parameter)),
    }
}

/// A range that shows the estimate's course but not a start so wild that nothing else is seen.
fn around(last: f64, trace: &[Sample], parameter: Parameter) -> Option<(f64, f64)> {
    let settled = &trace[trace.len() / 100..];
    let values = settled
        .iter()
        .map(|s| parameter.of(&s.estimates))
        .filter(|value| value.is_finite());
    let (low, high) = values.fold((last, last), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let room = 0.15 * (high - low).max(0.02 * last.abs());
    (room > 0.0).then_some((low - room, high + room))
}

fn signal(
    title: &str,
    axis: &str,
    trace: &[Sample],
    value: impl Fn(&Sample) -> Option<f64>,
) -> Panel {
    Panel {
        title: title.to_owned(),
        abscissa: plot::TIME.to_owned(),
        logarithmic: false,
        axis: axis.to_owned(),
        curves: vec![curve(trace, &value)],
        nominal: None,
        range: None,
    }
}

fn curve(trace: &[Sample], value: &dyn Fn(&Sample) -> Option<f64>) -> Curve {
    Curve {
        name: None,
        points: trace
            .iter()
            .filter_map(|sample| Some((sample.time, value(sample)?)))
            .filter(|(_, value)| value.is_finite())
            .collect(),
        band: Vec::new(),
    }
}
