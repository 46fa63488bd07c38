//! `servo-id drive monitor`: a drive in the terminal.

mod plan;
mod recordings;
mod screen;
mod session;

use std::path::PathBuf;

use drive_link::Status;

use self::plan::Plan;
use self::recordings::Recordings;
use self::screen::Screen;
use self::session::{End, Session};
use super::fault;
use crate::cli::fault::Fault;
use crate::cli::interruption;
use crate::cli::standard_output::say;
use crate::drive::Client;
use crate::monitor::{AtEnd, Ending, Link, LinkError};

/// The shortest time from one frame to the next that is asked for by itself, s.
const FRAME_TIME: f64 = 1e-3;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// A scenario whose [commission] says within which limits the servo may be commissioned; without it,
    /// it is not.
    #[arg(long, value_name = "SCENARIO.toml")]
    scenario: Option<PathBuf>,
    /// Where a recording goes, with a scenario for `replay` beside it; the next ones get numbers.
    #[arg(long, value_name = "FILE.csv", default_value = "recording.csv")]
    record: PathBuf,
    /// Samples from one frame to the next; without it as few as give 1000 frames a second at most.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    every: Option<u16>,
    /// Leave the drive running at the end; only where its link timeout is 0. Without it, leaving lets the
    /// servo go.
    #[arg(long)]
    leave: bool,
}

/// A monitor that can begin.
#[derive(Debug)]
pub(super) struct Prepared<'a> {
    arguments: &'a Arguments,
    plan: Option<Plan>,
}

impl Arguments {
    /// Checks what can be checked before anything is said to the drive.
    pub(super) fn prepared(&self) -> Result<Prepared<'_>, Fault> {
        screen::must_be_there()?;
        let plan = self.scenario.as_deref().map(Plan::of).transpose()?;
        Ok(Prepared {
            arguments: self,
            plan,
        })
    }
}

impl Prepared<'_> {
    pub(super) fn run(self, mut client: Client, status: Status, port: &str) -> Result<(), Fault> {
        let Self { arguments, plan } = self;
        let settings = client.settings().map_err(fault)?;
        let link_timeout = settings.protection.link_timeout;
        if arguments.leave && link_timeout > 0.0 {
            return Err(Fault::Input(format!(
                "--leave: the drive stops when its line is silent for {link_timeout} s; configure it with \
                 --link-timeout 0 first, if that is what you want"
            )));
        }
        let sample_time = settings.closed_loop.core.sample_time;
        let least = (FRAME_TIME / sample_time).clamp(1.0, f64::from(u16::MAX));
        let every = arguments.every.unwrap_or(least.round() as u16);
        let plan = plan
            .map(|plan| plan.for_drive(&settings, &status))
            .transpose()?;
        let at_end = if arguments.leave {
            AtEnd::Leave
        } else {
            AtEnd::Stop
        };
        let asked_to_end = interruption::end_requested();

        let mut screen = Screen::open()?;
        let link = Link::open(client, link_timeout, at_end);
        let recordings = Recordings::to(&arguments.record);
        let mut session = Session::new(port, settings, status, every, link, recordings, plan);
        let ended = session.go_on(&mut screen, asked_to_end, at_end);
        // From here on, messages are seen.
        drop(screen);
        conclude(session, ended)
    }
}

/// Sees to the servo, then to the files, and says what became of both.
fn conclude(session: Session, ended: Result<(), End>) -> Result<(), Fault> {
    let Session {
        link,
        mut recordings,
        state,
        ..
    } = session;
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
        Ok(Ending::Stopped) => say!("the servo was let go")?,
        Ok(Ending::Left) => say!("the drive goes on")?,
        Ok(Ending::WasLetGo) | Err(_) => {}
    }
    if let Ok(Some(kept)) = &files {
        say!("{kept}")?;
    }
    let telemetry = state.telemetry();
    if telemetry.frames() > 0 {
        say!("{} frames, {} lost", telemetry.frames(), telemetry.lost())?;
    }
    match (servo, files) {
        (Ok(_), Ok(_)) => Ok(()),
        (Err(fault), Ok(_)) | (Ok(_), Err(fault)) => Err(fault),
        (Err(servo), Err(files)) => Err(Fault::Other(format!("{servo}; {files}"))),
    }
}

/// What a drive does that hears nobody any more.
fn afterwards(link_timeout: f64) -> String {
    if link_timeout > 0.0 {
        format!("if it is still there, it comes to rest by itself after {link_timeout} s")
    } else {
        "if it is still there, it goes on: its link timeout is 0".to_owned()
    }
}
