//! `servo-id drive commission`: a drive comes to know its servo, while somebody looks on.

use std::f64::consts::TAU;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use drive_link::{
    Command, Commissioning, Dither, Format, Law, LoopSettings, Outcome, Progress, Protection,
    Report, Settings, State, Status,
};
use identifier_core::commission::{CommissionIsr, CommissionSettings, HoldingGains, Phase};

use super::fault;
use crate::cli::fault::Fault;
use crate::cli::files::{self, Files};
use crate::cli::interruption;
use crate::cli::standard_output::say;
use crate::drive::{Client, CommissionDocument, DriveError};
use crate::report::commission as report;
use crate::scenario::{Purpose, Scenario};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario: encoder, amplifier and [commission]; a drive that is configured keeps its own
    /// controller, one that is not takes the scenario's, if it has any.
    scenario: PathBuf,
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace a file that is there already.
    #[arg(long)]
    force: bool,
}

/// What is said to somebody who looks on.
enum Seen {
    Stands(State, Option<Commissioning>),
    Progress(Progress),
    Fault(drive_link::Fault),
}

impl Arguments {
    /// Time between two lines of progress, s.
    const OFTEN: f64 = 0.1;

    /// How long a drive may say nothing at all.
    const LONGEST_PAUSE: Duration = Duration::from_secs(5);

    /// How long an interruption may have to wait.
    const ATTENTION: Duration = Duration::from_millis(50);

    pub(super) fn run(&self, client: &mut Client, status: &Status) -> Result<(), Fault> {
        let scenario = Scenario::load(&self.scenario, Purpose::Commission)?;
        let of_scenario = |fault| Fault::of_scenario(&self.scenario, fault);
        let order = scenario.commission_settings().map_err(of_scenario)?;
        let mut files = Files::reading(&[&self.scenario], self.force);
        let json = files.output(self.json.as_deref())?;
        let silent = files.own_standard_output();

        let mut settings = client.settings().map_err(fault)?;
        if !status.configured {
            let gains = scenario.gains_before().map_err(of_scenario)?;
            settings = unconfigured(&settings, &order, gains.as_ref());
            client.ask(Command::Configure(settings)).map_err(fault)?;
        }
        let core = &settings.closed_loop.core;
        for (key, own, wanted) in [
            (
                "encoder.counts_per_rev",
                TAU / core.resolution,
                TAU / order.resolution,
            ),
            (
                "commission.sample_time",
                core.sample_time,
                order.sample_time,
            ),
        ] {
            if (own / wanted - 1.0).abs() > 1e-9 {
                let told = format!(
                    "{key} is {wanted} here, and {own} in the drive: `drive configure` tells it another servo"
                );
                return Err(Fault::of_scenario(&self.scenario, told));
            }
        }
        let before = gains(&settings);
        let mut planned = order;
        planned.command_delay += f64::from(status.command_delay);
        let machine = CommissionIsr::<f32>::new(&planned, before.as_ref())
            .map_err(|error| of_scenario(scenario.fault_of_commission(&error)))?;
        let largest = machine.largest_motion();
        if !silent {
            say!("{}", report::largest_motion(&largest))?;
        }

        let every = (Self::OFTEN / order.sample_time).clamp(1.0, f64::from(u16::MAX));
        client.ask(Command::Watch(every as u16)).map_err(fault)?;
        let stop = interruption::end_requested();
        client.commission(&order).map_err(fault)?;
        client.keep_alive(match settings.protection.link_timeout {
            0.0 => Self::LONGEST_PAUSE.as_secs_f64(),
            link_timeout => link_timeout,
        });
        look_on(client, order.sample_time, stop)?;
        let outcome = client.outcome().map_err(fault)?;
        client.ask(Command::Watch(0)).map_err(fault)?;
        let goes_on = client.status().map_err(fault)?.state == State::Running;

        let document = CommissionDocument::new(&order, &largest, before.as_ref(), &outcome);
        files::commit([json.map(|json| json.document(&document))])?;
        if !silent {
            show(&scenario, before.as_ref(), &outcome)?;
        }
        let end = End {
            gains_before: before.is_some(),
            goes_on,
            link_timeout: settings.protection.link_timeout,
        };
        judged(&end, &outcome, silent)
    }
}

/// The gains that a drive with these settings goes back to.
pub(super) fn gains(settings: &Settings) -> Option<HoldingGains> {
    let core = &settings.closed_loop.core;
    core.controller.map(|controller| HoldingGains {
        controller,
        cutoff: core.cutoff,
    })
}

/// Settings for a drive that nobody has told anything: what it is to measure with, the gains that are known,
/// if any, and protections with as much room as the commissioning has; for the rest the drive's example.
pub(super) fn unconfigured(
    example: &Settings,
    order: &CommissionSettings,
    gains: Option<&HoldingGains>,
) -> Settings {
    let [low, high] = order.limits.travel;
    let travel = 0.5 * (high - low);
    let mut core = identifier_core::Settings {
        resolution: order.resolution,
        ..identifier_core::Settings::new(order.sample_time, 1.0)
    };
    if let Some(gains) = gains {
        core.controller = Some(gains.controller);
        core.cutoff = gains.cutoff;
    }
    Settings {
        closed_loop: LoopSettings {
            core,
            law: Law::GaussNewton,
            format: Format::Single,
        },
        dither: Dither {
            amplitude: 0.0,
            ..example.dither
        },
        protection: Protection {
            following_error: travel,
            travel,
            speed: order.limits.speed,
            pace: 0.2 * order.limits.speed,
            ..example.protection
        },
    }
}

/// Says on standard error how it goes on, until it is over; an interruption stops it.
fn look_on(client: &mut Client, sample_time: f64, stop: &AtomicBool) -> Result<(), Fault> {
    let mut told = Phase::Idle;
    let mut stopped = false;
    let mut heard = Instant::now();
    loop {
        if stop.load(Ordering::Relaxed) && !stopped {
            stopped = true;
            client.ask(Command::Stop).map_err(fault)?;
            say_so("stopping");
        }
        let seen = client
            .next_within(Arguments::ATTENTION, seen)
            .map_err(fault)?;
        match seen {
            Some(Seen::Stands(State::Commissioning, stands)) => {
                if let Some(stands) = stands.filter(|stands| stands.phase != told) {
                    told = stands.phase;
                    say_so(told.name());
                }
            }
            Some(Seen::Stands(..)) => return Ok(()),
            Some(Seen::Progress(progress)) => say_so(&line(&progress, sample_time)),
            Some(Seen::Fault(fault)) => {
                say_so(&fault.to_string());
                return Ok(());
            }
            None if heard.elapsed() > Arguments::LONGEST_PAUSE => {
                return Err(fault(DriveError::Silent));
            }
            None => continue,
        }
        heard = Instant::now();
    }
}

fn seen(report: &Report) -> Option<Seen> {
    match report {
        Report::Status { status, .. } => Some(Seen::Stands(status.state, status.commissioning)),
        Report::Progress(progress) => Some(Seen::Progress(*progress)),
        Report::Fault(fault) => Some(Seen::Fault(*fault)),
        _ => None,
    }
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
    let acts = command.map_or("let go".to_owned(), |command| {
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

/// Says a line on standard error. Nothing depends on somebody hearing it.
fn say_so(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

fn show(
    scenario: &Scenario,
    before: Option<&HoldingGains>,
    outcome: &Outcome,
) -> Result<(), Fault> {
    if let Some(servo) = &outcome.servo {
        // The scenario's plant is no truth about this servo.
        let mut unknown = scenario.clone();
        unknown.plant = None;
        say!("{}", report::servo(&unknown, servo))?;
        if let Some(tuning) = &outcome.tuning {
            say!("{}", report::gains(before, tuning))?;
            let trial = outcome.trial.as_ref();
            say!("{}", report::promise(servo, tuning, trial))?;
        }
    }
    Ok(())
}

/// How the drive stands after a commissioning.
struct End {
    /// There are gains that held before.
    gains_before: bool,
    /// The loop beside which it ran goes on.
    goes_on: bool,
    /// For how long the line may then be silent, s; 0 for ever.
    link_timeout: f64,
}

impl End {
    /// What becomes of a loop that goes on.
    fn loop_goes_on(&self) -> String {
        if self.link_timeout > 0.0 {
            format!(
                "the loop goes on, and comes to rest when the line was silent for {} s",
                self.link_timeout
            )
        } else {
            "the loop goes on".to_owned()
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
        None if applied && end.goes_on => format!(
            "the new gains hold, and are kept as soon as the servo is let go; {}",
            end.loop_goes_on()
        ),
        None if applied => {
            return Err(Fault::Other(
                "applied, but the flash did not take them: the new gains hold until the power is lost; try \
                 `save`"
                    .to_owned(),
            ));
        }
        _ if end.goes_on => format!("the gains before hold; {}", end.loop_goes_on()),
        _ if end.gains_before => "the gains before hold".to_owned(),
        _ => "the servo is let go, without gains".to_owned(),
    };
    if applied {
        if !silent {
            say!("applied: {holds}")?;
        }
        return Ok(());
    }
    let why = match reason {
        Some(reason) => report::why(reason, outcome.no_gains.as_ref()),
        None => "it did not end by itself".to_owned(),
    };
    Err(Fault::Other(format!("{}: {why} ({holds})", phase.name())))
}
