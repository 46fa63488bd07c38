use identifier_core::tuning::{PredictedSample, Tuner, TuningError};

use crate::present::{Figure, TIME, Trace};
use crate::tune::Tuned;

/// The predicted step, its command, and the sensitivity with its limit.
///
/// # Errors
/// None for a tuned servo.
pub fn figures(tuned: &Tuned) -> Result<Vec<Figure>, TuningError> {
    /// Time that is shown, in 1/ω.
    const SHOWN: f64 = 12.0;
    /// Range of an axis, in values of its level.
    const RANGE: f64 = 2.0;
    let Tuned {
        settings, tuning, ..
    } = tuned;
    let tuner = tuned.tuner()?;
    let until = SHOWN / tuning.bandwidth;
    let samples: Vec<_> = tuner
        .step(tuning)?
        .take_while(|sample| sample.time <= until)
        .collect();
    let course = |name: &str, value: fn(&PredictedSample) -> f64| {
        let points = samples.iter().map(|sample| (sample.time, value(sample)));
        vec![Trace::new(name, points.collect())]
    };
    let position = course("position", |sample| sample.position);
    let command = course("command", |sample| sample.command);
    let [identified, worst] = sensitivities(&tuner, tuned);
    let sensitivity = vec![
        Trace::new("identified", identified),
        Trace::new("worst that it may be", worst),
    ];
    Ok(vec![
        Figure::new("Predicted step", TIME, "q [rad]", position)
            .within(Some([0.0, RANGE * settings.step]))
            .with_level("reference", settings.step),
        Figure::new(
            "Command beyond what holds the load",
            TIME,
            "u [command units]",
            command,
        ),
        Figure::new("Sensitivity", "frequency over ω", "|S|", sensitivity)
            .within(Some([0.0, RANGE * settings.max_sensitivity]))
            .with_level("allowed", settings.max_sensitivity),
    ])
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
