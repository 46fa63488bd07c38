//! The sensitivity of a loop over frequency.

use std::f64::consts::TAU;

use identifier_core::tuning::{MeasuredLine, Tuner, Tuning, TuningSettings};

use super::{Figure, Trace};

/// |S| of the identified servo, of the worst that it may be and, where a response was measured, of its lines, over the
/// frequency up to half of the sample rate, with the largest that is allowed.
pub(super) fn sensitivity(
    tuner: &Tuner,
    tuning: &Tuning,
    settings: &TuningSettings,
    lines: &[MeasuredLine],
) -> Figure {
    let [identified, worst] = of_servos(tuner, tuning, settings.sample_time);
    let mut traces = vec![
        Trace::new("identified", identified),
        Trace::new("worst case within the intervals", worst),
    ];
    if !lines.is_empty() {
        traces.insert(0, measured(tuning, settings.sample_time, lines));
    }
    let mut figure = Figure::new("Sensitivity", "frequency [Hz]", "|S|", traces)
        .with_level("largest allowed", settings.max_sensitivity)
        .from_zero();
    figure.horizontal.is_logarithmic = true;
    figure
}

/// For the identified servo and for the worst.
fn of_servos(tuner: &Tuner, tuning: &Tuning, sample_time: f64) -> [Vec<(f64, f64)>; 2] {
    /// Lowest frequency, in ω, and how finely they are taken.
    const LOWEST: f64 = 0.05;
    const POINTS: u32 = 400;
    let lowest = LOWEST * tuning.bandwidth / TAU;
    let highest = 0.5 / sample_time;
    let mut curves = [Vec::new(), Vec::new()];
    for i in 0..POINTS {
        let frequency = lowest * (highest / lowest).powf(f64::from(i) / f64::from(POINTS));
        let found = tuner.sensitivity(tuning, TAU * frequency);
        for (curve, value) in curves.iter_mut().zip(found.into_iter().flatten()) {
            curve.push((frequency, value));
        }
    }
    curves
}

/// On the measured lines.
fn measured(tuning: &Tuning, sample_time: f64, lines: &[MeasuredLine]) -> Trace {
    let on_lines = lines.iter().filter_map(|line| {
        let [value, deviation] = line.sensitivity(tuning, sample_time)?;
        Some(((line.frequency / TAU, value), deviation))
    });
    let (points, band) = on_lines.unzip();
    Trace {
        name: "measured ± standard deviation".to_owned(),
        band,
        points,
    }
}
