//! Tables as comma-separated values, SI. The first columns of an experiment and a commissioning are those of a log. A
//! value that is not known or not finite is left empty.

use std::fmt;
use std::io::{self, Write};

use host_sim::commission;
use host_sim::result::SweepRun;
use host_sim::scenario::{Estimator, LogSettings};
use identifier_log::{AxisKind, MotionUnit, experiment};

/// The columns of a log.
const LOG: [&str; 4] = [
    LogSettings::OWN_TIME,
    LogSettings::OWN_REFERENCE,
    LogSettings::OWN_POSITION,
    LogSettings::OWN_COMMAND,
];

/// What the model left in an experiment, behind those of a log.
const LEFT: [&str; 1] = ["output_error_rad"];

/// The columns of an identified log.
const IDENTIFIED: [&str; 5] = [
    LogSettings::OWN_TIME,
    LogSettings::OWN_POSITION,
    "model_rad",
    "residual_rad",
    LogSettings::OWN_COMMAND,
];

/// The estimates behind them, and their standard errors.
const ESTIMATES: [&str; 8] = [
    "a_per_s",
    "b_rad_per_s2_per_command",
    "coulomb_rad_per_s2",
    "load_rad_per_s2",
    "a_std_error",
    "b_std_error",
    "coulomb_std_error",
    "load_std_error",
];

/// Those of a commissioning: its phase, and the simulated servo.
const COMMISSIONED: [&str; 3] = ["phase", "true_position_rad", "true_velocity_rad_per_s"];

/// A table that is written row by row.
#[derive(Debug)]
pub struct Rows<W: Write> {
    rows: csv::Writer<W>,
    cell: String,
    /// Of an identified log: how many columns of estimates it has.
    of_log: Option<usize>,
}

/// A number, left empty where it is not known.
struct Number(Option<f64>);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.filter(|value| value.is_finite()) {
            Some(value) => value.fmt(f),
            None => Ok(()),
        }
    }
}

impl<W: Write> Rows<W> {
    fn new<N: AsRef<[u8]>>(out: W, names: impl IntoIterator<Item = N>) -> io::Result<Self> {
        let mut rows = csv::Writer::from_writer(out);
        rows.write_record(names).map_err(io_error)?;
        Ok(Self {
            rows,
            cell: String::new(),
            of_log: None,
        })
    }

    fn cell(&mut self, value: impl fmt::Display) -> io::Result<()> {
        use fmt::Write as _;
        self.cell.clear();
        // Writing into memory cannot fail.
        let _ = write!(self.cell, "{value}");
        self.rows.write_field(&self.cell).map_err(io_error)
    }

    fn numbers(&mut self, values: impl IntoIterator<Item = Option<f64>>) -> io::Result<()> {
        let mut values = values.into_iter();
        values.try_for_each(|value| self.cell(Number(value)))
    }

    fn end_row(&mut self) -> io::Result<()> {
        self.rows.write_record(None::<&[u8]>).map_err(io_error)
    }

    /// Begins the trace of an experiment with its heading, for positions in a unit. That of an identified log, by this
    /// estimator, has the model and its residual, and no column that would be empty.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn of_experiment(out: W, unit: MotionUnit, of_log: Option<Estimator>) -> io::Result<Self> {
        let unit = match unit {
            MotionUnit::Stated(_) => "rad",
            MotionUnit::Count => "counts",
            MotionUnit::Own | MotionUnit::OwnVelocity => "own",
        };
        let of_log = of_log.map(|law| match law {
            Estimator::GaussNewton => ESTIMATES.len(),
            _ => ESTIMATES.len() / 2,
        });
        let names = match of_log {
            Some(estimates) => [&IDENTIFIED[..], &ESTIMATES[..estimates]].concat(),
            None => [&LOG[..], &LEFT, &ESTIMATES].concat(),
        };
        let names = names.iter().map(|name| name.replace("rad", unit));
        Ok(Self {
            of_log,
            ..Self::new(out, names)?
        })
    }

    /// Writes a sample of an experiment.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn sample(&mut self, sample: &experiment::Sample) -> io::Result<()> {
        let identified = sample.identified();
        match self.of_log {
            Some(estimates) => {
                let error = sample.output_error;
                let model = error.map(|error| sample.position - error);
                let [time, _, position, command, _] = sample.measured();
                self.numbers([time, position, model, error, command])?;
                self.numbers(identified.into_iter().take(estimates))?;
            }
            None => self.numbers(sample.measured().into_iter().chain(identified))?,
        }
        self.end_row()
    }

    /// Begins the samples of a commissioning with their heading.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn of_commissioning(out: W) -> io::Result<Self> {
        Self::new(out, LOG.into_iter().chain(COMMISSIONED))
    }

    /// Writes a sample of a commissioning. A disabled servo has a command of zero.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn commissioning_sample(&mut self, sample: &commission::Sample) -> io::Result<()> {
        let command = sample.command.unwrap_or(0.0);
        let seen = [Some(sample.time), sample.reference, sample.measured];
        self.numbers(seen.into_iter().chain([Some(command)]))?;
        self.cell(sample.phase.name())?;
        self.numbers([Some(sample.position), Some(sample.velocity)])?;
        self.end_row()
    }

    /// Ends the file, and returns the writer.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> io::Result<W> {
        let out = self.rows.into_inner();
        out.map_err(csv::IntoInnerError::into_error)
    }
}

/// Writes the trace of an experiment.
///
/// # Errors
/// Those of the writer.
pub fn trace(out: impl Write, trace: &[experiment::Sample]) -> io::Result<()> {
    let mut rows = Rows::of_experiment(out, MotionUnit::Stated(AxisKind::Rotary), None)?;
    trace.iter().try_for_each(|sample| rows.sample(sample))?;
    rows.finish().map(drop)
}

/// Writes the runs of a sweep, one row per servo.
///
/// # Errors
/// Those of the writer.
pub fn sweep(out: impl Write, runs: &[SweepRun]) -> io::Result<()> {
    const PARAMETERS: [&str; 4] = ["a", "b", "coulomb", "load"];
    let truths = PARAMETERS.map(str::to_owned);
    let found = PARAMETERS.map(|name| format!("{name}_found"));
    let begin = ["run", "status"].map(str::to_owned);
    let end = ["a_settled_s", "b_settled_s"].map(str::to_owned);
    let names = begin.into_iter().chain(truths).chain(found).chain(end);
    let mut rows = Rows::new(out, names)?;
    for run in runs {
        rows.cell(run.index)?;
        rows.cell(run.status.name())?;
        for servo in [&run.truth, &run.found] {
            rows.numbers([servo.a, servo.b, servo.coulomb, servo.load].map(Some))?;
        }
        rows.numbers([run.settling_a, run.settling_b])?;
        rows.end_row()?;
    }
    rows.finish().map(drop)
}

/// The system's error of a table.
fn io_error(error: csv::Error) -> io::Error {
    let message = error.to_string();
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        _ => io::Error::other(message),
    }
}
