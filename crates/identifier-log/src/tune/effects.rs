/// An estimate and its standard error, infinite where that is not known.
pub type WithError = [f64; 2];

/// Sizes of the effects that a feed-forward can compensate, zero where they were not identified.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct KnownEffects {
    /// g_s and g_c, rad/s².
    pub gravity: [WithError; 2],
    /// r_s and r_c, rad/s².
    pub ripple: [WithError; 2],
    /// δ, command units.
    pub dead_band: WithError,
}
