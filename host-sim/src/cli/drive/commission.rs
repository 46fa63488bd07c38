//! `servo-id drive commission`: the drive identifies its servo, tunes itself and validates the gains.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use drive_link::{Command, Commissioning, Outcome, Progress, State, Status};
use identifier_core::commission::{HoldingGains, Phase};

use super::fault;
use super::follow::{Event, follow, samples_in};
use super::plan::{DrivePlan, Plan};
use crate::cli::commission::Choices;
use crate::cli::fault::Fault;
use crate::cli::files::{self, Files};
use crate::cli::interruption;
use crate::cli::standard_output::show;
use crate::cli::terminal::{notify, width};
use crate::drive::Client;
use crate::present;
use crate::provenance::ScenarioText;
use crate::render::terminal;
use crate::result::{CommissioningEnd, DriveCommissioningResult};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario: encoder, amplifier and [commission]. A configured drive keeps its own controller, any other
    /// takes the scenario's, if it has one.
    scenario: PathBuf,
    #[command(flatten)]
    choices: Choices,
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long)]
    force: bool,
}

/// Time between two lines of progress, s.
const LINE_INTERVAL: f64 = 0.1;

impl Arguments {
    pub(super) fn run(&self, client: &mut Client, status: &Status) -> Result<(), Fault> {
        let text = ScenarioText::read(&self.scenario)?;
        let plan = Plan::from_text(&self.choices.stated_in(text))?;
        let mut files = Files::reading(&[&self.scenario], self.force);
        let json = files.output(self.json.as_deref())?;
        let silent = files.own_standard_output();

        let settings = client.settings().map_err(fault)?;
        let DrivePlan {
            configure,
            order,
            gains_before,
            largest_motion,
            link_timeout,
        } = plan.for_drive(&settings, status)?;
        if let Some(settings) = configure {
            client.ask(Command::Configure(settings)).map_err(fault)?;
        }
        let before = gains_before.as_ref();
        if !silent {
            show!("{}", present::largest_motion(&largest_motion))?;
        }

        let every = samples_in(LINE_INTERVAL, order.sample_time);
        client.ask(Command::Watch(every)).map_err(fault)?;
        let stop = interruption::end_requested();
        client.commission(&order).map_err(fault)?;
        client.keep_alive(link_timeout);
        show_progress(client, order.sample_time, stop)?;
        let outcome = client.outcome().map_err(fault)?;
        client.ask(Command::Watch(0)).map_err(fault)?;
        let runs_on = client.status().map_err(fault)?.state == State::Running;

        let (time, limits) = (order.sample_time, &order.limits);
        let result = DriveCommissioningResult {
            end: CommissioningEnd::new(time, limits, &largest_motion, before, &outcome),
            kept: outcome.kept,
        };
        files::commit([json.map(|json| json.document(&result))])?;
        if !silent {
            show(before, &outcome)?;
        }
        let end = End {
            gains_before: before.is_some(),
            runs_on,
            link_timeout,
        };
        judged(&end, &outcome, silent)
    }
}

/// Prints the progress on standard error until the commissioning is over; an interruption stops it.
fn show_progress(client: &mut Client, sample_time: f64, stop: &AtomicBool) -> Result<(), Fault> {
    let mut shown = Phase::Idle;
    let mut stopped = false;
    follow(client, |client, event| {
        if stop.load(Ordering::Relaxed) && !stopped {
            stopped = true;
            client.ask(Command::Stop).map_err(fault)?;
            notify("stopping");
        }
        match event {
            Some(Event::Status(status)) if status.state != State::Commissioning => {
                return Ok(Some(()));
            }
            Some(Event::Status(Status { commissioning, .. })) => {
                if let Some(now) = commissioning.filter(|now| now.phase != shown) {
                    shown = now.phase;
                    notify(shown.name());
                }
            }
            Some(Event::Progress(progress)) => notify(&line(&progress, sample_time)),
            Some(Event::Fault(fault)) => {
                notify(&fault.to_string());
                return Ok(Some(()));
            }
            Some(Event::Snapshot(_)) | None => {}
        }
        Ok(None)
    })
}

fn line(progress: &Progress, sample_time: f64) -> String {
    let Progress {
        phase,
        sample,
        position,
        command,
        recorded,
        gain,
    } = progress;
    let time = f64::from(*sample) * sample_time;
    let acts = command.map_or("released".to_owned(), |command| {
        format!("command {command:+.3}")
    });
    let known = match gain {
        Some([b, error]) => format!(", b {b:.2} ± {error:.2}"),
        None if *recorded > 0 => format!(", {recorded} pieces recorded"),
        None => String::new(),
    };
    format!(
        "{time:>9.4} s  {:<15} {position:+.4} rad, {acts}{known}",
        phase.name()
    )
}

fn show(before: Option<&HoldingGains>, outcome: &Outcome) -> Result<(), Fault> {
    let Some(servo) = &outcome.servo else {
        return Ok(());
    };
    let (tuning, trial) = (outcome.tuning.as_ref(), outcome.trial.as_ref());
    let found = present::found_servo(servo, None, before, tuning, trial);
    show!("{}", terminal::blocks(&found, width()))
}

/// The state of the drive after a commissioning.
struct End {
    /// There were gains before.
    gains_before: bool,
    /// The loop that ran before runs again.
    runs_on: bool,
    /// Longest silence of the line then, s; 0 for no limit.
    link_timeout: f64,
}

impl End {
    fn loop_runs_on(&self) -> String {
        if self.link_timeout > 0.0 {
            format!(
                "the loop keeps running, and comes to rest when the line is silent for {} s",
                self.link_timeout
            )
        } else {
            "the loop keeps running".to_owned()
        }
    }
}

fn judged(end: &End, outcome: &Outcome, silent: bool) -> Result<(), Fault> {
    let Commissioning { phase, reason } = outcome.commissioning;
    let applied = reason.is_none() && phase == Phase::Applied;
    let holds = match reason {
        None if applied && outcome.kept => {
            "the new gains hold, and are kept through a loss of power".to_owned()
        }
        None if applied && end.runs_on => format!(
            "the new gains hold, and are kept as soon as the servo is released; {}",
            end.loop_runs_on()
        ),
        None if applied => {
            return Err(Fault::Other(
                "applied, but the flash did not take them: the new gains hold until the power is lost; try \
                 `save`"
                    .to_owned(),
            ));
        }
        _ if end.runs_on => format!("the gains before hold; {}", end.loop_runs_on()),
        _ if end.gains_before => "the gains before hold".to_owned(),
        _ => "the servo is released, without gains".to_owned(),
    };
    if applied {
        if !silent {
            show!("applied: {holds}")?;
        }
        return Ok(());
    }
    let why = match reason {
        Some(reason) => present::why(reason, outcome.no_gains.as_ref(), outcome.noise),
        None => "it did not end by itself".to_owned(),
    };
    Err(Fault::Other(format!("{}: {why} ({holds})", phase.name())))
}
