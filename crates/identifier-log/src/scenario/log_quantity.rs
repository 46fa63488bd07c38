/// The quantity in a column of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(
    missing_docs,
    reason = "each is documented at its column in LogSettings"
)]
pub enum LogQuantity {
    Time,
    Reference,
    Position,
    Command,
    KnownTorque,
    Velocity,
}

impl LogQuantity {
    /// The key that states its column.
    #[must_use]
    pub const fn key(self) -> &'static str {
        match self {
            Self::Time => "log.time",
            Self::Reference => "log.reference",
            Self::Position => "log.position",
            Self::Command => "log.command",
            Self::KnownTorque => "log.known_torque",
            Self::Velocity => "log.velocity",
        }
    }
}
