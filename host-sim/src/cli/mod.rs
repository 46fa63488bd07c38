//! The command line: one verb, one file, and beside them what all verbs write with.

mod call;
mod commission;
mod compare;
mod drift;
mod drive;
mod fault;
mod files;
mod interruption;
mod keys;
mod live;
mod live_commission;
mod live_experiment;
mod output;
mod output_file;
mod paper;
mod pil;
mod place;
mod recording;
mod replay;
mod run;
mod standard_output;
mod sweep;
mod tune;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use fault::Fault;

/// Simulates the on-line identification of a servo under PID control.
///
/// Exit status: 0 done; 2 bad input; 130 interrupted; 1 anything else.
#[derive(Debug, Parser)]
#[command(name = "host-sim", version)]
struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Run the paper's experiment: both methods, balanced and unbalanced (the default).
    Paper(paper::Arguments),
    /// Run one experiment on the simulated servo.
    Run(run::Arguments),
    /// Identify from a recorded log with a declared controller.
    Replay(replay::Arguments),
    /// Commission the simulated drive: wiggle, identify, verify, tune, try, then apply or roll back.
    Commission(commission::Arguments),
    /// Run every method on the same servo, in cases that each break one assumption.
    Compare(compare::Arguments),
    /// Run one experiment in every number format, side by side on the same measurements.
    Drift(drift::Arguments),
    /// Run one experiment on the simulated servo with the loop on a chip.
    Pil(pil::Arguments),
    /// Talk to a drive over its serial line.
    Drive(drive::Arguments),
    /// Find gains for an identified servo, with margins and the response that they promise.
    Tune(tune::Arguments),
    /// Run many random servos: the distribution of the errors.
    Sweep(sweep::Arguments),
    /// List the keys of a scenario: what each is, what it may hold, what holds without it.
    Keys(keys::Arguments),
}

/// Parses the command line, does what it says and answers with the exit status.
#[must_use]
pub fn main() -> ExitCode {
    let done = match Arguments::try_parse() {
        Ok(arguments) => arguments.run(),
        // Help and version.
        Err(asked) if !asked.use_stderr() => standard_output::written(asked.print()),
        Err(wrong) => wrong.exit(),
    };
    match done.and_then(|()| standard_output::flush()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            // Where nobody can be told, the exit status still says it.
            let _ = writeln!(io::stderr(), "error: {fault}");
            fault.exit_code()
        }
    }
}

impl Arguments {
    fn run(self) -> Result<(), Fault> {
        interruption::handle();
        match self
            .verb
            .unwrap_or_else(|| Verb::Paper(paper::Arguments::default()))
        {
            Verb::Paper(arguments) => paper::run(&arguments),
            Verb::Run(arguments) => run::run(&arguments),
            Verb::Replay(arguments) => replay::run(&arguments),
            Verb::Commission(arguments) => commission::run(&arguments),
            Verb::Compare(arguments) => compare::run(&arguments),
            Verb::Drift(arguments) => drift::run(&arguments),
            Verb::Pil(arguments) => pil::run(&arguments),
            Verb::Drive(arguments) => drive::run(&arguments),
            Verb::Tune(arguments) => tune::run(&arguments),
            Verb::Sweep(arguments) => sweep::run(&arguments),
            Verb::Keys(arguments) => keys::run(&arguments),
        }
    }
}
