use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use drive_link::{Estimates, Snapshot, State};
use identifier_core::parameters::ServoParameters;

use super::fault;
use super::follow::{Event, follow};
use super::status::snapshot_line;
use crate::cli::fault::Fault;
use crate::cli::files::Files;
use crate::cli::interruption;
use crate::cli::output_file::Output;
use crate::cli::standard_output::show;
use crate::drive::Client;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Samples from one report to the next.
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..))]
    every: u16,
    /// Number of reports.
    #[arg(long, value_name = "N", default_value_t = 100)]
    reports: u32,
    /// Write the reports to this file, one row each; `-` is standard output. The rows are kept even if the recording
    /// ends with an error.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long)]
    force: bool,
}

impl Arguments {
    /// Begins the file, if one is requested.
    pub(super) fn begin(&self) -> Result<Option<Table>, Fault> {
        let file = Files::reading(&[], self.force).output(self.csv.as_deref())?;
        file.map(Table::begin).transpose()
    }

    pub(super) fn run(&self, client: &mut Client, mut table: Option<Table>) -> Result<(), Fault> {
        client.poll();
        client.watch(self.every).map_err(fault)?;
        let stop = interruption::end_requested();
        let mut left = self.reports;
        let ended = follow(&mut &mut *client, |_, event| {
            match event {
                Some(Event::Snapshot(snapshot)) if left > 0 => {
                    left -= 1;
                    match &mut table {
                        Some(table) => table.row(&snapshot)?,
                        None => show!("{}", snapshot_line(&snapshot))?,
                    }
                }
                Some(Event::Fault(fault)) => return Err(Fault::Other(fault.to_string())),
                Some(Event::Status(status)) if status.state == State::Disabled => {
                    return Err(Fault::Other(
                        "the servo is disabled: there is nothing to report".to_owned(),
                    ));
                }
                _ => {}
            }
            Ok((left == 0 || stop.load(Ordering::Relaxed)).then_some(()))
        });
        // However it ended, the rows so far are worth keeping.
        let kept = table.map_or(Ok(()), Table::keep);
        ended?;
        kept?;
        client.watch(0).map_err(fault)?;
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

/// A table of snapshots.
pub(super) struct Table {
    file: Output,
    rows: u32,
}

impl Table {
    fn begin(mut file: Output) -> Result<Self, Fault> {
        file.bytes(b"sample,reference,position,command,output_error,a,b,coulomb,load\n")?;
        Ok(Self { file, rows: 0 })
    }

    fn row(&mut self, snapshot: &Snapshot) -> Result<(), Fault> {
        let Snapshot {
            sample,
            reference,
            position,
            command,
            output_error,
            estimates:
                Estimates {
                    servo:
                        ServoParameters {
                            a,
                            b,
                            coulomb,
                            load,
                        },
                    ..
                },
        } = snapshot;
        let row = format!(
            "{sample},{reference},{position},{command},{output_error},{a},{b},{coulomb},{load}\n"
        );
        self.file.bytes(row.as_bytes())?;
        // A reader may follow at the other end of a pipe.
        let flushed = self.file.flush();
        flushed.map_err(|error| self.file.unwritable(&error))?;
        self.rows += 1;
        Ok(())
    }

    /// Keeps the table if it has a row.
    fn keep(self) -> Result<(), Fault> {
        if self.rows > 0 {
            self.file.commit().map(drop)
        } else {
            Ok(())
        }
    }
}
