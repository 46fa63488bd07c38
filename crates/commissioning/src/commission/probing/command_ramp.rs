use identifier_core::number::Number;

/// The growth of the command that is to move an unknown servo for the first time. Command units and samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandRamp<N> {
    /// First step, its growth a sample and the steepest change a sample.
    pub(super) first_step: N,
    pub(super) growth: N,
    pub(super) steepest: N,
    jammed: u32,
}

impl<N: Number> CommandRamp<N> {
    /// The growth, 1/s, and its steepest change, limits of the command a second.
    const GROWTH: f64 = 200.0;
    pub(super) const STEEPEST: f64 = 20.0;

    /// The time under all of the command within which a servo must move, s.
    const JAMMED: f64 = 0.02;

    /// For a command up to a limit (command units) at a sample time (s).
    #[must_use]
    pub fn new(limit: f64, sample_time: f64) -> Self {
        Self {
            first_step: N::from_f64(0.005 * limit),
            growth: N::from_f64(Self::growth(sample_time)),
            steepest: N::from_f64(Self::STEEPEST * sample_time * limit),
            jammed: libm::ceil(Self::JAMMED / sample_time) as u32,
        }
    }

    /// The growth a sample.
    pub(super) fn growth(sample_time: f64) -> f64 {
        (Self::GROWTH * sample_time).min(0.5)
    }

    /// The step of a sample, so far from where the command began.
    #[inline]
    pub fn step(&self, distance: N) -> N {
        (self.first_step + self.growth * distance).limited(N::ZERO, self.steepest)
    }

    /// Samples without an edge under all of the command after which nothing moves the servo.
    #[must_use]
    pub const fn jammed(&self) -> u32 {
        self.jammed
    }
}
