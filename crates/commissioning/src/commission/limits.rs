/// Limits of a commissioning, SI. For a linear axis read m for rad.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits {
    /// Lowest and highest position, rad from the servo's start. The first is zero or less, the second zero or more.
    pub travel: [f64; 2],
    /// The largest speed, rad/s.
    pub speed: f64,
    /// Lowest and highest command, command units: the first below zero, the second above.
    pub command: [f64; 2],
    /// The longest time that a motion may take, s.
    pub duration: f64,
}
