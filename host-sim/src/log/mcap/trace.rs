//! The channels of a run or a replay.

use std::io::{self, Write};

use super::{Channel, Recorder};
use crate::experiment::Sample;
use crate::scenario::LogSettings;

/// The columns of a replay; the names are those of the columns of a CSV trace.
pub static SERVO: Channel = Channel {
    topic: "/servo",
    schema: "servo-id/Servo",
    fields: &[
        (LogSettings::OWN_TIME, "time, s"),
        (LogSettings::OWN_REFERENCE, "reference position, rad"),
        (LogSettings::OWN_POSITION, "measured position, rad"),
        (
            LogSettings::OWN_COMMAND,
            "the whole command that acts from here to the next sample, command units",
        ),
        (
            "output_error_rad",
            "measured position less the model's, rad",
        ),
    ],
};

/// The estimates of the identifier.
pub static ESTIMATES: Channel = Channel {
    topic: "/estimates",
    schema: "servo-id/Estimates",
    fields: &[
        ("a_per_s", "viscous friction over inertia, 1/s"),
        (
            "b_rad_per_s2_per_command",
            "gain over inertia, rad/s² per command unit",
        ),
        (
            "coulomb_rad_per_s2",
            "Coulomb friction over inertia, rad/s²",
        ),
        ("load_rad_per_s2", "load over inertia, rad/s²"),
        ("a_std_error", "standard error of a, 1/s"),
        (
            "b_std_error",
            "standard error of b, rad/s² per command unit",
        ),
        (
            "coulomb_std_error",
            "standard error of the Coulomb friction, rad/s²",
        ),
        ("load_std_error", "standard error of the load, rad/s²"),
    ],
};

/// Begins the file of a trace.
///
/// # Errors
/// Those of `out`.
pub fn begin<W: Write>(out: W) -> io::Result<Recorder<W>> {
    Recorder::new(out, &[&SERVO, &ESTIMATES])
}

/// Writes a sample.
///
/// # Errors
/// Those of the writer.
pub fn add<W: Write>(recorder: &mut Recorder<W>, sample: &Sample) -> io::Result<()> {
    recorder.begin_sample();
    let time = sample.time;
    recorder.numbers(&SERVO, time, sample.measured())?;
    recorder.numbers(&ESTIMATES, time, sample.identified())?;
    recorder.joint(time, Some(sample.position), None, Some(sample.command))
}
