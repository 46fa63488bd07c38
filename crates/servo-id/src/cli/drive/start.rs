use std::time::Instant;

use drive_link::{Command, Ended, Settings, State, Status};

use super::fault;
use super::follow::{Event, follow, samples_in};
use super::home;
use super::status::{change_line, estimates_line, no_first_fit, snapshot_line};
use crate::cli::fault::Fault;
use crate::cli::standard_output::show;
use crate::drive::Client;

/// Time between two lines that are printed, s.
const LINE_INTERVAL: f64 = 0.5;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Stop after this time, s. Without it the run lasts until it ends by itself or this program is interrupted: the
    /// drive then stops after its link timeout.
    #[arg(long = "for", value_name = "S", value_parser = positive, conflicts_with = "leave")]
    time: Option<f64>,
    /// Home the axis first.
    #[arg(long)]
    home: bool,
    /// Leave the drive running unattended; only with a link timeout of 0.
    #[arg(long)]
    leave: bool,
}

impl Arguments {
    pub(super) fn run(&self, client: &mut Client) -> Result<(), Fault> {
        let Settings {
            closed_loop,
            protection,
            ..
        } = client.settings().map_err(fault)?;
        let link_timeout = protection.link_timeout;
        if self.leave {
            may_be_left(link_timeout)?;
            client.start().map_err(fault)?;
            return if self.home { home::run(client) } else { Ok(()) };
        }
        let every = samples_in(LINE_INTERVAL, closed_loop.core.sample_time);
        client.ask(Command::Watch(every)).map_err(fault)?;
        client.start().map_err(fault)?;
        client.keep_alive(link_timeout);
        if self.home {
            home::run(client)?;
        }
        // An output that cannot be written is no reason to leave a running drive alone.
        let mut printed = if link_timeout > 0.0 {
            show!("running; it stops {link_timeout} s after this program has ended")
        } else {
            show!("running; it continues after this program has ended: the link timeout is 0")
        };
        let begin = Instant::now();
        let is_over = |time: f64| begin.elapsed().as_secs_f64() >= time;
        follow(client, |client, event| match event {
            Some(Event::Fault(fault)) => Err(Fault::Other(fault.to_string())),
            Some(Event::Status(status)) if status.state == State::Disabled => Ok(Some(())),
            _ if self.time.is_some_and(is_over) => client.stop().map_err(fault).map(Some),
            Some(Event::Status(Status {
                rejection_reason: Some(rejection_reason),
                ..
            })) => {
                let line = show!("{}", no_first_fit(rejection_reason));
                printed = std::mem::replace(&mut printed, Ok(())).and(line);
                Ok(None)
            }
            Some(Event::Status(status)) => {
                if let Some(line) = change_line(&status) {
                    let line = show!("{line}");
                    printed = std::mem::replace(&mut printed, Ok(())).and(line);
                }
                Ok(None)
            }
            Some(Event::Snapshot(snapshot)) => {
                let line = show!("{}", snapshot_line(&snapshot));
                printed = std::mem::replace(&mut printed, Ok(())).and(line);
                Ok(None)
            }
            _ => Ok(None),
        })?;
        client.ask(Command::Watch(0)).map_err(fault)?;
        let status = client.status().map_err(fault)?;
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

/// Refuses to leave a drive running that stops when its line is silent.
pub(super) fn may_be_left(link_timeout: f64) -> Result<(), Fault> {
    if link_timeout > 0.0 {
        return Err(Fault::Input(format!(
            "--leave: the drive stops when its line is silent for {link_timeout} s; configure it with \
             --link-timeout 0 first, if that is intended"
        )));
    }
    Ok(())
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|&time: &f64| time > 0.0 && time.is_finite())
        .ok_or_else(|| "it must be a number above zero".to_owned())
}
