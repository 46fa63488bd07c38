//! The command line: one file for each verb, and the inputs and outputs that all verbs share.

mod call;
mod commission;
mod compare;
mod completions;
mod drive;
mod export;
mod fault;
mod files;
mod firmware;
mod formats;
mod identify;
mod init;
mod interruption;
mod kept_result;
mod keys;
mod options;
mod output;
mod output_file;
mod paper;
mod place;
mod progress;
mod recording;
mod replay;
mod reproduce;
mod required;
mod run;
mod same_result;
mod standard_output;
mod streamed;
mod sweep;
mod terminal;
mod tune;

use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory, FromArgMatches, Parser, Subcommand};
use fault::Fault;
use host_sim::gone::{self, Place};
use host_sim::scenario::keys::listing;

use crate::program;
use crate::render::terminal::style::FAULT;

/// Simulates the on-line identification of a servo under PID control.
///
/// Exit status: 0 done; 2 bad input; 3 not converged, if --require was stated; 130 interrupted; 1 anything else.
#[derive(Debug, Parser)]
#[command(name = program::NAME, version = program::VERSION, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
    /// Print only errors and the output requested on `-`.
    #[arg(long, short, global = true)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Run the paper's experiment: both methods, balanced and unbalanced (without a verb, only its table is printed).
    Paper(paper::Arguments),
    /// Run one experiment on the simulated servo.
    Run(run::Arguments),
    /// Write a scenario from the data sheet of a motor.
    Init(init::Arguments),
    /// Identify the servo of a recorded log: columns, units and sample time are found, or a scenario states them.
    Identify(Box<identify::Arguments>),
    /// Reproduce a result from its provenance and compare the two, to the last bit.
    Reproduce(reproduce::Arguments),
    /// Commission the simulated drive: probe, identify, verify, tune, test, then apply or roll back.
    Commission(commission::Arguments),
    /// Run every method on the same servo, in cases that each violate one assumption.
    Compare(compare::Arguments),
    /// Operate a drive over its serial line.
    Drive(drive::Arguments),
    /// Compute gains for an identified servo, with margins and the predicted response.
    Tune(tune::Arguments),
    /// Write an identified servo as a joint of a robot's model, in physical units.
    Export(export::Arguments),
    /// Identify many random servos: the distribution of the errors.
    Sweep(sweep::Arguments),
    /// List the keys of a scenario: meaning, allowed values and defaults.
    Keys(keys::Arguments),
    /// Print a shell's completion script for verbs, options and files.
    Completions(completions::Arguments),
}

/// The verbs that read a scenario, whose keys their `--help` lists.
const SCENARIO_VERBS: [&str; 5] = ["run", "identify", "commission", "compare", "sweep"];

/// The command line with the keys of a scenario in its long help. To list them takes as long as to parse
/// a call, so this is built only where help is printed.
fn documented() -> Command {
    let keys = format!("Keys of a scenario:\n{}", listing());
    let with_keys = |command: Command| command.after_long_help(keys.clone());
    SCENARIO_VERBS
        .into_iter()
        .fold(Arguments::command(), |command, verb| {
            command.mut_subcommand(verb, with_keys)
        })
        .mut_subcommand("drive", |drive| {
            drive.mut_subcommand("commission", with_keys)
        })
}

/// Parses the command line, runs the verb and returns the exit status.
#[must_use]
pub fn main() -> ExitCode {
    let parsed = Arguments::command().try_get_matches();
    let parsed = parsed.or_else(|error| match error.kind() {
        ErrorKind::DisplayHelp => documented().try_get_matches(),
        _ => Err(error),
    });
    let done = match parsed.and_then(|found| Arguments::from_arg_matches(&found)) {
        Ok(arguments) => arguments.run(),
        // Help and version.
        Err(page) if !page.use_stderr() => standard_output::written(page.print()),
        Err(wrong) => {
            let text = match instead(&wrong) {
                Some(instead) => format!("{FAULT}error:{FAULT:#} {instead}"),
                None => wrong.render().ansi().to_string(),
            };
            terminal::notify(text.trim_end());
            return ExitCode::from(2);
        }
    };
    match done.and_then(|()| standard_output::flush()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            // The exit status reports the fault even where standard error is closed.
            terminal::notify(&format!("{FAULT}error:{FAULT:#} {fault}"));
            fault.exit_code()
        }
    }
}

/// The replacement of a verb or an option that is gone.
fn instead(wrong: &clap::Error) -> Option<String> {
    let (place, context) = match wrong.kind() {
        ErrorKind::InvalidSubcommand => (Place::Verb, ContextKind::InvalidSubcommand),
        ErrorKind::UnknownArgument => (Place::Option, ContextKind::InvalidArg),
        _ => return None,
    };
    let ContextValue::String(word) = wrong.get(context)? else {
        return None;
    };
    let word = word.split('=').next()?;
    let instead = gone::replacement(place, word)?;
    Some(format!("{word} is gone: {instead}"))
}

impl Arguments {
    fn run(self) -> Result<(), Fault> {
        interruption::handle();
        if self.quiet {
            standard_output::be_quiet();
        }
        let Some(verb) = self.verb else {
            return paper::show();
        };
        match verb {
            Verb::Paper(arguments) => paper::run(&arguments),
            Verb::Run(arguments) => run::run(&arguments),
            Verb::Init(arguments) => init::run(&arguments),
            Verb::Identify(arguments) => identify::run(&arguments),
            Verb::Reproduce(arguments) => reproduce::run(&arguments),
            Verb::Commission(arguments) => commission::run(&arguments),
            Verb::Compare(arguments) => compare::run(&arguments),
            Verb::Drive(arguments) => drive::run(&arguments),
            Verb::Tune(arguments) => tune::run(&arguments),
            Verb::Export(arguments) => export::run(&arguments),
            Verb::Sweep(arguments) => sweep::run(&arguments),
            Verb::Keys(arguments) => keys::run(&arguments),
            Verb::Completions(arguments) => completions::run(&arguments),
        }
    }
}
