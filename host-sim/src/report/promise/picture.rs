use identifier_core::tuning::{PredictedSample, Tuner, TuningError};

use crate::render::chart::plot::{self, Curve, Panel};
use crate::tune::Tuned;

/// The predicted step, its command, and the sensitivity with its limit.
///
/// # Errors
/// None for what was tuned.
pub fn panels(tuned: &Tuned) -> Result<Vec<Panel>, TuningError> {
    /// How long the step is shown, in 1/ω.
    const SHOWN: f64 = 12.0;
    /// What a panel shows, in what its dashed line stands at: room for the curve and its names.
    const ROOM: f64 = 2.0;
    let Tuned {
        settings, tuning, ..
    } = tuned;
    let tuner = tuned.tuner()?;
    let until = SHOWN / tuning.bandwidth;
    let samples: Vec<_> = tuner
        .step(tuning)?
        .take_while(|sample| sample.time <= until)
        .collect();
    let curve = |points: Vec<(f64, f64)>, name: Option<&str>| Curve {
        name: name.map(str::to_owned),
        points,
        band: Vec::new(),
    };
    let of_step = |value: fn(&PredictedSample) -> f64| {
        let points = samples.iter();
        vec![curve(
            points.map(|sample| (sample.time, value(sample))).collect(),
            None,
        )]
    };
    let panel = |title: &str, axis: &str, curves| Panel {
        title: title.to_owned(),
        abscissa: plot::TIME.to_owned(),
        axis: axis.to_owned(),
        logarithmic_abscissa: false,
        curves,
        nominal: None,
        range: None,
    };
    let mut position = panel(
        "Predicted step",
        "q [rad]",
        of_step(|sample| sample.position),
    );
    position.nominal = Some(("reference".to_owned(), settings.step));
    position.range = Some((0.0, ROOM * settings.step));
    let command = panel(
        "Command beyond what holds the load",
        "u [command units]",
        of_step(|sample| sample.command),
    );
    let mut sensitivity = panel(
        "Sensitivity",
        "|S|",
        sensitivities(&tuner, tuned)
            .into_iter()
            .zip(["identified", "worst that it may be"])
            .map(|(points, name)| curve(points, Some(name)))
            .collect(),
    );
    sensitivity.abscissa = "frequency over ω".to_owned();
    sensitivity.nominal = Some(("allowed".to_owned(), settings.max_sensitivity));
    sensitivity.range = Some((0.0, ROOM * settings.max_sensitivity));
    Ok(vec![position, command, sensitivity])
}

/// |S| of the identified servo and of the worst, over the frequency in ω.
fn sensitivities(tuner: &Tuner, tuned: &Tuned) -> [Vec<(f64, f64)>; 2] {
    /// Up to where it is shown, in ω, and how finely.
    const HIGHEST: f64 = 12.0;
    const POINTS: u32 = 600;
    let mut curves = [Vec::new(), Vec::new()];
    for i in 1..=POINTS {
        let frequency = HIGHEST * f64::from(i) / f64::from(POINTS);
        let found = tuner.sensitivity(&tuned.tuning, frequency * tuned.tuning.bandwidth);
        for (curve, value) in curves.iter_mut().zip(found.into_iter().flatten()) {
            curve.push((frequency, value));
        }
    }
    curves
}
