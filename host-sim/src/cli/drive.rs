mod commission;
mod monitor;
mod simulate;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use clap::Subcommand;
use drive_link::{
    Command, Ended, Estimates, PROTOCOL, Refusal, Report, Settings, Snapshot, State, Status,
};

use identifier_core::parameters::ServoParameters;

use super::fault::Fault;
use super::files::{Files, Output};
use super::interruption;
use super::standard_output::say;
use crate::drive::{Client, DriveError, loop_settings};
use crate::port::Port;
use crate::scenario::{ExcitationSettings, Purpose, Scenario};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Where the drive is: a serial device, or tcp:HOST:PORT for an emulated or a simulated drive.
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// What the drive does, what it knows and how it is set.
    Status,
    /// Give the drive the loop of a scenario; the servo must be let go.
    Configure(Configure),
    /// Close the loop where the servo stands, identify, and look on until the run ends.
    Start(Start),
    /// Send the servo to a place, rad from where it started.
    #[command(allow_negative_numbers = true, alias = "aim")]
    Target {
        /// Where to.
        radians: f64,
    },
    /// Let the servo go.
    Stop,
    /// Forget a fault, if its cause is gone.
    Clear,
    /// Keep settings and estimates through a loss of power; the servo must be let go.
    Save,
    /// Look on for a while.
    Watch(Watch),
    /// Let the drive come to know its servo within the limits of a scenario, tune itself, prove it and keep
    /// it, and look on; a loop that runs goes on at the end.
    Commission(commission::Arguments),
    /// See and operate the drive in the terminal: signals, estimates and state as they come; start, stop,
    /// target, commission, record.
    Monitor(monitor::Arguments),
    /// Be a drive without hardware: the firmware's logic in real time against the servo of a scenario, at
    /// a TCP port.
    Simulate(simulate::Arguments),
}

#[derive(Debug, clap::Args)]
struct Start {
    /// Stop after so long, s; without it the run goes on until it ends by itself or this program is
    /// interrupted: the drive then comes to rest as soon as the line was silent for its link timeout.
    #[arg(long = "for", value_name = "S", value_parser = positive, conflicts_with = "leave")]
    time: Option<f64>,
    /// Leave the drive running without anybody who looks on; only where its link timeout is 0.
    #[arg(long)]
    leave: bool,
}

#[derive(Debug, clap::Args)]
struct Configure {
    /// The scenario: controller, amplifier, encoder and identifier; a `prbs` excitation is its
    /// dither, with `none` it has none, and any other is refused.
    scenario: PathBuf,
    /// Largest position error, rad: at least three amplitudes of the dither.
    #[arg(long, value_name = "RAD")]
    following_error: Option<f64>,
    /// Largest distance from where the servo started, rad: at least two amplitudes of the dither.
    #[arg(long, value_name = "RAD")]
    travel: Option<f64>,
    /// How fast it is sent to a target, rad/s.
    #[arg(long, value_name = "RAD/S")]
    pace: Option<f64>,
    /// Largest speed, rad/s.
    #[arg(long, value_name = "RAD/S")]
    speed: Option<f64>,
    /// The change of the command that must move the servo, as a part of its limit.
    #[arg(long, value_name = "PART")]
    breakaway: Option<f64>,
    /// How long such a command may act without moving the servo, s.
    #[arg(long, value_name = "S", alias = "silence")]
    stall_time: Option<f64>,
    /// The longest run, s; 0 for one without end.
    #[arg(long, value_name = "S")]
    duration: Option<f64>,
    /// How long the line may be silent in a run, s; 0 for ever.
    #[arg(long, value_name = "S")]
    link_timeout: Option<f64>,
    /// How long a run may take to come to rest at its end, s.
    #[arg(long, value_name = "S")]
    stop_time: Option<f64>,
}

#[derive(Debug, clap::Args)]
struct Watch {
    /// Samples from one report to the next.
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..))]
    every: u16,
    /// Reports to look at.
    #[arg(long, value_name = "N", default_value_t = 100)]
    reports: u32,
    /// Write them to this file, one row each; `-` is standard output. However the watch ends, the rows
    /// up to there are kept.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Replace a file that is there already.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    if let Verb::Simulate(simulate) = &arguments.verb {
        return simulate.run();
    }
    let Some(port) = &arguments.port else {
        return Err(Fault::Input(
            "say where the drive is: drive --port PORT …, a serial device as /dev/ttyUSB0, or \
             tcp:HOST:PORT; `drive simulate` is a drive without hardware"
                .to_owned(),
        ));
    };
    // A file that cannot be written is told before anything is said to the drive.
    let table = match &arguments.verb {
        Verb::Watch(watch) => watch.begin()?,
        _ => None,
    };
    let monitor = match &arguments.verb {
        Verb::Monitor(monitor) => Some(monitor.prepared()?),
        _ => None,
    };
    let line = Port::open(port).map_err(|error| Fault::Input(error.to_string()))?;
    let mut client = Client::new(line);
    let status = client.status().map_err(fault)?;
    if status.protocol != PROTOCOL {
        return Err(Fault::Other(format!(
            "the drive speaks version {} of the protocol and this program version {PROTOCOL}: flash \
             the firmware of this version",
            status.protocol
        )));
    }
    if let Some(monitor) = monitor {
        return monitor.run(client, status, port);
    }
    match &arguments.verb {
        Verb::Status => {
            let settings = client.settings().map_err(fault)?;
            show(&status, &settings)
        }
        Verb::Configure(wanted) => {
            let settings = wanted.settings(client.settings().map_err(fault)?)?;
            client.ask(Command::Configure(settings)).map_err(fault)
        }
        Verb::Start(start) => start.run(&mut client),
        Verb::Target { radians } => client.ask(Command::Target(*radians)).map_err(fault),
        Verb::Stop => client.ask(Command::Stop).map_err(fault),
        Verb::Clear => client.ask(Command::Clear).map_err(fault),
        Verb::Save => client.ask(Command::Save).map_err(fault),
        Verb::Watch(watch) => watch.run(&mut client, table),
        Verb::Commission(commission) => commission.run(&mut client, &status),
        // Done above: neither asks the drive one thing only.
        Verb::Monitor(_) | Verb::Simulate(_) => Ok(()),
    }
}

impl Configure {
    /// The drive's settings with what is asked for.
    fn settings(&self, now: Settings) -> Result<Settings, Fault> {
        let scenario = Scenario::load(&self.scenario, Purpose::Run)?;
        let mut settings = of_scenario(&self.scenario, &scenario, now)?;
        let protection = &mut settings.protection;
        for (place, given) in [
            (&mut protection.following_error, self.following_error),
            (&mut protection.travel, self.travel),
            (&mut protection.pace, self.pace),
            (&mut protection.speed, self.speed),
            (&mut protection.breakaway, self.breakaway),
            (&mut protection.stall_time, self.stall_time),
            (&mut protection.duration, self.duration),
            (&mut protection.link_timeout, self.link_timeout),
            (&mut protection.stop_time, self.stop_time),
        ] {
            *place = given.unwrap_or(*place);
        }
        Ok(settings)
    }
}

/// A drive's settings with the loop and the dither of a scenario, which was read from a file.
fn of_scenario(file: &Path, scenario: &Scenario, now: Settings) -> Result<Settings, Fault> {
    let closed_loop = loop_settings(scenario).map_err(|error| Fault::of_scenario(file, error))?;
    let mut settings = Settings { closed_loop, ..now };
    match scenario.excitation {
        ExcitationSettings::Prbs {
            amplitude, hold, ..
        } => {
            settings.dither.amplitude = amplitude;
            settings.dither.hold = hold;
        }
        ExcitationSettings::None => settings.dither.amplitude = 0.0,
        _ => {
            let fault = "excitation.kind: the drive has \"prbs\" and \"none\"";
            return Err(Fault::of_scenario(file, fault));
        }
    }
    Ok(settings)
}

impl Start {
    /// Time between two lines that are printed, s.
    const OFTEN: f64 = 0.5;

    /// How long a drive may say nothing at all, s: it is asked several times within that.
    const LONGEST_PAUSE: f64 = 4.0;

    fn run(&self, client: &mut Client) -> Result<(), Fault> {
        let Settings {
            closed_loop,
            protection,
            ..
        } = client.settings().map_err(fault)?;
        let link_timeout = protection.link_timeout;
        if self.leave {
            if link_timeout > 0.0 {
                return Err(Fault::Input(format!(
                    "--leave: the drive stops when its line is silent for {link_timeout} s; configure it \
                     with --link-timeout 0 first, if that is what you want"
                )));
            }
            return client.start().map_err(fault);
        }
        let every = (Self::OFTEN / closed_loop.core.sample_time).clamp(1.0, f64::from(u16::MAX));
        client.ask(Command::Watch(every as u16)).map_err(fault)?;
        client.start().map_err(fault)?;
        client.keep_alive(if link_timeout > 0.0 {
            link_timeout
        } else {
            Self::LONGEST_PAUSE
        });
        // What cannot be said is no reason to leave a running drive alone.
        let mut said = if link_timeout > 0.0 {
            say!("running; it comes to rest when this program has ended for {link_timeout} s")
        } else {
            say!("running, also when this program has ended: the link timeout is 0")
        };
        let begun = Instant::now();
        let mut heard = begun;
        loop {
            let left = self
                .time
                .map_or(f64::INFINITY, |time| time - begun.elapsed().as_secs_f64());
            if left <= 0.0 {
                client.ask(Command::Stop).map_err(fault)?;
                break;
            }
            let patience = Duration::from_secs_f64(left.min(1.0));
            match client.next_within(patience, seen).map_err(fault)? {
                Some(Seen::Sample(snapshot)) => said = said.and(say!("{}", line(&snapshot))),
                Some(Seen::Fault(fault)) => return Err(Fault::Other(fault.to_string())),
                Some(Seen::Ended) => break,
                Some(Seen::Running) => {}
                None if heard.elapsed().as_secs_f64() > Self::LONGEST_PAUSE => {
                    return Err(Fault::Other(
                        "the drive is silent: is it switched on, and its line connected?"
                            .to_owned(),
                    ));
                }
                None => continue,
            }
            heard = Instant::now();
        }
        client.ask(Command::Watch(0)).map_err(fault)?;
        let status = client.status().map_err(fault)?;
        if let Some(estimates) = &status.estimates {
            said = said.and(say!("knows: {}", found(estimates)));
        }
        match &status.ended {
            Some(Ended::Faulted(fault)) => Err(Fault::Other(fault.to_string())),
            Some(ended) => said.and(say!("{ended}")),
            None => Err(Fault::Other(
                "the drive knows of no run: it was switched off or reset meanwhile".to_owned(),
            )),
        }
    }
}

/// What a report says to somebody who looks on.
enum Seen {
    Sample(Snapshot),
    Fault(drive_link::Fault),
    Running,
    Ended,
}

fn seen(report: &Report) -> Option<Seen> {
    match report {
        Report::Snapshot(snapshot) => Some(Seen::Sample(*snapshot)),
        Report::Fault(fault) => Some(Seen::Fault(*fault)),
        Report::Status { status, .. } => Some(match status.state {
            State::Running | State::Commissioning => Seen::Running,
            State::Released => Seen::Ended,
            State::Faulted(fault) => Seen::Fault(fault),
        }),
        _ => None,
    }
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|&time: &f64| time > 0.0 && time.is_finite())
        .ok_or_else(|| "it must be a number above zero".to_owned())
}

impl Watch {
    /// How long a report may be late, s.
    const PATIENCE: f64 = 5.0;

    /// How long an interruption may have to wait, s.
    const ATTENTION: Duration = Duration::from_millis(100);

    /// Begins the file, if one is asked for.
    fn begin(&self) -> Result<Option<Table>, Fault> {
        let file = Files::reading(&[], self.force).output(self.csv.as_deref())?;
        file.map(Table::begin).transpose()
    }

    fn run(&self, client: &mut Client, mut table: Option<Table>) -> Result<(), Fault> {
        let Settings {
            closed_loop,
            protection,
            ..
        } = client.settings().map_err(fault)?;
        let step = f64::from(self.every) * closed_loop.core.sample_time;
        client.keep_alive(protection.link_timeout);
        client.ask(Command::Watch(self.every)).map_err(fault)?;
        let ended = self.look_on(client, step, table.as_mut());
        // However it ended, the rows up to there are worth keeping.
        let kept = table.map_or(Ok(()), Table::keep);
        let left = ended?;
        kept?;
        client.ask(Command::Watch(0)).map_err(fault)?;
        if left > 0 {
            return Err(Fault::Other(format!(
                "stopped after {} of {} reports",
                self.reports - left,
                self.reports
            )));
        }
        Ok(())
    }

    /// Shows reports that come every `step` seconds, and answers with how many were still to come when
    /// somebody asked for an end.
    fn look_on(
        &self,
        client: &mut Client,
        step: f64,
        mut table: Option<&mut Table>,
    ) -> Result<u32, Fault> {
        let patience = Duration::from_secs_f64(Self::PATIENCE + step);
        let stop = interruption::end_requested();
        let mut left = self.reports;
        let mut until = Instant::now() + patience;
        while left > 0 && !stop.load(Ordering::Relaxed) {
            let wait = until.saturating_duration_since(Instant::now());
            if wait.is_zero() {
                return Err(fault(DriveError::Silent));
            }
            match client
                .next_within(wait.min(Self::ATTENTION), seen)
                .map_err(fault)?
            {
                Some(Seen::Sample(snapshot)) => {
                    left -= 1;
                    until = Instant::now() + patience;
                    match &mut table {
                        Some(table) => table.row(&snapshot)?,
                        None => say!("{}", line(&snapshot))?,
                    }
                }
                Some(Seen::Fault(fault)) => return Err(Fault::Other(fault.to_string())),
                Some(Seen::Running) | None => {}
                Some(Seen::Ended) => {
                    return Err(Fault::Other(
                        "the servo is let go: there is nothing to look at".to_owned(),
                    ));
                }
            }
        }
        Ok(left)
    }
}

/// A table of snapshots.
struct Table {
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
                    a,
                    b,
                    coulomb,
                    load,
                    ..
                },
        } = snapshot;
        let row = format!(
            "{sample},{reference},{position},{command},{output_error},{a},{b},{coulomb},{load}\n"
        );
        self.file.bytes(row.as_bytes())?;
        // Somebody may look on at the other end of a pipe.
        let flushed = self.file.flush();
        flushed.map_err(|error| self.file.unwritable(&error))?;
        self.rows += 1;
        Ok(())
    }

    /// A table without a row is none.
    fn keep(self) -> Result<(), Fault> {
        if self.rows > 0 {
            self.file.commit()
        } else {
            Ok(())
        }
    }
}

fn line(snapshot: &Snapshot) -> String {
    format!(
        "sample {}: reference {:.4}, position {:.4} rad, command {:.3}; {}",
        snapshot.sample,
        snapshot.reference,
        snapshot.position,
        snapshot.command,
        found(&snapshot.estimates)
    )
}

fn found(estimates: &Estimates) -> String {
    let Estimates {
        a,
        b,
        coulomb,
        load,
        at_bounds,
        standard_errors,
    } = estimates;
    let told = |bound: bool, error: fn(&ServoParameters) -> f64, digits: usize| match (
        bound,
        standard_errors,
    ) {
        (true, _) => " (at a bound)".to_owned(),
        (false, Some(errors)) => format!(" ± {:.digits$}", error(errors)),
        (false, None) => String::new(),
    };
    format!(
        "a {a:.4}{} 1/s, b {b:.3}{} rad/s²/u, coulomb {coulomb:.3}{} rad/s², load {load:.3}{} rad/s²",
        told(at_bounds.a, |errors| errors.a, 4),
        told(at_bounds.b, |errors| errors.b, 3),
        told(at_bounds.coulomb, |errors| errors.coulomb, 3),
        told(at_bounds.load, |errors| errors.load, 3)
    )
}

fn show(status: &Status, settings: &Settings) -> Result<(), Fault> {
    match status.state {
        State::Released => say!("released: the servo is let go")?,
        State::Running => say!("running: the loop is closed")?,
        State::Commissioning => say!("commissioning: it moves on its own")?,
        State::Faulted(fault) => say!("{fault}")?,
    }
    match &status.estimates {
        Some(estimates) => say!("knows: {}", found(estimates))?,
        None => say!("knows nothing of its servo yet")?,
    }
    if !status.configured {
        say!("not configured: it does not start; what follows is an example")?;
    }
    if let Some(ended) = &status.ended {
        say!("{ended}")?;
    }
    if let Some(gains) = &status.gains {
        say!("gains: {gains}")?;
    }
    if let Some(commissioning) = &status.commissioning {
        say!("commissioning: {commissioning}")?;
    }
    let noticed = &status.noticed;
    say!(
        "first fits {}, steps of the load {}, samples not followed {}, friction lowered {}, model restarted {}",
        noticed.started,
        noticed.load_steps,
        noticed.not_following,
        noticed.friction_lowered,
        noticed.restarted
    )?;
    say!("{}", status.kept)?;
    say!(
        "late samples {}, samples not shown {}, frames not understood {}",
        status.overruns,
        status.dropped,
        status.garbled
    )?;
    say!(
        "{:.1} µs from the reading of the encoder to the change of the output",
        1e6 * status.command_delay
    )?;
    say!("{settings}")
}

fn fault(error: DriveError) -> Fault {
    match error {
        DriveError::Refused(Refusal::Setting(_) | Refusal::TooFar { .. }) => {
            Fault::Input(error.to_string())
        }
        other => Fault::Other(other.to_string()),
    }
}
