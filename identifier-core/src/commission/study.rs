use super::{Answer, CommissionError, CommissionSettings, Finding};
use crate::number::Number;

/// The background's half of a commissioning: it fits, verifies and tunes, a slice at a time. W is the
/// number of blocks of its record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Study<N, const W: usize = 256> {
    settings: CommissionSettings,
    number: core::marker::PhantomData<N>,
}

impl<N: Number, const W: usize> Study<N, W> {
    /// For a commissioning with these settings.
    ///
    /// # Errors
    /// As [`Commission::new`](super::Commission::new).
    pub fn new(settings: &CommissionSettings) -> Result<Self, CommissionError> {
        settings.limits.check()?;
        Ok(Self {
            settings: *settings,
            number: core::marker::PhantomData,
        })
    }

    /// Takes what the interrupt has found.
    pub fn take(&mut self, _finding: &Finding<N>) {
        let _ = self.settings;
    }

    /// A slice of work: at most a block of a pass, a point of the frequency response, or a sample of a
    /// predicted step. Returns an answer when there is one.
    pub fn work(&mut self) -> Option<Answer> {
        None
    }
}
