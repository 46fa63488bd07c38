use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::tuning::{Goal, TuningError};

use super::call;
use super::fault::Fault;
use super::output::Documents;
use crate::nearest;
use crate::present;
use crate::report::promise;
use crate::result::TuningResult;
use crate::scenario::{Purpose, Scenario};
use crate::tune::{Conditions, IdentifiedResult, NoGains, Tuned};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The result that `run` or `replay` wrote with --json.
    result: PathBuf,
    /// Goal: time from 10 to 90 % of a step, s.
    #[arg(long, value_name = "S", group = "goal", allow_negative_numbers = true)]
    response_time: Option<f64>,
    /// Goal: ω of the loop's double pole, rad/s.
    #[arg(long, value_name = "W", group = "goal", allow_negative_numbers = true)]
    bandwidth: Option<f64>,
    /// Goal: as stiff as the servo allows (the default).
    #[arg(long, group = "goal")]
    stiffest: bool,
    /// The scenario of the result: encoder, limit and declared delay are taken from it.
    #[arg(long, value_name = "SCENARIO.toml")]
    scenario: Option<PathBuf>,
    /// Sample time of the loop, s; the result's by default.
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    sample_time: Option<f64>,
    /// Counts of the encoder per revolution; 0 for an ideal sensor.
    #[arg(
        long,
        value_name = "N",
        group = "encoder",
        allow_negative_numbers = true
    )]
    counts: Option<f64>,
    /// Position of a count, rad (m on a linear axis); 0 for an ideal sensor.
    #[arg(
        long,
        value_name = "R",
        group = "encoder",
        allow_negative_numbers = true
    )]
    resolution: Option<f64>,
    /// The largest command, command units; inf for none.
    #[arg(long, value_name = "U", allow_negative_numbers = true)]
    limit: Option<f64>,
    /// Delay from encoder reading to output that was not identified, s; the scenario's, or none, by default.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    command_delay: Option<f64>,
    /// Cut-off of the velocity estimate, rad/s; chosen with the gains by default.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    cutoff: Option<f64>,
    /// Largest sensitivity Ms; 1.6 by default.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    max_sensitivity: Option<f64>,
    /// Largest share of the encoder's rounding in the command, as a fraction of the limit; 0.03 by default.
    #[arg(long, value_name = "PART", allow_negative_numbers = true)]
    max_noise: Option<f64>,
    /// Lowest known resonance, rad/s.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    resonance: Option<f64>,
    /// Step of the predicted response, rad; 0.1 by default, at least 10 counts.
    #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
    step: Option<f64>,
    /// Tune even for a result that has not converged; the predicted response is then uncertain.
    #[arg(long)]
    accept_unconverged: bool,
    #[command(flatten)]
    documents: Documents,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = arguments.scenario.as_deref();
    let loaded = scenario.map(|path| Scenario::load(path, Purpose::Replay));
    let loaded = loaded.transpose()?;
    let inputs: Vec<&Path> = [Some(arguments.result.as_path()), scenario]
        .into_iter()
        .flatten()
        .collect();
    let results = arguments.documents.begin(&inputs, None)?;

    let of_result = |fault: &dyn std::fmt::Display| {
        Fault::Input(format!("{}: {fault}", arguments.result.display()))
    };
    let text = fs::read_to_string(&arguments.result)
        .map_err(|error| nearest::unreadable(&arguments.result, &error))
        .map_err(|why| of_result(&format!("the result cannot be read: {why}")))?;
    let result = IdentifiedResult::read(&text).map_err(|error| of_result(&error))?;
    let warning = result.doubt.as_ref();
    if let Some(doubt) = warning.filter(|_| !arguments.accept_unconverged) {
        return Err(of_result(&format!(
            "{doubt}: gains for it would be a guess; see to that first, or --accept-unconverged"
        )));
    }
    let settings = arguments
        .conditions()?
        .settings(&result, loaded.as_ref())
        .map_err(|error| of_result(&error))?;
    let tuned = Tuned::of(&result, &settings)
        .map_err(|error| Fault::Input(arguments.refusal(&error, settings.step)))?;

    let figures = || promise::figures(&tuned).map_err(|error| Fault::Other(error.to_string()));
    let mut warnings: Vec<String> = result.doubt.iter().cloned().collect();
    if arguments.command_delay.is_none() && settings.command_delay == 0.0 && !result.has_delay {
        let assumed = "no delay was identified or declared, so it is assumed to be zero: --command-delay states it";
        warnings.push(assumed.to_owned());
    }
    let page = present::tuning(
        &call::title("Tuning for", &arguments.result),
        &call::command(),
        &tuned,
        figures()?,
        &warnings,
    );
    let result = TuningResult::new(&tuned);
    results.publish(&page, false, &result, [], |picture| {
        picture.figures("", 1, &figures()?)
    })
}

/// An option that was checked, or what is said of it.
fn stated(option: &str, checked: Result<f64, OutOfRange>) -> Result<f64, Fault> {
    checked.map_err(|error| Fault::Input(refusal_of(option, &error)))
}

/// What is said of an option that is out of its range.
fn refusal_of(option: &str, error: &OutOfRange) -> String {
    let told = error.to_string().replacen(error.parameter, "", 1);
    format!("--{}{told}", option.replace('_', "-"))
}

impl Arguments {
    fn conditions(&self) -> Result<Conditions, Fault> {
        // `stiffest` is what holds without the other two.
        let goal = match (self.response_time, self.bandwidth, self.stiffest) {
            (Some(time), ..) => Goal::ResponseTime(time),
            (None, Some(bandwidth), _) => Goal::Bandwidth(bandwidth),
            (None, None, _) => Goal::Stiffest,
        };
        if let Some(counts) = self.counts {
            stated("counts", Allowed::AtLeast(0.0).check("counts", counts))?;
        }
        if let Some(limit) = self.limit.filter(|limit| *limit != f64::INFINITY) {
            stated("limit", Allowed::Above(0.0).check("limit", limit))?;
        }
        let of_counts = |counts: f64| if counts == 0.0 { 0.0 } else { TAU / counts };
        Ok(Conditions {
            goal,
            sample_time: self.sample_time,
            resolution: self.resolution.or_else(|| self.counts.map(of_counts)),
            limit: self.limit,
            command_delay: self.command_delay,
            cutoff: self.cutoff,
            most_sensitivity: self.max_sensitivity,
            most_noise: self.max_noise,
            resonance: self.resonance,
            step: self.step,
        })
    }

    /// Why there are no gains, with what would do.
    fn refusal(&self, error: &NoGains, step: f64) -> String {
        let result = self.result.display();
        match *error {
            NoGains::TooFast {
                cap,
                most,
                rise_time,
            } => {
                let (asked, instead) = match (self.response_time, self.bandwidth, rise_time) {
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
                let option = match error.parameter {
                    "max_sensitivity" => "max_sensitivity",
                    "max_noise" => "max_noise",
                    "command" => "limit",
                    other => other,
                };
                refusal_of(option, &error)
            }
            NoGains::Error(TuningError::DoesNotArrive) => {
                format!("--step {step}: {}", TuningError::DoesNotArrive)
            }
            NoGains::Error(error) => format!("{result}: {error}"),
        }
    }
}
