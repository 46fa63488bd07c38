use commissioning::Phase;

/// One sample of a commissioning, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time since it began, s.
    pub time: f64,
    /// The phase.
    pub phase: Phase,
    /// Position by the encoder, rad; none if it gave no valid reading.
    pub measured: Option<f64>,
    /// Reference, rad; none where no controller acts.
    pub reference: Option<f64>,
    /// True position of the servo, rad.
    pub position: f64,
    /// Its true velocity, rad/s.
    pub velocity: f64,
    /// The command that acts from here on, command units; none if the servo is disabled.
    pub command: Option<f64>,
}
