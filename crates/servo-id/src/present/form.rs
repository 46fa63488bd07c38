//! Gains in the form of a drive's firmware.

use std::f64::consts::TAU;

use host_sim::result::{FormResult, FormStep};
use identifier_core::tuning::TuningSettings;

use super::number::{figure, sentence};
use super::{Block, Column, Figure, TIME, Table, Trace};

/// The parameters, what their loop does, remarks on its speed, and what to mind.
pub(super) fn form(of: &FormResult, speed: &[String]) -> Vec<Block> {
    let columns = vec![
        Column::words("parameter"),
        Column::figures("value"),
        Column::words("unit"),
    ];
    let parameters = of.parameters.iter();
    let rows = parameters.map(|parameter| {
        // As it is stored, with every digit.
        let value = parameter.value.to_string();
        vec![parameter.name.to_owned(), value, parameter.unit.clone()]
    });
    vec![
        Block::Text(format!("{}.", of.firmware)),
        Block::Table(Table::new("", columns, rows.collect())),
        Block::Table(loop_of(of)),
        Block::List(
            speed
                .iter()
                .map(|remark| sentence(remark))
                .chain(of.remarks.clone())
                .collect(),
        ),
    ]
}

/// What the loop of the stored parameters does.
fn loop_of(of: &FormResult) -> Table {
    let [fall, rise] = of.margins.gain_margins;
    let mut rows = vec![
        [
            "conversion".to_owned(),
            explained(of.exactness).to_owned(),
            String::new(),
        ],
        row("period of the loop", figure(1e3 * of.sample_time), "ms"),
        row("largest sensitivity Ms", figure(of.margins.sensitivity), ""),
        row("gain may fall to", figure(fall), "times"),
        row("gain may rise to", figure(rise), "times"),
    ];
    for step in &of.steps {
        let FormStep {
            smoothing,
            rise_time,
            overshoot,
        } = *step;
        let through = if smoothing > 0.0 {
            format!("through a filter of {} s", figure(smoothing))
        } else {
            "step of the target".to_owned()
        };
        let rise_time = rise_time.map_or("–".to_owned(), |time| figure(1e3 * time));
        rows.push(row(&format!("{through}: rise time"), rise_time, "ms"));
        rows.push(row(
            &format!("{through}: overshoot"),
            figure(100.0 * overshoot),
            "%",
        ));
    }
    let columns = vec![
        Column::words("loop as it is stored"),
        Column::figures("promised"),
        Column::words("unit"),
    ];
    Table::new("", columns, rows.into_iter().map(Vec::from).collect())
}

fn row(name: &str, value: String, unit: &str) -> [String; 3] {
    [name.to_owned(), value, unit.to_owned()]
}

/// An exactness for a reader.
fn explained(exactness: &str) -> &str {
    match exactness {
        "needs ki cut" => "needs ki cut (to kp²/4kd)",
        other => other,
    }
}

/// The step and the sensitivity of the stored parameters.
pub(super) fn figures(of: &FormResult, settings: &TuningSettings) -> Vec<Figure> {
    let course = |name: &str, place: usize| {
        let points = of
            .response
            .iter()
            .map(|sample| (sample[0], settings.step * sample[place]));
        vec![Trace::new(name, points.collect())]
    };
    let points = of
        .sensitivity
        .iter()
        .map(|[frequency, value]| (frequency / TAU, *value));
    let sensitivity = vec![Trace::new("identified", points.collect())];
    let mut sensitivity = Figure::new("Sensitivity", "frequency [Hz]", "|S|", sensitivity)
        .with_level("largest allowed", settings.max_sensitivity)
        .from_zero();
    sensitivity.horizontal.is_logarithmic = true;
    vec![
        Figure::new("Predicted step", TIME, "q [rad]", course("position", 1))
            .with_level("reference", settings.step)
            .from_zero(),
        Figure::new(
            "Command beyond what holds the load",
            TIME,
            "u [command units]",
            course("command", 2),
        ),
        sensitivity,
    ]
}
