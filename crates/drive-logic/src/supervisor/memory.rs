use super::solver::CommissioningSolver;
use crate::built::Part;
use crate::commissioning::Commissioning;
use crate::run::Run;

/// Memory of a drive that is too large for a stack, or that the interrupt borrows and returns.
#[derive(Debug)]
pub struct Memory {
    pub(super) run: Option<Run>,
    pub(super) commissioning: Option<Part<Commissioning>>,
    pub(super) solver: Option<Part<CommissioningSolver>>,
}

impl Memory {
    /// Never used.
    #[must_use]
    pub fn new() -> Self {
        Self {
            run: None,
            commissioning: None,
            solver: Part::of(CommissioningSolver::idle()),
        }
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}

/// Memory in which a mode of the interrupt is built.
pub(super) enum Slot<T: 'static> {
    /// Never used.
    Blank(&'static mut Option<T>),
    /// Back from its use.
    Used(&'static mut T),
}

impl<T> Slot<T> {
    /// Puts this in it. Always inlined: a mode that is passed on is one more on the stack.
    #[inline(always)]
    pub(super) fn fill(&mut self, mode: T) -> &mut T {
        match self {
            Self::Blank(slot) => slot.insert(mode),
            Self::Used(slot) => {
                **slot = mode;
                slot
            }
        }
    }

    /// The mode in it; none if there never was one.
    pub(super) fn into_filled(self) -> Option<&'static mut T> {
        match self {
            Self::Blank(slot) => slot.as_mut(),
            Self::Used(slot) => Some(slot),
        }
    }
}
