//! Orders, each of which acts once, by their numbers.

use drive_link::{Refusal, Request};

/// The last order of any host.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Orders {
    last: u32,
    /// The number of its request, and whether it was done.
    request: u8,
    is_done: bool,
}

impl Orders {
    /// The number of the last order.
    pub(super) fn last(&self) -> u32 {
        self.last
    }

    /// Takes in an order; false for one that was done and comes again.
    ///
    /// # Errors
    /// [`Refusal::GivenBefore`].
    pub(super) fn take(&mut self, &Request { id, order, .. }: &Request) -> Result<bool, Refusal> {
        if self.is_done && (order, id) == (self.last, self.request) {
            return Ok(false);
        }
        // Numbers wrap.
        if order.wrapping_sub(self.last).cast_signed() <= 0 {
            return Err(Refusal::GivenBefore);
        }
        (self.last, self.request, self.is_done) = (order, id, false);
        Ok(true)
    }

    /// The last order is done.
    pub(super) fn end(&mut self) {
        self.is_done = true;
    }
}
