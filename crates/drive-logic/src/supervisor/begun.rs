//! Requests that act once, by their numbers.

use drive_link::Refusal;

/// The numbers of the last requests that began a run or a commissioning. A frame that comes late or twice has one of them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Begun {
    /// Each with the number of requests for which it is remembered.
    requests: [(u8, u8); 4],
}

impl Begun {
    /// Requests after which a host may use a number again: half of all that it has.
    const MEMORY: u8 = 128;

    /// A request was answered.
    pub(super) fn count_request(&mut self) {
        for (_, left) in &mut self.requests {
            *left = left.saturating_sub(1);
        }
    }

    /// A request that is to begin something that is not under way.
    ///
    /// # Errors
    /// [`Refusal::DoneBefore`] if it has begun it already.
    pub(super) fn check(&self, id: u8) -> Result<(), Refusal> {
        let mut remembered = self.requests.iter().filter(|(_, left)| *left > 0);
        if remembered.any(|(begun, _)| *begun == id) {
            Err(Refusal::DoneBefore)
        } else {
            Ok(())
        }
    }

    /// This request has begun something.
    pub(super) fn take(&mut self, id: u8) {
        if let Some(oldest) = self.requests.iter_mut().min_by_key(|(_, left)| *left) {
            *oldest = (id, Self::MEMORY);
        }
    }
}
