//! `servo-id drive home`: the way to the home position.

use drive_link::{Command, Home, State};

use crate::cli::fault::Fault;
use crate::cli::standard_output::show;
use crate::drive::Driven;

/// Drives the axis home and waits until it is there.
pub(super) fn run(drive: &mut Driven) -> Result<(), Fault> {
    drive.ask(Command::Home)?;
    loop {
        let status = drive.status()?;
        match (status.state, status.home) {
            (State::Running, Home::Sought) => {}
            (State::Running, Home::Known) => return show!("{}", status.home),
            (State::Faulted(fault), _) => return Err(Fault::Other(fault.to_string())),
            _ => {
                return Err(Fault::Other(
                    "the run ended before homing was done".to_owned(),
                ));
            }
        }
    }
}
