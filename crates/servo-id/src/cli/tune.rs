use std::path::{Path, PathBuf};

use host_sim::scenario::{Purpose, Scenario};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::tuning::TuningError;
use identifier_log::tune::{Conditions, IdentifiedResult, KnownConditions, NoGains, Tuned};

use super::fault::Fault;
use super::files::Drawing;
use super::output::Documents;
use super::{call, kept_result};
use crate::present;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The result that `run` or `identify` wrote with --json.
    result: PathBuf,
    #[command(flatten)]
    conditions: Conditions,
    /// Goal: as stiff as the servo allows (the default).
    #[arg(long, group = "goal")]
    stiffest: bool,
    /// The scenario for encoder, limit and declared delay; that of the result by default.
    #[arg(long, value_name = "SCENARIO.toml")]
    scenario: Option<PathBuf>,
    /// Tune even for a result that has not converged; the predicted response is then uncertain.
    #[arg(long)]
    accept_unconverged: bool,
    #[command(flatten)]
    documents: Documents,
    #[command(flatten)]
    drawing: Drawing,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = arguments.scenario.as_deref();
    let loaded = scenario.map(|path| Scenario::load(path, Purpose::Replay));
    let loaded = loaded.transpose()?;
    let inputs: Vec<&Path> = [Some(arguments.result.as_path()), scenario]
        .into_iter()
        .flatten()
        .collect();
    let results = (arguments.documents).begin(&inputs, &arguments.drawing, None)?;

    let of_result = |fault: &dyn std::fmt::Display| Fault::of_file(&arguments.result, fault);
    let kept = kept_result::read(&arguments.result)?;
    let result = IdentifiedResult::new(&kept).map_err(|error| of_result(&error))?;
    let warning = result.reservation.as_ref();
    if let Some(reservation) = warning.filter(|_| !arguments.accept_unconverged) {
        return Err(of_result(&format!(
            "{reservation}: its gains would be a guess; correct that first, or state --accept-unconverged"
        )));
    }
    let conditions = arguments.conditions;
    check(&conditions)?;
    let known = match &loaded {
        Some(scenario) => KnownConditions::of_scenario(scenario, result.has_delay),
        None => KnownConditions::of_result(&kept, result.has_delay),
    };
    let settings = conditions
        .settings(conditions.goal(), &result, &known)
        .map_err(|error| of_result(&error))?;
    let tuned = Tuned::of_conditions(&result, &known, &conditions, &settings)
        .map_err(|error| Fault::Input(arguments.refusal(&error, settings.step)))?;

    let mut warnings: Vec<String> = result.reservation.iter().cloned().collect();
    if conditions.command_delay.is_none() && settings.command_delay == 0.0 && !result.has_delay {
        let assumed = "no delay was identified or declared, so it is assumed to be zero: state it with --command-delay";
        warnings.push(assumed.to_owned());
    }
    warnings.extend(conditions.assumptions(&known));
    warnings.extend(present::cost_of_errors(&tuned));
    let page = present::tuning(
        &call::title("Tuning for", &arguments.result),
        &call::command(),
        &tuned,
        &warnings,
    )
    .map_err(|error| Fault::Other(error.to_string()))?;
    let result = tuned.result();
    results.publish(&page, 1, false, &result, [])
}

/// The refusal of an option that is out of its range.
fn refusal_of(option: &str, error: &OutOfRange) -> String {
    let told = error.to_string().replacen(error.parameter, "", 1);
    format!("--{}{told}", option.replace('_', "-"))
}

/// Checks the stated conditions that the tuner does not check itself.
fn check(conditions: &Conditions) -> Result<(), Fault> {
    let Conditions { counts, limit, .. } = *conditions;
    let finite = limit.filter(|limit| *limit != f64::INFINITY);
    for (option, stated, allowed) in [
        ("counts", counts, Allowed::AtLeast(0.0)),
        ("limit", finite, Allowed::Above(0.0)),
    ] {
        if let Some(stated) = stated {
            let checked = allowed.check(option, stated);
            checked.map_err(|error| Fault::Input(refusal_of(option, &error)))?;
        }
    }
    Ok(())
}

impl Arguments {
    /// Why there are no gains, with a possible goal.
    fn refusal(&self, error: &NoGains, step: f64) -> String {
        let result = self.result.display();
        let Conditions {
            response_time,
            bandwidth,
            ..
        } = self.conditions;
        match *error {
            NoGains::TooFast {
                cap,
                most,
                rise_time,
            } => {
                let (asked, instead) = match (response_time, bandwidth, rise_time) {
                    (Some(time), _, Some(least)) => (
                        format!("--response-time {time}"),
                        // Response times are met to a hundredth.
                        format!(
                            ", with a rise time of {least:.4} s: ask for {:.4} s",
                            1.02 * least
                        ),
                    ),
                    (Some(time), ..) => (format!("--response-time {time}"), String::new()),
                    (_, bandwidth, _) => (
                        format!("--bandwidth {}", bandwidth.unwrap_or_default()),
                        ": ask for less".to_owned(),
                    ),
                };
                format!("{asked}: {cap} allows {most:.2} rad/s{instead}, or --stiffest")
            }
            NoGains::Error(TuningError::OutOfRange(error)) => {
                let is_limit = error.parameter == "command";
                let option = if is_limit { "limit" } else { error.parameter };
                refusal_of(option, &error)
            }
            NoGains::Error(error @ TuningError::DoesNotArrive) => {
                format!("--step {step}: {error}")
            }
            NoGains::Error(error) => format!("{result}: {error}"),
            NoGains::Form(ref error) => format!("--for: {error}"),
        }
    }
}
