//! `servo-id drive monitor`: a drive in the terminal.

mod recordings;
mod screen;
mod session;

use std::path::PathBuf;

use drive_link::Status;

use self::recordings::Recordings;
use self::screen::Screen;
use self::session::{End, Session};
use super::afterwards;
use super::plan::Plan;
use super::start::at_end;
use crate::cli::fault::Fault;
use crate::cli::interruption;
use crate::cli::standard_output::show;
use crate::drive::{Client, Driven};
use crate::monitor::{Link, LinkError};

/// Shortest time from one frame to the next by default, s.
const FRAME_TIME: f64 = 1e-3;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// A scenario whose [commission] limits a commissioning; without it the monitor cannot commission.
    #[arg(long, value_name = "SCENARIO.toml")]
    scenario: Option<PathBuf>,
    /// File of a recording, next to it a scenario for `identify`; further recordings are numbered.
    #[arg(long, value_name = "FILE.csv", default_value = "recording.csv")]
    record: PathBuf,
    /// Samples from one frame to the next; by default the fewest that give at most 1000 frames per second.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    every: Option<u16>,
    /// Leave the drive running at the end; only with a link timeout of 0, which needs it. By default the servo is disabled.
    #[arg(long)]
    leave: bool,
}

impl Arguments {
    /// Checks terminal and scenario before the first message to the drive.
    pub(super) fn prepare(&self) -> Result<Option<Plan>, Fault> {
        screen::must_be_there()?;
        self.scenario.as_deref().map(Plan::read).transpose()
    }

    pub(super) fn run(
        &self,
        plan: Option<Plan>,
        mut client: Client,
        status: Status,
        port: &str,
    ) -> Result<(), Fault> {
        let settings = client.settings()?;
        let link_timeout = settings.protection.link_timeout;
        let at_end = at_end(self.leave, link_timeout)?;
        let sample_time = settings.closed_loop.core.sample_time;
        let least = (FRAME_TIME / sample_time).clamp(1.0, f64::from(u16::MAX));
        let every = self.every.unwrap_or(least.round() as u16);
        let plan = plan
            .map(|plan| plan.for_drive(&settings, &status))
            .transpose()?;
        let end_requested = interruption::end_requested();
        let mut drive = Driven::new(client, link_timeout, at_end);
        interruption::before_end(drive.last_stop());

        let mut screen = Screen::open()?;
        let link = Link::open(drive, at_end);
        let recordings = Recordings::to(&self.record);
        let mut session = Session::new(port, settings, status, every, link, recordings, plan);
        let ended = session.run(&mut screen, end_requested, at_end);
        // From here on, messages are visible.
        drop(screen);
        conclude(session, ended)
    }
}

/// Ends the servo's motion, then the files, and prints how both ended.
fn conclude(session: Session, ended: Result<(), End>) -> Result<(), Fault> {
    let (link, mut recordings, state) = (session.link, session.recordings, session.state);
    let lost = |error: LinkError| {
        let link_timeout = state.settings().protection.link_timeout;
        Fault::Other(format!("{error}; {}", afterwards(link_timeout)))
    };
    let servo = match ended {
        Err(End::Lost(error)) => Err(lost(error)),
        Err(End::Screen(error)) => link.close().map_err(lost).and(Err(screen::fault(&error))),
        Ok(()) => link.close().map_err(lost),
    };
    let files = recordings.end();
    match servo {
        Ok(true) => show!("the drive keeps running")?,
        Ok(false) if state.is_driven() => show!("the servo was disabled")?,
        Ok(false) | Err(_) => {}
    }
    if let Ok(Some(kept)) = &files {
        show!("{kept}")?;
    }
    let telemetry = state.telemetry();
    if telemetry.frames() > 0 {
        show!("{} frames, {} lost", telemetry.frames(), telemetry.lost())?;
    }
    match (servo, files) {
        (Ok(_), Ok(_)) => Ok(()),
        (Err(fault), Ok(_)) | (Ok(_), Err(fault)) => Err(fault),
        (Err(servo), Err(files)) => Err(Fault::Other(format!("{servo}; {files}"))),
    }
}
