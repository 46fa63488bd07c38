//! A servo that is held while what holds it changes.

use identifier_core::control::ControlSample;

/// A servo as one controller leaves it to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Held {
    /// The last sample of the controller that has held it.
    pub(crate) last: ControlSample<f32>,
    /// The count of that sample.
    pub(crate) count: i32,
    /// Where its loop was started: targets and travel are counted from there.
    pub(crate) started_at: i32,
    /// Where the servo stood before, and is to stand again.
    pub(crate) stood_at: i32,
}
