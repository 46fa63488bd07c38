use super::super::frequency_response::{LineSearch, Lines, ResponsePlanner};
use identifier_core::tuning::{Tuning, TuningError};

/// Frequency-response motions that are being planned: their lines are chosen one a slice, and then each is planned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Planning<N> {
    pub(super) search: LineSearch,
    pub(super) planner: Option<(Lines, ResponsePlanner<N>)>,
    pub(super) is_uncertain: bool,
    pub(super) motions: u8,
    /// The result of the search for gains that asks for them, beside the lines before.
    pub(super) tuned: Option<Tuned>,
}

/// The result of a search for gains, and whether its step was already chosen for the bandwidth that was found.
pub(super) type Tuned = (Result<Tuning, TuningError>, bool);
