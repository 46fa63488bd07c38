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
mod stop;
mod watch;

use clap::Subcommand;
use drive_link::{Command, Home, Refusal, State};

use super::fault::Fault;
use super::interruption;
use super::standard_output::show;
use crate::drive::{AtEnd, Client, DriveError, Driven};
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
    /// Move the servo to a position, rad from home, or from where the run started if homing is not configured.
    #[command(allow_negative_numbers = true, alias = "aim")]
    Target {
        /// Position, rad.
        radians: f64,
        /// Count it from where the run started, whether the axis is homed or not.
        #[arg(long)]
        relative: bool,
    },
    /// Home the axis: targets and travel then count from its origin. The loop must be closed.
    Home,
    /// Disable the output stage: the servo coasts. The stop is sent before anything is asked, also to a drive of another
    /// version.
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
    // Nothing comes before a stop.
    if let Verb::Stop = arguments.verb {
        return stop::run(&mut client);
    }
    let status = client.status()?;
    match &arguments.verb {
        Verb::Status(verb) => verb.run(&mut client, &status),
        Verb::BoardTest(verb) => verb.run(&mut client, &status),
        Verb::Configure(configure) => configure.run(&mut client),
        Verb::Start(start) => driving(client, |drive| start.run(drive)),
        Verb::Target { radians, relative } => driving(client, |drive| {
            let target = match relative {
                true => Command::RelativeTarget(*radians),
                false => Command::Target(*radians),
            };
            drive.ask(target)?;
            drive.leave();
            Ok(())
        }),
        Verb::Home => driving(client, |drive| {
            home::run(drive)?;
            drive.leave();
            Ok(())
        }),
        Verb::Clear => Ok(client.clear()?),
        Verb::Save => match (status.home, client.save()?.home) {
            (Home::Known, Home::Unknown) => {
                show!(
                    "stored; the flash was erased for it, and home is unknown: home the axis again"
                )
            }
            _ => Ok(()),
        },
        Verb::Watch(watch) => watch.run(&mut client, table),
        Verb::Commission(commission) => driving(client, |drive| commission.run(drive, &status)),
        Verb::Monitor(monitor) => monitor.run(plan, client, status, port),
        // Run above.
        Verb::Stop | Verb::Simulate(_) => Ok(()),
    }
}

/// Runs a verb that may move the servo. If it fails, is interrupted or panics, the drive is stopped.
fn driving(
    mut client: Client,
    verb: impl FnOnce(&mut Driven) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let settings = client.settings()?;
    let link_timeout = settings.protection.link_timeout;
    let mut drive = Driven::new(client, link_timeout, AtEnd::Stop);
    drive.end_waits_by(Some(interruption::end_requested()));
    interruption::before_end(drive.last_stop());
    let done = verb(&mut drive);
    let Err(why) = done else { return Ok(()) };
    if !drive.is_to_be_stopped() {
        return Err(why);
    }
    Err(match drive.stop() {
        Ok(status) if status.state == State::Disabled => why.and("the servo is disabled"),
        // It is the reason.
        Ok(_) => why,
        Err(error) => why.and(format!("{error}; {}", afterwards(link_timeout))),
    })
}

/// The behaviour of a drive without a host.
fn afterwards(link_timeout: f64) -> String {
    if link_timeout > 0.0 {
        format!("if it still runs, it stops by itself after {link_timeout} s")
    } else {
        "if it still runs, it keeps running: its link timeout is 0".to_owned()
    }
}

/// A refused setting is bad input; everything else is a failure.
impl From<DriveError> for Fault {
    fn from(error: DriveError) -> Self {
        let kind = match error {
            DriveError::Refused(Refusal::Setting(_) | Refusal::TooFar { .. }) => Self::Input,
            DriveError::Interrupted => Self::Interrupted,
            _ => Self::Other,
        };
        kind(error.to_string())
    }
}
