use identifier_core::error::StepError;
use identifier_core::parameters::ServoParameters;

use super::{DynIdentifier, Innovation, NO_ESTIMATE};

/// The place of an identifier whose estimates come from the whole record: the command passes through.
pub(crate) struct WholeRecord;

impl DynIdentifier for WholeRecord {
    fn update(&mut self, _: f64, command: f64) -> Result<Innovation, StepError> {
        Ok(Innovation {
            command,
            update: None,
        })
    }

    fn estimates(&self) -> ServoParameters {
        NO_ESTIMATE
    }
}
