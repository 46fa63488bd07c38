/// The phase of a commissioning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Phase {
    /// Not begun.
    Idle,
    /// The stage is disabled, or the gains before hold the servo, which must stay where it is.
    ReleasedCheck,
    /// A relay about the holding command, within the limits.
    Probing,
    /// The servo is held while the solver fits.
    Fit,
    /// A second motion, from which the solver learns more.
    Refine,
    /// A third motion, which the frozen model must predict.
    Verify,
    /// The servo slides both ways under a multisine, which shows a resonance that friction hides.
    Slide,
    /// The servo is held while the solver tunes.
    Tune,
    /// The new gains hold, and a step and a disturbance are measured against the prediction.
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
    pub const ALL: [Self; 12] = [
        Self::Idle,
        Self::ReleasedCheck,
        Self::Probing,
        Self::Fit,
        Self::Refine,
        Self::Verify,
        Self::Slide,
        Self::Tune,
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
            Self::ReleasedCheck => "released-check",
            Self::Probing => "wiggle",
            Self::Fit => "fit",
            Self::Refine => "refine",
            Self::Verify => "verify",
            Self::Slide => "slide",
            Self::Tune => "tune",
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
