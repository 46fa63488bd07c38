//! The reference of a log as an excitation.

use identifier_core::excitation::Excitation;

use super::Log;

/// Plays the recorded reference, machine units from the first position; holds its last value.
pub(super) struct RecordedReference<'a> {
    log: &'a Log,
    per_unit: f64,
}

impl<'a> RecordedReference<'a> {
    /// That of a log in so many position units per rad, where it has one.
    pub(super) fn new(log: &'a Log, per_unit: f64) -> Option<Self> {
        let has_one = log.records.iter().all(|record| record.reference.is_some());
        has_one.then_some(Self { log, per_unit })
    }
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
        let first = records[0].position;
        (records[index].reference.unwrap_or(first) - first) * self.per_unit
    }
}
