//! The recorded reference as an excitation.

use identifier_core::excitation::Excitation;

use identifier_log::log::Log;

/// Plays the recorded reference, machine units from the first position; holds its last value.
pub(super) struct RecordedReference<'a> {
    references: &'a [f64],
    first: f64,
    per_unit: f64,
}

impl<'a> RecordedReference<'a> {
    /// The reference of a log, if it has one, in position units, `per_unit` of them per rad.
    pub(super) fn new(log: &'a Log, per_unit: f64) -> Option<Self> {
        let references = log.references();
        (!references.is_empty()).then_some(Self {
            references,
            first: log.first().position,
            per_unit,
        })
    }
}

impl Excitation<f64> for RecordedReference<'_> {
    type State = usize;

    fn start(&self) -> usize {
        0
    }

    fn process(&self, next: &mut usize) -> f64 {
        let index = (*next).min(self.references.len() - 1);
        *next += 1;
        (self.references[index] - self.first) * self.per_unit
    }
}
