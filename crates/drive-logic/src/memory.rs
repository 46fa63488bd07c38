use crate::commissioning::Commissioning;
use crate::run::Run;
use crate::studying::Study;

/// Memory of a drive that is too large for a stack, or that goes to the interrupt and comes back.
#[derive(Debug)]
pub struct Memory {
    pub(crate) run: Option<Run>,
    pub(crate) commissioning: Option<Commissioning>,
    pub(crate) study: Option<Study>,
}

impl Memory {
    /// Never used.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            run: None,
            commissioning: None,
            study: None,
        }
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}
