//! The command line: one file for each verb, and the inputs and outputs that all verbs share.

mod call;
mod commission;
mod compare;
mod completions;
#[cfg(feature = "operation")]
mod drive;
mod export;
mod fault;
mod files;
mod firmware;
mod formats;
mod identify;
mod interruption;
mod kept_result;
mod keys;
mod output;
mod output_file;
mod paper;
mod place;
mod progress;
mod recording;
mod replay;
mod required;
mod run;
mod standard_output;
mod streamed;
mod sweep;
mod terminal;
mod tune;

use std::process::ExitCode;

use clap::{ArgAction, Parser, Subcommand};
use fault::Fault;

use crate::program;
use crate::render::terminal::style::FAULT;

/// Identifies a servo from a recorded log and computes its gains; simulates servos, and operates drives.
#[derive(Debug, Parser)]
#[command(
    name = program::NAME,
    version = program::VERSION,
    max_term_width = 100,
    disable_help_flag = true,
    after_help = "Exit status: 0 done; 2 bad input; 3 not converged, if --require was stated; 130 interrupted; 1 \
                  anything else."
)]
struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
    /// Print only errors and the output requested on `-`.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Print help.
    #[arg(long, short, global = true, action = ArgAction::HelpShort)]
    help: Option<bool>,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Identify the servo of a recorded log: columns, units and sample time are found, or a scenario states them.
    Identify(Box<identify::Arguments>),
    /// Compute gains for an identified servo, with margins and the predicted response.
    Tune(tune::Arguments),
    /// Write an identified servo as a joint of a robot's model, in physical units.
    Export(export::Arguments),
    /// Operate a drive over its serial line.
    #[cfg(feature = "operation")]
    Drive(drive::Arguments),
    /// Run one experiment on the simulated servo.
    Run(run::Arguments),
    /// Commission the simulated drive: probe, identify, verify, tune, test, then apply or roll back.
    Commission(commission::Arguments),
    /// Run every method on the same servo, in cases that each violate one assumption.
    Compare(compare::Arguments),
    /// Identify many random servos: the distribution of the errors.
    Sweep(sweep::Arguments),
    /// Run the paper's experiment: both methods, balanced and unbalanced (without a verb, only its table is printed).
    Paper(paper::Arguments),
    /// List the keys of a scenario: meaning, allowed values and defaults.
    Keys(keys::Arguments),
    /// Print a shell's completion script for verbs, options and files.
    Completions(completions::Arguments),
}

/// Parses the command line, runs the verb and returns the exit status.
#[must_use]
pub fn main() -> ExitCode {
    let done = match Arguments::try_parse() {
        Ok(arguments) => arguments.run(),
        // Help and version.
        Err(page) if !page.use_stderr() => standard_output::written(page.print()),
        Err(wrong) => {
            terminal::notify(wrong.render().ansi().to_string().trim_end());
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
            Verb::Identify(arguments) => identify::run(&arguments),
            Verb::Commission(arguments) => commission::run(&arguments),
            Verb::Compare(arguments) => compare::run(&arguments),
            #[cfg(feature = "operation")]
            Verb::Drive(arguments) => drive::run(&arguments),
            Verb::Tune(arguments) => tune::run(&arguments),
            Verb::Export(arguments) => export::run(&arguments),
            Verb::Sweep(arguments) => sweep::run(&arguments),
            Verb::Keys(arguments) => keys::run(&arguments),
            Verb::Completions(arguments) => completions::run(&arguments),
        }
    }
}
