/// An estimate and its standard error, infinite where that is not known.
pub type Estimated = [f64; 2];

/// Sizes of the effects that a feed-forward can compensate, zero where they were not identified.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Effects {
    /// g_s and g_c, rad/s².
    pub gravity: [Estimated; 2],
    /// r_s and r_c, rad/s².
    pub ripple: [Estimated; 2],
    /// δ, command units.
    pub dead_band: Estimated,
}
