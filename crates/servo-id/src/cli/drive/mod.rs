//! The verbs of `drive`: the host's end of a drive's serial line.

mod board_test;
mod commission;
mod configure;
mod follow;
mod home;
mod monitor;
mod plan;
mod simulate;
mod start;
mod status;
mod watch;

use clap::Subcommand;
use drive_link::{Command, Refusal};

use super::fault::Fault;
use crate::drive::{Client, DriveError};
use crate::port::Port;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The drive's port: a serial device, or tcp:HOST:PORT for an emulated or a simulated drive.
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Print the drive's state, estimates and settings.
    Status(status::Arguments),
    /// Compare the bits that the drive's chip computes with this machine's, and print its cycles beside the instructions
    /// of the budget. Nothing moves.
    BoardTest(board_test::Arguments),
    /// Configure the drive with the loop of a scenario; the servo must be disabled.
    Configure(configure::Arguments),
    /// Close the loop at the present position, identify, and print reports until the run ends.
    Start(start::Arguments),
    /// Move the servo to a position, rad from where it started.
    #[command(allow_negative_numbers = true, alias = "aim")]
    Target {
        /// Position, rad from where the servo started.
        radians: f64,
    },
    /// Home the axis: targets and travel then count from its origin. The loop must be closed.
    Home,
    /// Disable the output stage: the servo coasts.
    Stop,
    /// Clear a fault after its cause is removed.
    Clear,
    /// Store settings and estimates in flash; the servo must be disabled.
    Save,
    /// Print or record reports of a run.
    Watch(watch::Arguments),
    /// Commission the drive within the limits of a scenario: it identifies its servo, tunes itself, tests the gains and
    /// stores them. A loop that was running continues.
    Commission(commission::Arguments),
    /// Show and operate the drive in the terminal: signals, estimates and state; start, stop, target,
    /// commission, record.
    Monitor(monitor::Arguments),
    /// Simulate a drive: the firmware's logic in real time with the servo of a scenario, at a TCP port.
    Simulate(simulate::Arguments),
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    if let Verb::Simulate(simulate) = &arguments.verb {
        return simulate.run();
    }
    let Some(port) = &arguments.port else {
        return Err(Fault::Input(
            "the drive's port is missing: drive --port PORT …, a serial device such as /dev/ttyUSB0, or \
             tcp:HOST:PORT; `drive simulate` simulates a drive"
                .to_owned(),
        ));
    };
    // Errors in files and terminal come before the first message to the drive.
    let table = match &arguments.verb {
        Verb::Watch(watch) => watch.begin()?,
        _ => None,
    };
    let plan = match &arguments.verb {
        Verb::Monitor(monitor) => monitor.prepare()?,
        _ => None,
    };
    let line = Port::open(port).map_err(|error| Fault::Input(error.to_string()))?;
    let mut client = Client::new(line);
    let status = client.status().map_err(fault)?;
    match &arguments.verb {
        Verb::Status(verb) => verb.run(&mut client, &status),
        Verb::BoardTest(verb) => verb.run(&mut client, &status),
        Verb::Configure(configure) => configure.run(&mut client),
        Verb::Start(start) => start.run(&mut client),
        Verb::Target { radians } => client.ask(Command::Target(*radians)).map_err(fault),
        Verb::Home => home::run(&mut client),
        Verb::Stop => client.stop().map_err(fault),
        Verb::Clear => client.ask(Command::Clear).map_err(fault),
        Verb::Save => client.ask(Command::Save).map_err(fault),
        Verb::Watch(watch) => watch.run(&mut client, table),
        Verb::Commission(commission) => commission.run(&mut client, &status),
        Verb::Monitor(monitor) => monitor.run(plan, client, status, port),
        // Run above.
        Verb::Simulate(_) => Ok(()),
    }
}

/// A refused setting is bad input; everything else is a failure.
fn fault(error: DriveError) -> Fault {
    match error {
        DriveError::Refused(Refusal::Setting(_) | Refusal::TooFar { .. }) => {
            Fault::Input(error.to_string())
        }
        other => Fault::Other(other.to_string()),
    }
}
