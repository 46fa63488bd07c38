//! `servo-id drive home`: the way to the home position.

use drive_link::{Command, Home, Settings, State};

use super::fault;
use crate::cli::fault::Fault;
use crate::cli::standard_output::show;
use crate::drive::Client;

/// Drives the axis home and waits until it is there.
pub(super) fn run(client: &mut Client) -> Result<(), Fault> {
    let Settings { protection, .. } = client.settings().map_err(fault)?;
    client.keep_alive(protection.link_timeout);
    client.ask(Command::Home).map_err(fault)?;
    loop {
        // Asking keeps the run alive.
        let status = client.status().map_err(fault)?;
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
