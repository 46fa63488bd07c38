//! `servo-id drive commission`: the drive identifies its servo, tunes itself and validates the gains.

use std::path::PathBuf;

use commissioning::{HoldingGains, Phase};
use drive_link::{Commissioning, Outcome, Progress, Report, State, Status};
use host_sim::result::CommissioningEnd;
use identifier_log::provenance::ScenarioText;
use identifier_log::verdict::Cause;

use super::follow::{follow, samples_in};
use super::plan::Plan;
use crate::cli::commission::Choices;
use crate::cli::fault::Fault;
use crate::cli::files::{self, Files};
use crate::cli::standard_output::show;
use crate::cli::terminal::{notify, width};
use crate::drive::{DriveCommissioningResult, Driven, commissioning_outcome};
use crate::present;
use crate::render::terminal;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario: encoder, amplifier and [commission]. A configured drive keeps its own controller; any other gets
    /// the scenario's, if it has one.
    scenario: PathBuf,
    #[command(flatten)]
    choices: Choices,
    /// Write the result as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace what this program did not write, too.
    #[arg(long)]
    force: bool,
}

/// Time between two lines of progress, s.
const LINE_INTERVAL: f64 = 0.1;

impl Arguments {
    pub(super) fn run(&self, drive: &mut Driven, status: &Status) -> Result<(), Fault> {
        let text = ScenarioText::read(&self.scenario)?;
        let plan = Plan::from_text(&self.choices.stated_in(text))?;
        let mut files = Files::reading(&[&self.scenario], self.force);
        let json = files.output(self.json.as_deref())?;
        let silent = files.own_standard_output();

        let settings = drive.settings()?;
        let planned = plan.for_drive(&settings, status)?;
        if let Some(settings) = planned.configure {
            drive.configure(settings)?;
        }
        let (order, largest) = (&planned.order, &planned.largest_motion);
        let before = planned.gains_before.as_ref();
        if !silent {
            show!("{}", present::largest_motion(largest))?;
            show!("{}", present::unseen_motion(largest))?;
        }

        let every = samples_in(LINE_INTERVAL, order.sample_time);
        drive.watch(every)?;
        drive.commission(order)?;
        match show_progress(drive, order.sample_time) {
            Err(Fault::Interrupted(_)) => {
                notify("stopping");
                drive.stop()?;
            }
            shown => shown?,
        }
        let outcome = drive.outcome()?;
        drive.watch(0)?;
        let state = drive.status()?.state;
        let effects = match outcome.commissioning.reason {
            None => Vec::new(),
            reason => {
                let recorded = drive.recorded()?;
                recorded.effects(&plan.scenario, reason)
            }
        };

        // From here on its state is a result, which is told.
        drive.leave();
        let (time, limits) = (order.sample_time, &order.limits);
        let result = DriveCommissioningResult {
            end: CommissioningEnd::new(
                time,
                limits,
                largest,
                before,
                &commissioning_outcome(&outcome),
                &effects,
            ),
            kept: outcome.kept,
        };
        files::commit([json.map(|json| json.document(&result))])?;
        if !silent {
            show(before, &outcome)?;
        }
        let end = End {
            gains_before: before.is_some(),
            state,
            link_timeout: planned.link_timeout,
        };
        judged(&end, &outcome, &effects, silent)
    }
}

/// Prints the progress on standard error until the commissioning is over.
fn show_progress(drive: &mut Driven, sample_time: f64) -> Result<(), Fault> {
    let mut shown = Phase::Idle;
    follow(drive, |_, event| {
        match event {
            Some(Report::Status { status, .. }) if status.state != State::Commissioning => {
                return Ok(Some(()));
            }
            Some(Report::Status { status, .. }) => {
                if let Some(now) = status.commissioning.filter(|now| now.phase != shown) {
                    shown = now.phase;
                    notify(shown.name());
                }
            }
            Some(Report::Progress(progress)) => notify(&line(&progress, sample_time)),
            Some(Report::Fault(fault)) => {
                notify(&fault.to_string());
                return Ok(Some(()));
            }
            _ => {}
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
    let acts = command.map_or("disabled".to_owned(), |command| {
        format!("command {command:+.3}")
    });
    let known = match gain {
        Some([b, error]) => format!(", b {b:.2} ± {:.2}", crate::SIDES * f64::from(*error)),
        None if *recorded > 0 => format!(", {recorded} blocks recorded"),
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

/// The drive after a commissioning.
struct End {
    /// There were gains before.
    gains_before: bool,
    /// Its activity.
    state: State,
    /// Longest silence of the line then, s; 0 for no limit.
    link_timeout: f64,
}

impl End {
    /// The gains that hold the servo now.
    fn stands(&self) -> String {
        if self.state != State::Running {
            return "the servo is disabled".to_owned();
        }
        let silence = self.link_timeout;
        if silence > 0.0 {
            format!("the loop keeps running, and stops when the line is silent for {silence} s")
        } else {
            "the loop keeps running".to_owned()
        }
    }

    /// The gains in force where there are no new ones.
    fn falls_back_to(&self) -> &'static str {
        match self.gains_before {
            true => "the previous gains are in force",
            false => "there are no gains",
        }
    }
}

fn judged(end: &End, outcome: &Outcome, effects: &[Cause], silent: bool) -> Result<(), Fault> {
    let Commissioning { phase, reason } = outcome.commissioning;
    let stands = end.stands();
    if reason.is_none() && phase == Phase::Applied {
        let kept = match (outcome.kept, end.state) {
            (true, _) => "stored in flash",
            (false, State::Running) => "stored in flash as soon as the servo is disabled",
            (false, _) => {
                return Err(Fault::Other(
                    "applied, but the flash did not store them: the new gains are in force until the power is lost; \
                     try `save`"
                        .to_owned(),
                ));
            }
        };
        if !silent {
            show!("applied: the new gains are in force, and {kept}; {stands}")?;
        }
        return Ok(());
    }
    let why = match reason {
        Some(reason) => present::why(
            reason,
            outcome.no_gains.as_ref().map(|error| error as _),
            outcome.noise,
            effects,
        ),
        None => "it did not end".to_owned(),
    };
    Err(Fault::Other(format!(
        "{}: {why} ({}; {stands})",
        phase.name(),
        end.falls_back_to()
    )))
}

#[cfg(test)]
mod tests {
    use identifier_core::reason::Reason;

    use super::*;

    /// Whether it counts as done, with what is said if it does not.
    fn end(phase: Phase, reason: Option<Reason>, kept: bool, state: State) -> Result<(), String> {
        let outcome = Outcome {
            commissioning: Commissioning { phase, reason },
            servo: None,
            tuning: None,
            no_gains: None,
            trial: None,
            noise: 0.0,
            kept,
        };
        let end = End {
            gains_before: true,
            state,
            link_timeout: 0.0,
        };
        judged(&end, &outcome, &[], true).map_err(|fault| fault.to_string())
    }

    #[test]
    fn gains_count_as_applied_only_where_the_drive_keeps_them() {
        assert_eq!(end(Phase::Applied, None, true, State::Disabled), Ok(()));
        assert_eq!(end(Phase::Applied, None, false, State::Running), Ok(()));
        let lost = end(Phase::Applied, None, false, State::Disabled);
        assert!(lost.is_err_and(|why| why.contains("until the power is lost")));
        // The drive tried them and could not use them.
        let unusable = Some(Reason::NoGains);
        assert!(end(Phase::RolledBack, unusable, false, State::Disabled).is_err());
        assert!(end(Phase::Applied, unusable, true, State::Disabled).is_err());
        assert!(end(Phase::Idle, None, false, State::Disabled).is_err());
    }

    #[test]
    fn what_holds_the_servo_is_told_by_the_state_of_the_drive() {
        let held = "the previous gains are in force; the loop keeps running)";
        let disabled = "the previous gains are in force; the servo is disabled)";
        for (state, told) in [
            (State::Running, held),
            (State::Disabled, disabled),
            (State::Faulted(Reason::EncoderLost), disabled),
        ] {
            let aborted = end(Phase::Aborted, Some(Reason::EncoderStuck), false, state);
            assert!(aborted.is_err_and(|why| why.ends_with(told)), "{state}");
        }
    }
}
