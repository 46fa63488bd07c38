//! The emulated drive for hours of its own time, every sample shown.

use std::error::Error;
use std::time::Instant;

use drive_link::{Command, Report, Snapshot, State};
use host_sim::drive::Client;

use crate::{emulator, firmware};

/// The time from one sign of life to the next, s of the drive.
const SIGN_OF_LIFE: f64 = 5.0;

/// Runs the drive for so many hours at 1 kHz: no sample may be late, be lost on the way, or be missing
/// in the row.
pub(crate) fn check(hours: f64) -> Result<(), String> {
    firmware::build(&["drive"], &["emulator"])?;
    let folder = std::env::temp_dir().join(format!("drive-{}", std::process::id()));
    let (running, port) = emulator::Running::start_beside(&firmware::path("drive"), &folder)?;
    let done = run(&mut Client::new(port), hours).map_err(|error| error.to_string());
    drop(running);
    let _ = std::fs::remove_dir_all(&folder);
    done
}

fn run(drive: &mut Client, hours: f64) -> Result<(), Box<dyn Error>> {
    let mut settings = drive.settings()?;
    // Seconds of the drive; the signs of life are counted in its samples.
    settings.protection.link_timeout = 60.0;
    // A cast saturates, and makes zero of what is no number.
    let samples_of = |time: f64| (time / settings.closed_loop.core.sample_time) as u32;
    let samples = samples_of(hours * 3600.0);
    let sign_of_life = samples_of(SIGN_OF_LIFE).max(1);
    if samples < sign_of_life {
        return Err(format!(
            "--hours {hours} is {samples} samples: less than {sign_of_life} show nothing"
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
        if now.sample.is_multiple_of(sign_of_life) {
            drive.say(Command::Hello)?;
        }
        if now.sample >= samples {
            break;
        }
    }
    drive.ask(Command::Stop)?;
    drive.ask(Command::Watch(0))?;
    let status = drive.status()?;
    let b = last.map_or(0.0, |last| last.estimates.b);
    println!(
        "{samples} samples ({hours} h) in {:.0} s: late {}, not told {}, missing in the row {missing}, \
         frames not understood {}; b {b:.2}",
        begun.elapsed().as_secs_f64(),
        status.overruns,
        status.dropped,
        status.garbled
    );
    let is_whole = status.overruns == 0 && status.dropped == 0 && missing == 0;
    if is_whole && status.state == State::Released && status.garbled == 0 {
        Ok(())
    } else {
        Err("the drive was late, or something got lost".into())
    }
}
