//! Changes of a commissioned servo in a run.

use commissioning::servo_change::{CommissionedServo, ServoChange};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::reason::Reason;

use super::Supervisor;
use crate::messages::Examination;

impl<F: NorFlash> Supervisor<'_, F> {
    /// Takes in an examination of a run's estimates; true if another change is certain since, or none any longer.
    #[cold]
    #[inline(never)]
    pub(super) fn take_in_examination(&mut self, examination: &Examination) -> bool {
        let before = self.changed();
        if core::mem::replace(&mut self.examined_at, examination.noticed) != examination.noticed {
            self.changes.interrupt();
        }
        let identifier = self.identifier.as_ref();
        let settled = examination.settled.as_ref();
        let found = settled.and_then(|settled| identifier?.settled_in(settled));
        match (found, self.predicted()) {
            (Some(found), Some(predicted)) => {
                let [servo, errors] = &found;
                self.changes.take(predicted.change(servo, errors));
            }
            _ => self.changes.interrupt(),
        }
        self.changed() != before
    }

    /// The change of the servo that is certain.
    #[must_use]
    pub fn changed(&self) -> Option<Reason> {
        self.changes
            .reported()
            .map(|ServoChange { reason, .. }| *reason)
    }

    /// The servo for which the prediction of the gains in force holds.
    fn predicted(&self) -> Option<CommissionedServo> {
        let limit = self.command_limit()?;
        let found = self.commissioned?;
        CommissionedServo::new(&found.servo(), &found.tuning, limit)
    }

    /// The largest command either way, command units.
    fn command_limit(&self) -> Option<f64> {
        let [low, high] = self.settings.closed_loop.core.controller?.limit;
        Some(high.min(-low))
    }
}
