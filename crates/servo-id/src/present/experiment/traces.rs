//! The course of an experiment, gathered sample by sample, and its figures.

use identifier_core::parameters::{Parameter, Unknown};
use identifier_log::MotionUnit;
use identifier_log::analysis::{Braking, FoundResponse, Seen};
use identifier_log::experiment::Sample;
use identifier_log::result::Summary;
use identifier_log::verdict::State;

use crate::present::estimates::Estimated;
use crate::present::number::{capitalised, rough};
use crate::present::{Envelope, Figure, TIME, Trace};

/// Half-width of an estimate's band, standard errors.
const BAND_STANDARD_ERRORS: f64 = 2.0;

/// The initial part of a run in which an estimate may be so far off that nothing else would be visible beside it.
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
    fn positions(&self, unit: MotionUnit) -> Figure {
        let position = [
            ("measured", &self.position),
            ("model", &self.model),
            ("reference", &self.reference),
        ];
        signal("Position", &axis("q", unit.name()), &position)
    }

    fn commands(&self) -> Figure {
        signal(
            "Command",
            "u [command units]",
            &[("command", &self.command)],
        )
    }

    /// Takes in a sample.
    pub fn add(&mut self, sample: &Sample) {
        let time = sample.time;
        for (envelope, parameter) in self.estimates.iter_mut().zip(Parameter::ALL) {
            let errors = sample.standard_errors.as_ref();
            let half_width = errors.map(|errors| BAND_STANDARD_ERRORS * errors.get(parameter));
            envelope.add(time, sample.estimates.get(parameter), half_width);
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

/// The figures of a fit. Other estimators show the estimates with their confidence bands, then position, output error
/// and command.
pub(super) fn figures(
    summary: &Summary,
    traces: &ExperimentTraces,
    seen: Option<&Seen>,
) -> Vec<Figure> {
    let unit = summary.position_unit;
    if summary.fit.is_some() {
        let mut figures = seen.map_or_else(
            || vec![traces.positions(unit), traces.commands()],
            |seen| fitted(traces, seen, unit),
        );
        figures.extend(over_time_scale(summary));
        return figures;
    }
    let mut figures: Vec<Figure> = Parameter::ALL
        .into_iter()
        .zip(&traces.estimates)
        .filter(|(parameter, _)| summary.estimate(*parameter).is_some())
        .map(|(parameter, envelope)| estimate(parameter, summary, envelope))
        .collect();
    figures.push(traces.positions(unit));
    let error = [("output error", &traces.output_error)];
    if summary.output_error.is_some() {
        figures.push(signal("Output error", &axis("ε", unit.name()), &error).with_settled_part());
    }
    figures.push(traces.commands());
    figures
}

/// A log beside the model that was fitted to it: over time, over the velocity and over the frequency.
fn fitted(traces: &ExperimentTraces, seen: &Seen, unit: MotionUnit) -> Vec<Figure> {
    const FREQUENCY: &str = "ω [rad/s]";
    let mut figures = vec![traces.positions(unit)];
    if let Some(ran) = &seen.free_run {
        figures[0].title = format!(
            "Position; open-loop simulation over {} s",
            rough(ran.window)
        );
        let (unit, size) = (seen.count).map_or((unit.name(), 1.0), |count| ("counts", count));
        let mut residual = signal("Residual", unit, &[("residual", &traces.output_error)]);
        for point in residual.traces.iter_mut().flat_map(|of| &mut of.points) {
            point.1 /= size;
        }
        figures.push(residual);
    }
    let braking = |of: &dyn Fn(&Braking) -> f64| {
        seen.friction
            .iter()
            .map(|one| (one.velocity, of(one)))
            .collect()
    };
    let measured = Trace {
        band: seen
            .friction
            .iter()
            .map(|one| BAND_STANDARD_ERRORS * one.deviation)
            .collect(),
        ..Trace::new("measured, 95 %", braking(&|one| one.measured))
    };
    let friction = vec![Trace::new("model", braking(&|one| one.model)), measured];
    let response = |of: &dyn Fn(&FoundResponse) -> f64| {
        let points = seen.response.iter().map(|one| (one.frequency, of(one)));
        points.filter(|(_, value)| value.is_finite()).collect()
    };
    let decibels = |gain: f64| 20.0 * gain.log10();
    let gains = vec![
        Trace::new("model", response(&|one| decibels(one.model))),
        Trace::new("measured", response(&|one| decibels(one.measured))),
    ];
    let coherence = vec![Trace::new("coherence", response(&|one| one.coherence))];
    let over_frequency = |title: &str, vertical: &str, traces| {
        let mut figure = Figure::new(title, FREQUENCY, vertical, traces);
        figure.horizontal.is_logarithmic = true;
        figure
    };
    figures.push(traces.commands());
    figures.push(Figure::new(
        "Friction over inertia",
        &axis("q̇", &format!("{}/s", unit.name())),
        unit.of(Unknown::Coulomb),
        friction,
    ));
    if !seen.response.is_empty() {
        figures.push(over_frequency("Velocity by command", "dB", gains));
        let source = match seen.has_reference {
            true => "reference",
            false => "command",
        };
        let coherence = over_frequency(
            &format!("Part of the velocity that follows the {source}"),
            "coherence",
            coherence,
        );
        figures.push(coherence.within(Some([0.0, 1.05])));
    }
    figures
}

/// b at every time scale beside the result. One inertia has the same at all of them.
fn over_time_scale(summary: &Summary) -> Option<Figure> {
    /// The least part of the acceleration that a scale explains for its b to be drawn.
    const EXPLAINED: f64 = 0.5;
    let drawn = || (summary.scales.iter()).filter(|scale| scale.explained > EXPLAINED);
    let points: Vec<_> = drawn().map(|scale| (scale.time, scale.b)).collect();
    let ends = [points.first()?.0, points.last()?.0];
    let mut traces = vec![Trace {
        band: drawn()
            .map(|scale| BAND_STANDARD_ERRORS * scale.std_error)
            .collect(),
        ..Trace::new("b of the equation of motion, 95 %", points)
    }];
    let own = &summary.estimates.b;
    if own.state != State::Unknown {
        let line = ends.map(|time| (time, own.value));
        traces.push(Trace::new("result", line.to_vec()));
    }
    let unit = summary.position_unit.of(Unknown::B);
    let mut figure = Figure::new("b by time scale", "window [s]", unit, traces);
    figure.horizontal.is_logarithmic = true;
    Some(figure)
}

/// How well the estimates are known, beside their values.
pub(super) fn how_well_known(rows: &[Estimated]) -> Option<Figure> {
    /// Half of the width of a bar, and of its edges.
    const WIDTH: f64 = 0.35;
    const EDGE: f64 = 1e-6;
    let known = rows.iter().filter_map(|row| {
        let part = 200.0 * row.std_error? / row.value?.abs();
        (part < 100.0).then(|| (row.unknown.name().to_owned(), part))
    });
    let (names, parts): (Vec<String>, Vec<f64>) = known.unzip();
    let most = parts.iter().copied().reduce(f64::max)?;
    // One trace, whose band has the width zero between the bars.
    let bars = parts.iter().zip(1_i32..).flat_map(|(&part, place)| {
        let ends = [-0.5, -WIDTH - EDGE, -WIDTH, WIDTH, WIDTH + EDGE, 0.5 - EDGE];
        let widths = [0.0, 0.0, part, part, 0.0, 0.0];
        let place = f64::from(place);
        std::iter::zip(ends, widths).map(move |(at, width)| ((place + at, 0.0), width))
    });
    let (points, band) = bars.unzip();
    let trace = Trace {
        band,
        ..Trace::new("its value, 95 %", points)
    };
    let mut figure = Figure::new("95 % interval", "", "% of its value", vec![trace]);
    figure.horizontal.names = names;
    Some(figure.within(Some([-1.2 * most, 1.2 * most])))
}

fn estimate(parameter: Parameter, summary: &Summary, envelope: &Envelope) -> Figure {
    let mut trace = envelope.trace("estimate");
    if !trace.band.is_empty() {
        trace.name = "estimate, 95 %".to_owned();
    }
    let unknown = Unknown::from(parameter);
    let title = capitalised(unknown.meaning());
    let axis = axis(symbol(parameter), summary.position_unit.of(unknown));
    let last = summary.estimate(parameter).map(|estimate| estimate.last);
    let last = last.filter(|last| last.is_finite());
    let figure = Figure::new(&title, TIME, &axis, vec![trace])
        .within(last.and_then(|last| around(last, envelope)));
    let figure = match summary.truth {
        Some(truth) => figure.with_level("true", truth.get(parameter)),
        None => figure,
    };
    figure.with_settled_part()
}

/// The name of an axis.
fn axis(symbol: &str, unit: &str) -> String {
    format!("{symbol} [{unit}]")
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
