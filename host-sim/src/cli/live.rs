//! `--live`: the report of a run while it lasts, for browsers of this machine.

use std::io::{self, ErrorKind};
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use super::fault::Fault;
use super::{interruption, terminal};
use crate::live::{Server, Update};
use crate::present::{Page, Progress};
use crate::render::html;

/// Time between two versions of the page.
const PERIOD: Duration = Duration::from_millis(400);

/// The options of a live report.
#[derive(Debug, clap::Args)]
pub(super) struct LiveOptions {
    /// Show the report in browsers of this machine during the run, in real time, and afterwards until Ctrl-C.
    /// Standard error shows the address; without a port any free one is taken.
    #[arg(
        long,
        value_name = "PORT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "0"
    )]
    live: Option<u16>,
    /// With --live: speed relative to real time; inf for no limit.
    #[arg(
        long,
        value_name = "X",
        requires = "live",
        default_value = "1",
        value_parser = pace,
        allow_negative_numbers = true
    )]
    pace: f64,
}

fn pace(text: &str) -> Result<f64, String> {
    let pace: f64 = text
        .parse()
        .map_err(|_| "it must be a number above 0, or inf".to_owned())?;
    if pace > 0.0 {
        Ok(pace)
    } else {
        Err(format!(
            "{text} is not allowed: it must be a number above 0, or inf"
        ))
    }
}

/// A run whose report is shown live.
#[derive(Debug)]
pub(super) struct Live {
    server: Server,
    pace: f64,
    begun: Instant,
    shown: Option<Instant>,
}

impl LiveOptions {
    /// Begins to serve, if requested, and prints the address.
    ///
    /// # Errors
    /// If the port is not available.
    pub(super) fn begin(&self) -> Result<Option<Live>, Fault> {
        let Some(port) = self.live else {
            return Ok(None);
        };
        let server = Server::start(port).map_err(|error| unavailable(port, &error))?;
        terminal::notify(&format!(
            "live: http://{}/ shows the run while it goes on (Ctrl-C ends it)",
            server.address()
        ));
        Ok(Some(Live {
            server,
            pace: self.pace,
            begun: Instant::now(),
            shown: None,
        }))
    }
}

fn unavailable(port: u16, error: &io::Error) -> Fault {
    let why = match error.kind() {
        ErrorKind::AddrInUse => "another program uses it".to_owned(),
        ErrorKind::PermissionDenied => "it is not permitted".to_owned(),
        _ => error.to_string(),
    };
    Fault::Other(format!(
        "port {port} of this machine cannot be had: {why}; --live={port} takes another number, and --live alone \
         any port that is free"
    ))
}

impl Live {
    /// Waits until the time of the motion, s, is due, and shows the page then unless the last one is recent.
    pub(super) fn offer(&mut self, motion: f64, page: impl FnOnce() -> Page) {
        /// Shorter sleeps are not exact.
        const MIN_SLEEP: Duration = Duration::from_millis(3);
        let due = Duration::try_from_secs_f64(motion / self.pace).unwrap_or(Duration::ZERO);
        let ahead = due.saturating_sub(self.begun.elapsed());
        if ahead > MIN_SLEEP {
            thread::sleep(ahead);
        }
        if self.shown.is_none_or(|shown| shown.elapsed() >= PERIOD) {
            self.shown = Some(Instant::now());
            self.put(&page(), Progress::Underway);
        }
    }

    /// Shows the final page until an interruption.
    pub(super) fn stay(&self, page: &Page) {
        const LOOK: Duration = Duration::from_millis(50);
        self.put(page, Progress::Over);
        let enough = interruption::end_requested();
        terminal::notify(&format!(
            "live: the run is over; http://{}/ shows its report until Ctrl-C",
            self.server.address()
        ));
        while !enough.load(Ordering::Relaxed) {
            thread::sleep(LOOK);
        }
    }

    fn put(&self, page: &Page, stage: Progress) {
        self.server.show(Update {
            page: html::live_page(page, stage).into(),
            change: html::changes(page, stage).into(),
        });
    }
}
