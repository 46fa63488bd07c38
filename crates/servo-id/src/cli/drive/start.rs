use std::time::Instant;

use drive_link::{Ended, Report, State};

use super::follow::{follow, samples_in};
use super::home;
use super::status::{change_line, estimates_line, no_first_fit, snapshot_line};
use crate::cli::fault::Fault;
use crate::cli::standard_output::show;
use crate::drive::{AtEnd, Driven};

/// Time between two lines that are printed, s.
const LINE_INTERVAL: f64 = 0.5;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Stop after this time, s. Without it the run lasts until it ends by itself or this program is interrupted, which
    /// stops it.
    #[arg(long = "for", value_name = "S", value_parser = positive, conflicts_with = "leave")]
    time: Option<f64>,
    /// Home the axis first.
    #[arg(long)]
    home: bool,
    /// Leave the drive running unattended; only with a link timeout of 0, which needs it.
    #[arg(long)]
    leave: bool,
}

impl Arguments {
    pub(super) fn run(&self, drive: &mut Driven) -> Result<(), Fault> {
        let settings = drive.settings()?;
        let link_timeout = settings.protection.link_timeout;
        if at_end(self.leave, link_timeout)? == AtEnd::Leave {
            drive.start()?;
            if self.home {
                home::run(drive)?;
            }
            drive.leave();
            return Ok(());
        }
        let every = samples_in(LINE_INTERVAL, settings.closed_loop.core.sample_time);
        drive.watch(every)?;
        drive.start()?;
        if self.home {
            home::run(drive)?;
        }
        // An output that cannot be written is no reason to leave a running drive alone.
        let mut printed = show!(
            "running; Ctrl-C stops it, and it stops by itself when the line is silent for {link_timeout} s"
        );
        let begin = Instant::now();
        let is_over = |time: f64| begin.elapsed().as_secs_f64() >= time;
        follow(drive, |drive, event| match event {
            Some(Report::Fault(fault)) => Err(Fault::Other(fault.to_string())),
            Some(Report::Status { status, .. }) if status.state == State::Disabled => Ok(Some(())),
            _ if self.time.is_some_and(is_over) => {
                drive.stop()?;
                Ok(Some(()))
            }
            event => {
                let line = match event {
                    Some(Report::Status { status, .. }) => match status.rejection_reason {
                        Some(reason) => Some(no_first_fit(reason)),
                        None => change_line(&status),
                    },
                    Some(Report::Snapshot(snapshot)) => Some(snapshot_line(&snapshot)),
                    _ => None,
                };
                if let Some(line) = line {
                    let line = show!("{line}");
                    printed = std::mem::replace(&mut printed, Ok(())).and(line);
                }
                Ok(None)
            }
        })?;
        drive.watch(0)?;
        let status = drive.status()?;
        if let Some(estimates) = &status.estimates {
            printed = printed.and(show!("estimates: {}", estimates_line(estimates)));
        }
        match &status.ended {
            Some(Ended::Faulted(fault)) => Err(Fault::Other(fault.to_string())),
            Some(ended) => printed.and(show!("{ended}")),
            None => Err(Fault::Other(
                "the drive reports no run: it was switched off or reset in between".to_owned(),
            )),
        }
    }
}

/// What happens to a driven servo at the end of this program: it is left only where the drive does not stop by itself, and
/// stopped only where the drive stops when this program cannot.
pub(super) fn at_end(leave: bool, link_timeout: f64) -> Result<AtEnd, Fault> {
    match (leave, link_timeout > 0.0) {
        (true, false) => Ok(AtEnd::Leave),
        (false, true) => Ok(AtEnd::Stop),
        (true, true) => Err(Fault::Input(format!(
            "--leave: the drive stops when its line is silent for {link_timeout} s; configure it with \
             --link-timeout 0 first, if that is intended"
        ))),
        (false, false) => Err(Fault::Input(
            "the drive's link timeout is 0: it would run on after this program is killed or its line is cut; configure \
             it with --link-timeout 1, or state --leave, if that is intended"
                .to_owned(),
        )),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|&time: &f64| time > 0.0 && time.is_finite())
        .ok_or_else(|| "it must be a number above zero".to_owned())
}
