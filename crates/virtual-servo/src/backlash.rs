//! The backlash between a motor and the encoder on its load.

/// The load is at standstill while the motor is within the backlash. The end of the backlash at the motor takes it
/// along (in mathematics the play operator of hysteresis).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Backlash {
    half: f64,
    position: f64,
    taken_along: bool,
}

impl Backlash {
    /// So much from end to end, rad, the motor in the middle.
    pub(crate) fn new(width: f64) -> Self {
        Self {
            half: 0.5 * width,
            position: 0.0,
            taken_along: false,
        }
    }

    /// Follows the motor to a position, rad.
    pub(crate) fn follow(&mut self, motor: f64) {
        let (low, high) = (motor - self.half, motor + self.half);
        self.taken_along = self.position < low || self.position > high;
        self.position = self.position.clamp(low, high);
    }

    /// Position of the load, rad.
    pub(crate) fn position(&self) -> f64 {
        self.position
    }

    /// The load's velocity when this is the motor's.
    pub(crate) fn velocity(&self, motor: f64) -> f64 {
        if self.taken_along { motor } else { 0.0 }
    }
}
