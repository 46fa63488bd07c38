//! A motion as a log that `identify` reads, and the scenario to read it with.

use std::f64::consts::TAU;
use std::io::{self, Write};

use drive_link::Settings;
use identifier_core::parameters::Parameter;
use identifier_core::settings::ControllerSettings;
use identifier_log::scenario::{Estimator, LogSettings, Options};

use super::frame::Frame;

/// A log that is being written: the frames of one motion.
#[derive(Debug)]
pub struct FrameRecording<W> {
    out: W,
    settings: Settings,
    /// Samples from one row to the next.
    every: u16,
    last: Option<Frame>,
    rows: u64,
}

/// The place of a frame in a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Taken {
    /// It is a row.
    Row,
    /// Another motion has begun: the recording is over, and the frame is no part of it.
    Over,
}

impl<W: Write> FrameRecording<W> {
    /// For a drive with these settings that sends a frame every `every` samples.
    #[must_use]
    pub fn new(out: W, settings: Settings, every: u16) -> Self {
        Self {
            out,
            settings,
            every,
            last: None,
            rows: 0,
        }
    }

    /// Rows so far.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Takes a frame, whose row can be read from then on.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add(&mut self, frame: &Frame) -> io::Result<Taken> {
        match &self.last {
            None => writeln!(self.out, "{}", heading(frame))?,
            Some(before) if frame.continues(before) => {}
            Some(_) => return Ok(Taken::Over),
        }
        self.last = Some(*frame);
        let time = f64::from(frame.sample()) * self.settings.closed_loop.core.sample_time;
        match frame {
            Frame::Running(snapshot) => {
                let known = &snapshot.estimates;
                writeln!(
                    self.out,
                    "{time:.9},{},{},{},{},{},{},{},{}",
                    snapshot.reference,
                    snapshot.position,
                    snapshot.command,
                    snapshot.output_error,
                    known.servo.a,
                    known.servo.b,
                    known.servo.coulomb,
                    known.servo.load,
                )?;
            }
            Frame::Commissioning(progress) => writeln!(
                self.out,
                "{time:.9},{},{},{}",
                progress.position,
                // A released servo gets none.
                progress.command.unwrap_or(0.0),
                progress.phase.name(),
            )?,
        }
        // A reader may follow at the other end of a pipe.
        self.out.flush()?;
        self.rows += 1;
        Ok(Taken::Row)
    }

    /// Ends it: the log, and the scenario that `identify` reads it with. Without a row there is nothing.
    #[must_use]
    pub fn finish(self) -> Option<(W, String)> {
        let text = scenario(&self.settings, &self.last?, self.every);
        Some((self.out, text))
    }
}

fn heading(frame: &Frame) -> String {
    let [time, reference, position, command] = [
        LogSettings::OWN_TIME,
        LogSettings::OWN_REFERENCE,
        LogSettings::OWN_POSITION,
        LogSettings::OWN_COMMAND,
    ];
    match frame {
        Frame::Running(_) => format!(
            "{time},{reference},{position},{command},output_error_rad,a_per_s,b_rad_per_s2_per_command,\
             coulomb_rad_per_s2,load_rad_per_s2"
        ),
        Frame::Commissioning(_) => format!("{time},{position},{command},phase"),
    }
}

/// The scenario to replay the log with. Estimates of the drive do not enter.
fn scenario(settings: &Settings, frame: &Frame, every: u16) -> String {
    let core = &settings.closed_loop.core;
    let is_running = matches!(frame, Frame::Running(_));
    let dithers = settings.dither.amplitude != 0.0;
    let mut options = Options::blank();
    options.counts_per_rev = Some(whole(TAU / core.resolution));
    // Between rows that are samples apart, what the controller did is not known.
    if is_running && every == 1 {
        // The reference of a frame is behind its filter. Under a dither there is no reference model.
        let is_whole = |of: &ControllerSettings| of.feed_forward.is_none() || dithers;
        let controller = core.controller.filter(is_whole);
        options.stated.controller = controller.map(|of| ControllerSettings {
            reference_filter: 0.0,
            feed_forward: None,
            ..of
        });
        options.stated.sample_time = core.sample_time;
        options.stated.cutoff = core.cutoff;
    }
    options.identifier.set_estimator(Estimator::GaussNewton);
    options.identifier.parameters = Parameter::ALL.to_vec();
    let mut log = LogSettings::own();
    log.reference = log.reference.filter(|_| is_running);
    options.log = Some(log);
    format!(
        "# Of a recording of `servo-id drive monitor`.\n\n{}",
        options.text()
    )
}

/// A number of counts, which is whole unless the resolution is not that of an encoder.
fn whole(counts: f64) -> f64 {
    /// Relative rounding of a division.
    const WHOLE_TOLERANCE: f64 = 1e-6;
    let nearest = counts.round();
    if (counts - nearest).abs() < WHOLE_TOLERANCE * nearest {
        nearest
    } else {
        counts
    }
}
