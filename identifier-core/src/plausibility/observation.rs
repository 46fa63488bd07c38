/// A sample as plausibility sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation<N> {
    /// Counts that the encoder has moved since its last valid reading; none if there is no valid one now.
    pub increment: Option<N>,
    /// The command that acted since the last sample, command units.
    pub command: N,
    /// Counts from the start; the last one known if there is no valid reading.
    pub position: N,
    /// Where a controller wants the servo, counts from the start; none while no controller acts: the
    /// servo is let go, or a ramp or a relay gives the command.
    pub setpoint: Option<N>,
    /// Whether the sample before ended too late.
    pub late: bool,
    /// Whether the command that acted must move the servo whatever its friction: that of a relay, once a
    /// ramp has found where the servo breaks loose.
    pub must_move: bool,
}
