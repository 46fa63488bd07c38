//! What commissions a servo, here or on a chip.

use std::convert::Infallible;

use drive_link::NoGains;
use identifier_core::commission::{CommissionInputs, CommissionReading, SynchronousCommission};
use identifier_core::number::Number;

/// Both halves of a commissioning, one sample after the other.
pub trait Commissioner {
    /// Why it does no further sample.
    type Error;

    /// A sample: what the interrupt's half does, and after it the slices of the study that go with it.
    ///
    /// # Errors
    /// Why it is not done.
    fn sample(&mut self, seen: &CommissionInputs) -> Result<CommissionReading, Self::Error>;

    /// Why it found no gains, if that is why it has ended, and which would do.
    fn no_gains(&self) -> Option<NoGains>;
}

/// The firmware's machine, here.
impl<N: Number, const W: usize> Commissioner for SynchronousCommission<N, W> {
    type Error = Infallible;

    fn sample(&mut self, seen: &CommissionInputs) -> Result<CommissionReading, Infallible> {
        Ok(Self::sample(self, seen))
    }

    fn no_gains(&self) -> Option<NoGains> {
        let error = self.state()?.tuning_error()?;
        Some(NoGains::from(error))
    }
}
