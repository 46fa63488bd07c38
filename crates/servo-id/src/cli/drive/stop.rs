//! `servo-id drive stop`: the stop before any question.

use crate::cli::fault::Fault;
use crate::cli::standard_output::show;
use crate::drive::{Client, DriveError};

/// Stops the drive, then prints its state.
pub(super) fn run(client: &mut Client) -> Result<(), Fault> {
    match client.stop() {
        Ok(status) => show!("{}", status.state),
        // Only a question is refused.
        Err(DriveError::Refused(refusal)) => {
            show!("the drive has acknowledged the stop; its state is unknown: {refusal}")
        }
        Err(error) => Err(error.into()),
    }
}
