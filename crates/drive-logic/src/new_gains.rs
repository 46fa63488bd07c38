//! Gains that take the place of those of a run.

use identifier_core::watch::KnownServo;

use crate::closed_loop::LoopController;

/// The gains of a run for another servo.
#[derive(Debug)]
pub(crate) struct NewGains {
    pub(crate) controller: LoopController,
    /// The servo as the watches know it.
    pub(crate) known: Option<KnownServo<f32>>,
}
