//! What number formats make of an experiment: as a table, as JSON, as CSV and as a picture.

use std::io::Write;

use serde::Serialize;

use crate::drift::{Compared, Difference, Differences, FORMATS, Signals};
use crate::present::{Envelope, Figure, TIME};
use crate::render::terminal::table::Rows;
use crate::scenario::Arithmetic;

/// One row a signal and format, as wide as `width` characters have room for.
#[must_use]
pub fn table(differences: &Differences, width: u16) -> String {
    let mut table = Rows::default()
        .words("signal")
        .words("format")
        .figures("rms in f64")
        .dispensable(2)
        .figures("mean off by")
        .dispensable(1)
        .figures("rms off by")
        .figures("at most")
        .figures("signal to noise")
        .dispensable(0);
    for format in [Arithmetic::F32, Arithmetic::Fixed] {
        for difference in differences.of(format) {
            table.row(vec![
                format!("{} [{}]", difference.name, difference.unit),
                format.name().to_owned(),
                format!("{:.4e}", difference.size),
                format!("{:+.1e}", difference.mean),
                format!("{:.1e}", difference.rms),
                format!("{:.1e}", difference.max),
                decibel(&difference),
            ]);
        }
    }
    table.within(width)
}

fn decibel(difference: &Difference) -> String {
    if difference.rms > 0.0 && difference.size > 0.0 {
        format!("{:.0} dB", signal_to_noise(difference))
    } else {
        "–".to_owned()
    }
}

/// 20 log₁₀ of the signal's root mean square over that of the difference.
#[must_use]
pub fn signal_to_noise(difference: &Difference) -> f64 {
    20.0 * (difference.size / difference.rms).log10()
}

/// The signals that are shown, with name, unit and value.
type Shown = (&'static str, &'static str, fn(&Signals) -> f64);

const SHOWN: [Shown; 6] = [
    ("Command", "u [command units]", |signals| signals.command),
    ("Output error", "ε [rad]", |signals| signals.output_error),
    ("Viscous friction over inertia", "a [1/s]", |signals| {
        signals.estimates.a
    }),
    ("Gain over inertia", "b [rad/s²/u]", |signals| {
        signals.estimates.b
    }),
    ("Coulomb friction over inertia", "c [rad/s²]", |signals| {
        signals.estimates.coulomb
    }),
    ("Load over inertia", "d [rad/s²]", |signals| {
        signals.estimates.load
    }),
];

/// The formats that are held against double precision, which is the first of [`FORMATS`], with
/// their places there.
const HELD: [(Arithmetic, usize); 2] = [(Arithmetic::F32, 1), (Arithmetic::Fixed, 2)];

/// What the panels are drawn from, gathered sample by sample in bounded memory.
#[derive(Debug, Clone, Default)]
pub struct Traces {
    differences: [[Envelope; HELD.len()]; SHOWN.len()],
}

impl Traces {
    /// Takes in a sample.
    pub fn add(&mut self, sample: &Compared) {
        let [reference, ..] = &sample.signals;
        for (envelopes, (.., of)) in self.differences.iter_mut().zip(SHOWN) {
            for (envelope, (_, place)) in envelopes.iter_mut().zip(HELD) {
                let difference = of(&sample.signals[place]) - of(reference);
                envelope.add(sample.time, difference, None);
            }
        }
    }
}

/// The differences from double precision over time.
#[must_use]
pub fn figures(traces: &Traces) -> Vec<Figure> {
    let signals = SHOWN.iter().zip(&traces.differences);
    signals
        .map(|((title, axis, _), envelopes)| {
            let formats = HELD.iter().zip(envelopes);
            let traces = formats.map(|((format, _), envelope)| envelope.trace(format.name()));
            Figure::new(&format!("{title}, less f64"), TIME, axis, traces.collect())
        })
        .collect()
}

/// Writes the signals of every format, one row a sample, SI.
///
/// # Errors
/// Whatever the writer answers.
pub fn csv(out: impl Write, trace: &[Compared]) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_writer(out);
    let mut heading = vec!["time_s".to_owned()];
    for format in FORMATS {
        for signal in [
            "velocity_rad_per_s",
            "command",
            "output_error_rad",
            "a_per_s",
            "b_rad_per_s2_per_command",
            "coulomb_rad_per_s2",
            "load_rad_per_s2",
        ] {
            heading.push(format!("{}_{signal}", format.name()));
        }
    }
    writer.write_record(heading)?;
    for sample in trace {
        let mut row = vec![sample.time.to_string()];
        for signals in &sample.signals {
            let estimates = &signals.estimates;
            row.extend(
                [
                    signals.velocity,
                    signals.command,
                    signals.output_error,
                    estimates.a,
                    estimates.b,
                    estimates.coulomb,
                    estimates.load,
                ]
                .map(|value| value.to_string()),
            );
        }
        writer.write_record(row)?;
    }
    writer.flush()?;
    Ok(())
}

/// The differences for a program.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct Document {
    pub samples: u64,
    pub sample_time: f64,
    pub all_finite: bool,
    pub f32: Vec<DifferenceDocument>,
    pub fixed: Vec<DifferenceDocument>,
}

/// The difference of one signal from double precision.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct DifferenceDocument {
    pub signal: &'static str,
    pub unit: &'static str,
    pub size: f64,
    pub mean: f64,
    pub rms: f64,
    pub max: f64,
}

impl Document {
    /// The document of a run.
    #[must_use]
    pub fn new(differences: &Differences, samples: u64, sample_time: f64) -> Self {
        let of = |format| {
            differences
                .of(format)
                .into_iter()
                .map(|difference| DifferenceDocument {
                    signal: difference.name,
                    unit: difference.unit,
                    size: difference.size,
                    mean: difference.mean,
                    rms: difference.rms,
                    max: difference.max,
                })
                .collect()
        };
        Self {
            samples,
            sample_time,
            all_finite: differences.all_finite(),
            f32: of(Arithmetic::F32),
            fixed: of(Arithmetic::Fixed),
        }
    }
}
