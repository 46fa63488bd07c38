//! The channels of a commissioning.

use std::io::{self, Write};

use super::{Channel, Recorder};
use crate::commission::Sample;
use crate::scenario::LogSettings;

/// The columns of a replay; the names are those of the columns of a CSV of a commissioning.
pub static SERVO: Channel = Channel {
    topic: "/servo",
    schema: "servo-id/Commissioning",
    fields: &[
        (LogSettings::OWN_TIME, "time, s"),
        (LogSettings::OWN_REFERENCE, "reference position, rad"),
        (LogSettings::OWN_POSITION, "measured position, rad"),
        (
            LogSettings::OWN_COMMAND,
            "the command that acts from here to the next sample, command units; 0 for a servo that is let go",
        ),
        (
            "phase",
            "the phase: 0 idle, 1 released-check, 2 wiggle, 3 fit, 4 refine, 5 verify, 6 slide, 7 tune, \
             8 trial, 9 applied, 10 rolled-back, 11 aborted",
        ),
        ("true_position_rad", "the simulated servo's position, rad"),
        (
            "true_velocity_rad_per_s",
            "the simulated servo's velocity, rad/s",
        ),
    ],
};

/// Begins the file of a commissioning.
///
/// # Errors
/// Those of `out`.
pub fn begin<W: Write>(out: W) -> io::Result<Recorder<W>> {
    Recorder::new(out, &[&SERVO])
}

/// Writes a sample.
///
/// # Errors
/// Those of the writer.
pub fn add<W: Write>(recorder: &mut Recorder<W>, sample: &Sample) -> io::Result<()> {
    recorder.begin_sample();
    let (time, command) = (sample.time, sample.command.unwrap_or(0.0));
    recorder.numbers(
        &SERVO,
        time,
        [
            Some(time),
            sample.reference,
            sample.measured,
            Some(command),
            Some(f64::from(sample.phase as u8)),
            Some(sample.position),
            Some(sample.velocity),
        ],
    )?;
    recorder.joint(time, sample.measured, None, Some(command))
}
