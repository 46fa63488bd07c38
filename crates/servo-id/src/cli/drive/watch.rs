use std::path::PathBuf;
use std::sync::atomic::Ordering;

use drive_link::{Report, State};

use super::follow::follow;
use super::status::snapshot_line;
use crate::cli::fault::Fault;
use crate::cli::files::Files;
use crate::cli::interruption;
use crate::cli::output_file::Output;
use crate::cli::standard_output::show;
use crate::drive::Client;
use crate::monitor::{Frame, FrameRecording, Taken};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Samples from one report to the next.
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..))]
    every: u16,
    /// Number of reports.
    #[arg(long, value_name = "N", default_value_t = 100)]
    reports: u32,
    /// Write the reports to this file as a log for `identify`, one row each; `-` is standard output. The rows are kept even
    /// if the recording ends with an error.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Replace what this program did not write, too.
    #[arg(long)]
    force: bool,
}

impl Arguments {
    /// Begins the file, if one is requested.
    pub(super) fn begin(&self) -> Result<Option<Output>, Fault> {
        Files::reading(&[], self.force).output(self.csv.as_deref())
    }

    pub(super) fn run(&self, client: &mut Client, file: Option<Output>) -> Result<(), Fault> {
        let settings = client.settings()?;
        let mut log = self.csv.as_ref().zip(file).map(|(name, file)| {
            let log = FrameRecording::new(file, settings, self.every);
            (name, log)
        });
        client.poll();
        client.watch(self.every)?;
        let stop = interruption::end_requested();
        let mut left = self.reports;
        let ended = follow(&mut &mut *client, |_, event| {
            match event {
                Some(Report::Snapshot(snapshot)) if left > 0 => {
                    left -= 1;
                    match &mut log {
                        Some((name, log)) => {
                            let added = log.add(&Frame::Running(snapshot));
                            let taken =
                                added.map_err(|error| Fault::unwritable(name.display(), &error))?;
                            if taken == Taken::Over {
                                return Err(Fault::Other(
                                    "another run has begun: a log is of one".to_owned(),
                                ));
                            }
                        }
                        None => show!("{}", snapshot_line(&snapshot))?,
                    }
                }
                Some(Report::Fault(fault)) => return Err(Fault::Other(fault.to_string())),
                Some(Report::Status { status, .. }) if status.state == State::Disabled => {
                    return Err(Fault::Other(
                        "the servo is disabled: there is nothing to report".to_owned(),
                    ));
                }
                _ => {}
            }
            Ok((left == 0 || stop.load(Ordering::Relaxed)).then_some(()))
        });
        // However it ended, the rows so far are worth keeping.
        let kept = log.and_then(|(_, log)| log.finish());
        let kept = kept.map(|(log, _)| log.commit()).transpose();
        ended?;
        kept?;
        client.watch(0)?;
        if left > 0 {
            return Err(Fault::Other(format!(
                "stopped after {} of {} reports",
                self.reports - left,
                self.reports
            )));
        }
        Ok(())
    }
}
