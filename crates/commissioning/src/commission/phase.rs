/// The phase of a commissioning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Phase {
    /// Not begun.
    Idle,
    /// The stage is disabled, or the old gains hold the servo. It must stay at its position.
    Rest,
    /// A relay about the holding command, within the limits.
    Probe,
    /// The servo is held while the solver fits.
    Fit,
    /// The servo moves both ways at constant speed under a multisine, which shows a resonance that friction hides.
    FrequencyResponse,
    /// The servo is held while the solver searches gains.
    Gains,
    /// The new gains hold, and a step and the step back are measured against the prediction.
    Trial,
    /// The new gains hold for good.
    Applied,
    /// The new gains failed; those before hold again.
    RolledBack,
    /// Ended before there were new gains; those before hold, or the stage is disabled.
    Aborted,
}

impl Phase {
    /// All, in their order.
    pub const ALL: [Self; 10] = [
        Self::Idle,
        Self::Rest,
        Self::Probe,
        Self::Fit,
        Self::FrequencyResponse,
        Self::Gains,
        Self::Trial,
        Self::Applied,
        Self::RolledBack,
        Self::Aborted,
    ];

    /// Its name in results and on the line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Rest => "rest",
            Self::Probe => "probe",
            Self::Fit => "fit",
            Self::FrequencyResponse => "frequency-response",
            Self::Gains => "gains",
            Self::Trial => "trial",
            Self::Applied => "applied",
            Self::RolledBack => "rolled-back",
            Self::Aborted => "aborted",
        }
    }

    /// True if it is an end: nothing follows but another commissioning.
    #[must_use]
    pub const fn is_end(self) -> bool {
        matches!(self, Self::Applied | Self::RolledBack | Self::Aborted)
    }
}
