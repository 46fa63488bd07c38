//! The rows of logs on their way to a model, segment by segment.

use identifier_core::Settings;
use identifier_core::error::StepError;
use identifier_core::measurement::VelocityEstimate;

use super::agreement::Agreement;
use super::declared::Declared;
use super::scaled::RowScaler;
use super::settling::{settling, settling_in_motion};
use crate::log::{Log, Row};
use crate::scenario::{Fault, Options};

/// State that lasts from segment to segment.
#[derive(Debug)]
pub struct Player<V: VelocityEstimate<f64>> {
    declared: Option<Declared<V>>,
    filter: V,
    /// A position unit, rad.
    unit: f64,
    /// Travel of a revolution, rad.
    revolution: f64,
    /// Time before this segment, s.
    time: f64,
    /// True once a model has had a sample.
    begun: bool,
}

/// State within a segment.
#[derive(Debug)]
pub struct InSegment<V: VelocityEstimate<f64>> {
    scaler: RowScaler,
    /// When it began, s, of the log.
    from: f64,
    filtered: V::State,
    velocity: f64,
    /// Samples in which the velocity settles.
    settling: u64,
    /// Samples so far.
    samples: u64,
    /// Samples in which the velocity settles behind a bridged gap.
    settling_in_motion: u64,
    /// The sample from which on that is done.
    settled_again: u64,
}

/// The input of a model in a sample.
#[derive(Debug, Clone, Copy)]
pub struct Input {
    /// Motion since the last sample, position units.
    pub increment: f64,
    /// The command that acts from now on.
    pub command: f64,
    /// In the first sample of a segment that is learnt from.
    pub beginning: Option<Beginning>,
}

/// The motion that a model joins.
#[derive(Debug, Clone, Copy)]
pub struct Beginning {
    /// Velocity, position units a sample; none at the start of a log, at standstill.
    pub velocity: Option<f64>,
    /// Angle within a revolution before the sample, position units.
    pub angle: f64,
}

/// A sample of logs on its way to a model.
#[derive(Debug, Clone, Copy)]
pub struct Played<'a> {
    /// The number of the pass, from 0.
    pub pass: u32,
    /// The row.
    pub row: &'a Row,
    /// Time, s, that continues from log to log and from pass to pass, without the ranges that are left out.
    pub time: f64,
    /// The input of the model.
    pub input: Input,
}

/// Why and when a log could not be played to its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stopped {
    /// Time, s.
    pub time: f64,
    /// The error of the sample.
    pub error: StepError,
}

impl<V: VelocityEstimate<f64>> InSegment<V> {
    /// From its first row, with the samples in which the velocity settles.
    pub fn new(options: &Options, first: &Row, unit: f64, settling: u64) -> Self {
        Self {
            scaler: RowScaler::new(options, first.position, unit),
            from: first.time,
            filtered: V::State::default(),
            velocity: 0.0,
            settling,
            samples: 0,
            settling_in_motion: settling_in_motion(options),
            settled_again: 0,
        }
    }
}

impl<V: VelocityEstimate<f64>> Player<V> {
    /// With the controller of some settings if it `is_declared`, which ran beside a recorded command or computed one that
    /// was not.
    ///
    /// # Errors
    /// The key of a setting that is not allowed.
    pub fn new(
        options: &Options,
        settings: &Settings,
        is_declared: bool,
        command_recorded: bool,
    ) -> Result<Self, Fault> {
        let declared = is_declared.then(|| Declared::new(settings, command_recorded));
        Ok(Self {
            declared: declared
                .transpose()
                .map_err(|error| options.fault(&error))?,
            filter: (settings.velocity::<f64, V>())
                .map_err(|error| options.fault(&error.into()))?,
            unit: options.checked_units()?.position_unit(),
            revolution: options.stated.identifier.terms.revolution,
            time: 0.0,
            begun: false,
        })
    }

    /// A position unit, rad.
    #[must_use]
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// Passes over the logs of one servo, one after the other.
    ///
    /// # Errors
    /// The first sample that could not be taken.
    pub fn play(
        &mut self,
        options: &Options,
        logs: &[Log],
        passes: u32,
        take: &mut dyn FnMut(Played<'_>) -> Result<(), StepError>,
    ) -> Result<(), Stopped> {
        for pass in 0..passes {
            for (number, log) in logs.iter().enumerate() {
                let mut segments = log.segments().iter();
                let mut on: Option<InSegment<V>> = None;
                for row in log.rows() {
                    if row.begins || on.is_none() {
                        let settling = segments
                            .next()
                            .map_or(0, |segment| settling(options, segment));
                        if let Some(before) = on.take() {
                            self.time += before.samples as f64 * log.sample_time;
                        }
                        let begins_anew = pass == 0 || row.command.is_none();
                        if let Some(declared) = self.declared.as_mut().filter(|_| begins_anew) {
                            declared.begin();
                        }
                        on = Some(InSegment::new(options, row, self.unit, settling));
                    }
                    let Some(on) = &mut on else { continue };
                    let time = self.time + row.time - on.from;
                    let input = self.input(on, row, number, pass);
                    let taken = input.and_then(|input| match input {
                        Some(input) => take(Played {
                            pass,
                            row,
                            time,
                            input,
                        }),
                        None => Ok(()),
                    });
                    taken.map_err(|error| Stopped { time, error })?;
                }
                self.time += on.map_or(0, |on| on.samples) as f64 * log.sample_time;
            }
        }
        Ok(())
    }

    /// The input of a model in a sample of a log; none while the velocity settles.
    ///
    /// # Errors
    /// The declared controller cannot compute its command.
    pub fn input(
        &mut self,
        segment: &mut InSegment<V>,
        row: &Row,
        log: usize,
        pass: u32,
    ) -> Result<Option<Input>, StepError> {
        let has_moved = segment.scaler.has_moved();
        let scaled = segment.scaler.scale(*row);
        let settled = segment.samples >= segment.settling;
        let begins = segment.samples == segment.settling;
        if row.bridged {
            segment.settled_again = segment.samples + segment.settling_in_motion;
        }
        let comparable = settled && has_moved && segment.samples >= segment.settled_again;
        segment.samples += 1;
        let command = match (row.command, &mut self.declared) {
            (Some(command), declared) => {
                if let Some(declared) = declared.as_mut().filter(|_| pass == 0) {
                    declared.compare(&scaled, log, comparable);
                }
                command
            }
            (None, Some(declared)) => declared.process(&scaled)?,
            // It has been refused when the options were read.
            (None, None) => return Err(StepError::CommandNotFinite),
        };
        if !settled {
            segment.velocity = self.filter.process(&mut segment.filtered, scaled.increment);
            return Ok(None);
        }
        let joins = self.begun || segment.settling > 0;
        let angle = row.position.rem_euclid(self.revolution) / self.unit;
        self.begun = true;
        Ok(Some(Input {
            increment: scaled.increment,
            command,
            beginning: begins.then_some(Beginning {
                velocity: joins.then_some(segment.velocity),
                angle: angle - scaled.increment,
            }),
        }))
    }

    /// Agreement of the declared controller with the recorded command, where there are both.
    #[must_use]
    pub fn agreement(&self) -> Option<Agreement> {
        self.declared.as_ref().and_then(Declared::agreement)
    }
}
