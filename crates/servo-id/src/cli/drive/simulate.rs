//! `servo-id drive simulate`: a drive without hardware.

use std::net::SocketAddr;
use std::path::PathBuf;

use drive_link::Settings;
use host_sim::scenario::{Purpose, Scenario};

use super::configure::with_scenario;
use crate::cli::fault::Fault;
use crate::cli::standard_output::{flush, show};
use crate::simulated_drive::{SimulatedDrive, SimulatedDriveError};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario: plant, encoder and amplifier are the servo; its loop configures the drive.
    scenario: PathBuf,
    /// Address to listen at; port 0 takes any free port.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:5760")]
    listen: SocketAddr,
    /// Simulate a new drive, which is not configured.
    #[arg(long)]
    new: bool,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<(), Fault> {
        let scenario = Scenario::load(&self.scenario, Purpose::Run)?;
        let mut drive =
            SimulatedDrive::new(&scenario, self.listen).map_err(|error| self.fault(error))?;
        if !self.new {
            let mut settings = with_scenario(&self.scenario, &scenario, drive.built_in())
                .map_err(|fault| self.hint(fault))?;
            // No machine could be damaged here.
            let Settings {
                dither, protection, ..
            } = &mut settings;
            let room = 4.0 * dither.amplitude;
            protection.following_error = protection.following_error.max(room);
            let [low, high] = protection.travel;
            protection.travel = [low.min(-room), high.max(room)];
            drive = drive.configured(settings);
        }
        let address = drive
            .address()
            .map_err(|error| Fault::unusable(self.listen, &error))?;
        show!("a simulated drive listens at {address} until it is interrupted; watch it with")?;
        show!("servo-id drive --port tcp:{address} monitor")?;
        flush()?;
        drive.run().map_err(|error| self.fault(error))
    }

    fn hint(&self, fault: Fault) -> Fault {
        Fault::Input(format!(
            "{fault}; with --new the drive is not configured, and any scenario with a loop is accepted"
        ))
    }

    fn fault(&self, error: SimulatedDriveError) -> Fault {
        match error {
            SimulatedDriveError::PortInUse(_) => Fault::Other(error.to_string()),
            SimulatedDriveError::Port(..) => Fault::Input(error.to_string()),
            SimulatedDriveError::Scenario(_) | SimulatedDriveError::Refused(_) => {
                Fault::of_file(&self.scenario, error)
            }
        }
    }
}
