use std::io::{self, BufRead, IsTerminal, Write};
use std::path::PathBuf;

use clap::Args;
use host_sim::scenario::{Document, Options, Purpose, Scenario};
use identifier_log::log::Table;
use identifier_log::provenance::ScenarioText;
use identifier_log::recognise::{LogOptions, Question, Recognised, Unrecognised, recognise};

use super::fault::Fault;
use super::output::Outputs;
use super::replay::{Introduction, Replay, tables};
use super::required::Required;
use super::terminal::folded_error;
use crate::present::introduction;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The log, .csv or .csv.gz, or `-` for standard input, with the measured position and the command that acted. Several logs of one servo with
    /// the same columns are identified together, each under any controller. An online estimator starts each from the
    /// estimates of the previous one.
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// A further log of the servo that is only predicted and not used for the fit. May be repeated.
    #[arg(long, value_name = "LOG", help_heading = None)]
    predict: Vec<PathBuf>,
    /// The scenario of the run that wrote the log; for any other log one with [log]: identifier, the log's columns, and
    /// the controller that ran where the log has no command. Without it columns and units are recognised from the log,
    /// and options state the rest.
    #[arg(long, value_name = "SCENARIO.toml", help_heading = None, conflicts_with_all = ["LogOptions", "save_scenario"])]
    scenario: Option<PathBuf>,
    /// Passes over the logs, each from the estimates of the previous one.
    #[arg(
        long,
        value_name = "N",
        help_heading = None,
        default_value_t = 1,
        requires = "scenario",
        value_parser = clap::value_parser!(u32).range(1..=10_000)
    )]
    passes: u32,
    #[command(flatten, next_help_heading = "Information that the log lacks")]
    stated: LogOptions,
    /// Write the scenario that gives the same result with --scenario; `-` is standard output.
    #[arg(long, value_name = "SCENARIO.toml", help_heading = None)]
    save_scenario: Option<PathBuf>,
    #[command(flatten)]
    required: Required,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let outputs = &arguments.outputs;
    let (logs, predict) = (tables(&arguments.logs)?, tables(&arguments.predict)?);
    if let Some(scenario) = &arguments.scenario {
        let text = ScenarioText::read(scenario)?;
        let status = Replay {
            scenario: Scenario::of_text(&text, Purpose::Replay)?,
            text: &text,
            logs,
            predict,
            passes: arguments.passes,
            introduction: None,
        }
        .experiment(outputs, scenario)?;
        return arguments.required.check(status);
    }
    let all = Table::joined(&logs).map_err(|error| Fault::Input(error.to_string()))?;
    let log = &all.path.clone();
    let recognised = recognised(&all, arguments.stated.clone())?;
    let options = (recognised.options()).and_then(Options::in_range);
    let options = options.map_err(|error| in_options(Fault::of_file(log, error)))?;
    let text = ScenarioText {
        file: match &arguments.save_scenario {
            Some(file) => file.display().to_string(),
            None => format!("the scenario of {}", log.display()),
        },
        text: recognised.scenario(&log.display().to_string()),
    };
    let introduction = Introduction {
        text: introduction(log, &recognised.findings),
        save_scenario: arguments.save_scenario.as_deref(),
    };
    drop(all);
    let status = Replay {
        scenario: Scenario::from(options),
        text: &text,
        logs,
        predict,
        passes: 1,
        introduction: Some(&introduction),
    }
    .experiment(outputs, log)
    .map_err(in_options)?;
    arguments.required.check(status)
}

/// The log, recognised with the answers to all questions.
fn recognised(log: &Table, mut stated: LogOptions) -> Result<Recognised, Fault> {
    let is_asked = io::stdin().is_terminal() && io::stderr().is_terminal();
    loop {
        let questions = match recognise(log, &stated) {
            Ok(recognised) => return Ok(recognised),
            Err(Unrecognised::Log(error)) => {
                return Err(in_options(Fault::Input(error.to_string())));
            }
            Err(Unrecognised::Unknown(questions)) => questions,
        };
        if !is_asked {
            let refusals = questions.iter().map(|open| open.refusal(&stated, log));
            let refusals = refusals.collect::<Vec<_>>().join("\n");
            return Err(in_options(Fault::Input(refusals)));
        }
        for Question { flag, text } in &questions {
            while let Err(allowed) = stated.answer(flag, ask(&format!("{text}: "))?.trim()) {
                prompt(&format!("{allowed}\n"))?;
            }
        }
    }
}

fn ask(question: &str) -> Result<String, Fault> {
    prompt(question)?;
    let mut answer = String::new();
    let read = io::stdin().lock().read_line(&mut answer);
    match read {
        Ok(0) | Err(_) => Err(Fault::Input("no answer: nothing is written".to_owned())),
        Ok(_) => Ok(answer),
    }
}

fn prompt(text: &str) -> Result<(), Fault> {
    let mut terminal = io::stderr();
    terminal
        .write_all(folded_error(text).as_bytes())
        .and_then(|()| terminal.flush())
        .map_err(|error| Fault::unwritable("the terminal", &error))
}

/// A refusal with the options of this verb for the keys of a scenario.
fn in_options(fault: Fault) -> Fault {
    let Fault::Input(mut text) = fault else {
        return fault;
    };
    text = (text.replace("no log.time", "--time none"))
        .replace("as log.reference with inner.kp", "as --goal with --kp");
    let options = LogOptions::augment_args(clap::Command::default());
    let is_option = |name: &str| {
        options
            .get_arguments()
            .any(|option| option.get_id() == name)
    };
    let keys = Options::keys().iter().filter_map(|key| {
        let name = match (key.path, key.place()) {
            ("inner.sample_time", _) => "loop_time",
            (_, ("encoder" | "inner" | "log" | "physical", name)) => name,
            _ => return None,
        };
        is_option(name).then(|| (key.path, format!("--{}", name.replace('_', "-"))))
    });
    let mut keys: Vec<_> = keys.collect();
    // The longest of those that begin alike is the key.
    keys.sort_by_key(|(path, _)| std::cmp::Reverse(path.len()));
    for (path, option) in keys {
        text = text
            .replace(&format!("{path} = "), &format!("{option} "))
            .replace(path, &option);
    }
    Fault::Input(text)
}

#[cfg(test)]
mod tests {
    use super::{Fault, in_options};

    #[test]
    fn a_key_is_the_option_of_its_name() {
        let text = "state log.position_unit = \"deg\" and encoder.counts_per_rev, or log.position; log.time_unit, too";
        let Fault::Input(text) = in_options(Fault::Input(text.to_owned())) else {
            panic!("bad input");
        };
        assert_eq!(
            text,
            "state --position-unit \"deg\" and --counts-per-rev, or --position; --time-unit, too"
        );
    }
}
