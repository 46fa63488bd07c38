//! A comparison of number formats.

use super::estimates::dash;
use super::number::{figure, fixed, rough};
use super::{Block, Column, Envelope, Figure, Page, Section, TIME, Table, Tone, Verdict};
use crate::drift::{Compared, FORMATS, SIGNALS};
use crate::result::{Difference, DriftResult};

/// The differences of every format but double precision, the first, over time.
#[derive(Debug, Clone, Default)]
pub struct DriftTraces([[Envelope; SIGNALS.len()]; FORMATS.len() - 1]);

impl DriftTraces {
    /// Takes in a sample.
    pub fn add(&mut self, sample: &Compared) {
        let [reference, others @ ..] = &sample.signals;
        for (envelopes, other) in self.0.iter_mut().zip(others) {
            for (envelope, signal) in envelopes.iter_mut().zip(SIGNALS) {
                let difference = (signal.value)(other) - (signal.value)(reference);
                envelope.add(sample.time, difference, None);
            }
        }
    }

    fn figures(&self) -> Vec<Figure> {
        let signals = SIGNALS.iter().enumerate();
        let figures = signals.map(|(place, signal)| {
            let formats = FORMATS[1..].iter().zip(&self.0);
            let traces = formats.map(|(format, of)| of[place].trace(format.name()));
            let axis = format!("{} [{}]", signal.name, signal.unit);
            Figure::new("Difference from f64", TIME, &axis, traces.collect())
        });
        figures.collect()
    }
}

/// The page of a comparison of number formats.
#[must_use]
pub fn drift(title: &str, command: &str, result: &DriftResult, traces: &DriftTraces) -> Page {
    let (tone, status) = match result.all_finite {
        true => (Tone::Good, "finite"),
        false => (Tone::Failed, "not finite"),
    };
    let verdict = Verdict {
        tone,
        status: status.to_owned(),
        headline: format!("{} samples were compared.", result.samples),
        detail: "Each format had the same setpoints and counts.".to_owned(),
    };
    let found = vec![
        Block::Table(differences(result)),
        Block::Text(format!(
            "Differences from f64 on the same {} measurements: mean and root mean square over the last quarter, the \
             largest\nover the whole run.",
            result.samples
        )),
    ];
    let sections = [
        Section::brief("What was found", found),
        Section::full("Over time", vec![Block::Figures(traces.figures())]),
    ];
    Page::new(title, command, verdict, sections)
}

/// A row for each format and signal.
fn differences(result: &DriftResult) -> Table {
    let columns = vec![
        Column::words("signal"),
        Column::words("format"),
        Column::figures("rms in f64").dispensable(2),
        Column::figures("mean off by").dispensable(1),
        Column::figures("rms off by"),
        Column::figures("at most"),
        Column::figures("signal to noise").dispensable(0),
    ];
    let row = |format: &str, difference: &Difference| {
        let ratio = difference.signal_to_noise();
        vec![
            format!("{} [{}]", difference.name, difference.unit),
            format.to_owned(),
            figure(difference.size),
            rough(difference.mean),
            rough(difference.rms),
            rough(difference.max),
            ratio.map_or_else(dash, |decibel| format!("{} dB", fixed(decibel, 0))),
        ]
    };
    let single = result.f32.iter().map(|difference| row("f32", difference));
    let fixed = result
        .fixed
        .iter()
        .map(|difference| row("fixed", difference));
    Table::new("", columns, single.chain(fixed).collect())
}
