use super::Goal;

/// What a loop is tuned for, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TuningSettings {
    /// Sample time, s.
    pub sample_time: f64,
    /// Position of a count, rad; zero for an ideal sensor.
    pub resolution: f64,
    /// Cut-off of the low-pass velocity estimate, rad/s; none: chosen with the gains.
    pub cutoff: Option<f64>,
    /// The largest command, command units, beyond what holds the load; infinite for none.
    pub command: f64,
    /// From the reading of the encoder to the change of the output, s, beyond what was identified.
    pub command_delay: f64,
    /// What is asked for.
    pub goal: Goal,
    /// The largest sensitivity Mₛ.
    pub most_sensitivity: f64,
    /// The largest part of the command that the encoder's rounding may make up, standard deviation.
    pub most_noise: f64,
    /// The step of the reference that is promised, rad.
    pub step: f64,
    /// The lowest resonance that is known, rad/s.
    pub resonance: Option<f64>,
}

/// Why there are no gains.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TuningError {
    /// A setting out of its range, by name.
    OutOfRange(crate::error::OutOfRange),
    /// What was asked for is more than the servo bears.
    TooFast {
        /// The bandwidth asked for, rad/s.
        bandwidth: f64,
        /// The largest that would do, rad/s.
        most: f64,
        /// What keeps it there.
        cap: super::Cap,
    },
    /// Nothing was identified well enough to tune for: b may be zero.
    NotKnown,
}
