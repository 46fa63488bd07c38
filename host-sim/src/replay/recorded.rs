//! The reference of a log as an excitation.

use identifier_core::excitation::Excitation;

use super::Log;

/// Plays the recorded reference, machine units from the first position; holds its last value.
pub(super) struct RecordedReference<'a> {
    pub(super) log: &'a Log,
    pub(super) per_unit: f64,
}

impl Excitation<f64> for RecordedReference<'_> {
    type State = usize;

    fn start(&self) -> usize {
        0
    }

    fn process(&self, next: &mut usize) -> f64 {
        let records = &self.log.records;
        let index = (*next).min(records.len() - 1);
        *next += 1;
        (records[index].reference - records[0].position) * self.per_unit
    }
}
