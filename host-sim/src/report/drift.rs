//! What number formats make of an experiment: as CSV and as a picture.

use std::io::Write;

use crate::drift::{Compared, FORMATS, Signals};
use crate::present::{Envelope, Figure, TIME};
use crate::scenario::Arithmetic;

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
