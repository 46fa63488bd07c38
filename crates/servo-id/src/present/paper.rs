//! The paper's experiment.

use identifier_core::parameters::Parameter;
use identifier_log::experiment::Sample;
use identifier_log::result::Summary;

use super::estimates::{dash, settled};
use super::number::{rough, signed, with_error};
use super::{Block, Column, Envelope, Figure, Page, Section, TIME, Table, Tone, Verdict};
use crate::paper::{self, Case, Method, Run};

/// The page of the paper's experiment.
#[must_use]
pub fn paper(title: &str, command: &str, runs: &[Run; 4]) -> Page {
    let duration = paper::scenario(Method::Proposed, Case::Balanced).duration;
    let nominal = format!(
        "Nominal: a = {} 1/s, b = {} rad/s² per command unit. ±: the 95 % interval.\nWander: standard deviation over \
         the last quarter of {duration} s. Settled: time from which\non â stays within ±0.1 1/s and b̂ within 2 % of \
         nominal.\n",
        paper::NOMINAL_A,
        paper::NOMINAL_B,
    );
    let blocks = vec![
        Block::Table(estimates(runs)),
        Block::Text(nominal),
        Block::Text(under_load(runs)),
    ];
    let verdict = Verdict {
        tone: Tone::Good,
        status: "done".to_owned(),
        headline: "The paper's experiment was repeated.".to_owned(),
        detail: "four runs".to_owned(),
    };
    let sections = [
        Section::brief("Result", blocks),
        Section::full("Over time", vec![Block::Figures(figures(runs))]),
    ];
    Page::new(title, command, verdict, sections)
}

/// A row for each run.
fn estimates(runs: &[Run; 4]) -> Table {
    let columns = vec![
        Column::words("experiment"),
        Column::figures("â [1/s]"),
        Column::figures("wander of â").drop_order(2),
        Column::figures("â − a").drop_order(5),
        Column::figures("b̂ [rad/s²/u]"),
        Column::figures("wander of b̂").drop_order(0),
        Column::figures("b̂/b − 1").drop_order(3),
        Column::figures("d̂ [rad/s²]").drop_order(1),
        Column::figures("settled a, b [s]").drop_order(4),
        Column::words("status"),
    ];
    let row = |run: &Run| {
        let summary = &run.summary;
        let (a, b) = (&summary.estimates.a, &summary.estimates.b);
        vec![
            run.name(),
            estimate(summary, Parameter::A),
            rough(a.tail_std),
            signed(a.value - paper::NOMINAL_A, 4),
            estimate(summary, Parameter::B),
            rough(b.tail_std),
            format!(
                "{} %",
                signed(100.0 * (b.value / paper::NOMINAL_B - 1.0), 3)
            ),
            estimate(summary, Parameter::Load),
            format!(
                "{}, {}",
                settled(summary.settling_time.a),
                settled(summary.settling_time.b)
            ),
            summary.status().name().to_owned(),
        ]
    };
    Table::new("", columns, runs.iter().map(row).collect())
}

fn estimate(summary: &Summary, parameter: Parameter) -> String {
    let estimate = summary.estimate(parameter);
    estimate.map_or_else(dash, |estimate| {
        with_error(estimate.value, estimate.std_error)
    })
}

/// The effect of the load on either method.
fn under_load(runs: &[Run; 4]) -> String {
    let [
        proposed,
        least_squares,
        proposed_loaded,
        least_squares_loaded,
    ] = runs;
    let mut text = format!("Effect of the load of {} rad/s²:", paper::UNBALANCE);
    for (name, without, with) in [
        ("proposed", proposed, proposed_loaded),
        ("least squares", least_squares, least_squares_loaded),
    ] {
        let (without, with) = (&without.summary.estimates, &with.summary.estimates);
        text += &format!(
            "\n  {name:<14} b̂ moves by {} %, its wander from {} to {}; that of â from {} to {}",
            signed(100.0 * (with.b.value / without.b.value - 1.0), 3),
            rough(without.b.tail_std),
            rough(with.b.tail_std),
            rough(without.a.tail_std),
            rough(with.a.tail_std),
        );
    }
    text
}

/// The eight panels of Fig. 03 in the paper's order. 1–2 are proposed and 3–4 least squares without load, 5–6 and 7–8
/// with it. Odd panels are â, even panels b̂, each kind on one scale.
fn figures(runs: &[Run; 4]) -> Vec<Figure> {
    /// Scales that the panels share, around the nominal values.
    const SCALE_A: [f64; 2] = [-0.3, 1.0];
    const SCALE_B: [f64; 2] = [0.0, 400.0];

    let mut figures = Vec::new();
    for run in runs {
        let number = figures.len() + 1;
        let figure = |number, axis: &str, nominal, range, value: fn(&Sample) -> f64| {
            let points = run.trace.iter().map(|sample| (sample.time, value(sample)));
            let trace = points.collect::<Envelope>().trace("estimate");
            Figure::new(
                &format!("({number}) {}", run.name()),
                TIME,
                axis,
                vec![trace],
            )
            .within(Some(range))
            .with_level("nominal", nominal)
            .with_settled_part()
        };
        figures.push(figure(number, "â [1/s]", paper::NOMINAL_A, SCALE_A, |s| {
            s.estimates.a
        }));
        figures.push(figure(
            number + 1,
            "b̂ [rad/s² per command unit]",
            paper::NOMINAL_B,
            SCALE_B,
            |s| s.estimates.b,
        ));
    }
    figures
}
