//! The emulated drive for hours of its own time, with every sample sent to the host.

use std::error::Error;
use std::time::Instant;

use drive_link::{Command, Report, Snapshot, State};
use servo_id::drive::{AtEnd, Client, Driven};

use crate::{emulator, firmware};

/// Longest silence of the host, s of the drive.
const LINK_TIMEOUT: f64 = 60.0;

/// Time between two messages of the host that keep the run alive, s of the drive.
const KEEP_ALIVE: f64 = 5.0;

/// Runs the drive for some hours at 1 kHz. No sample may be late, lost on the line, or missing in the sequence.
pub(crate) fn check(hours: f64) -> Result<(), String> {
    let (_running, port) = emulator::Running::start(&firmware::emulated_drive()?, &[])?;
    run(
        &mut Driven::new(Client::new(port), LINK_TIMEOUT, AtEnd::Stop),
        hours,
    )
    .map_err(|error| error.to_string())
}

fn run(drive: &mut Driven, hours: f64) -> Result<(), Box<dyn Error>> {
    let mut settings = drive.settings()?;
    // Seconds of the drive, like the time between messages.
    settings.protection.link_timeout = LINK_TIMEOUT;
    // A cast saturates, and makes zero of a NaN.
    let samples_of = |time: f64| (time / settings.closed_loop.core.sample_time) as u32;
    let samples = samples_of(hours * 3600.0);
    let keep_alive = samples_of(KEEP_ALIVE).max(1);
    if samples < keep_alive {
        return Err(format!(
            "--hours {hours} is {samples} samples: at least {keep_alive} are needed"
        )
        .into());
    }
    drive.ask(Command::Configure(settings))?;
    drive.ask(Command::Watch(1))?;
    drive.ask(Command::Start)?;
    let begun = Instant::now();
    let mut last: Option<Snapshot> = None;
    let mut missing = 0;
    loop {
        let now = drive.next(|report| match report {
            Report::Snapshot(shown) => Some(Ok(*shown)),
            Report::Fault(fault) => Some(Err(*fault)),
            _ => None,
        })??;
        let step = now.sample - last.map_or(0, |last| last.sample);
        missing += step - 1;
        last = Some(now);
        if now.sample.is_multiple_of(keep_alive) {
            drive.send(Command::KeepAlive)?;
        }
        if now.sample >= samples {
            break;
        }
    }
    drive.stop()?;
    drive.ask(Command::Watch(0))?;
    let status = drive.status()?;
    let b = last.map_or(0.0, |last| last.estimates.servo.b);
    println!(
        "{samples} samples ({hours} h) in {:.0} s: late {}, not sent {}, missing in the sequence {missing}, \
         frames not understood {}; b {b:.2}",
        begun.elapsed().as_secs_f64(),
        status.overruns,
        status.dropped,
        status.garbled
    );
    let is_whole = status.overruns == 0 && status.dropped == 0 && missing == 0;
    if is_whole && status.state == State::Disabled && status.garbled == 0 {
        Ok(())
    } else {
        Err("the drive was late, or samples were lost".into())
    }
}
