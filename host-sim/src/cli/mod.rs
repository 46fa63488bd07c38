//! The command line: one verb, one file.

/// `println!` to a reader that may have gone, as the head of a pipe does: it then wants no more, and
/// that is no fault.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

mod compare;
mod drift;
mod drive;
mod fault;
mod output;
mod paper;
mod pil;
mod recording;
mod replay;
mod run;
mod sweep;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Simulates the on-line identification of a servo under PID control.
///
/// Exit status: 0 done; 2 bad input; 1 anything else.
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
    /// Run every method on the same servo, in cases that each break one assumption.
    Compare(compare::Arguments),
    /// Run one experiment in every number format, side by side on the same measurements.
    Drift(drift::Arguments),
    /// Run one experiment on the simulated servo with the loop on a chip.
    Pil(pil::Arguments),
    /// Talk to a drive over its serial line.
    Drive(drive::Arguments),
    /// Run many random servos: the distribution of the errors.
    Sweep(sweep::Arguments),
}

/// Parses the command line, does what it says and answers with the exit status.
#[must_use]
pub fn main() -> ExitCode {
    let verb = Arguments::parse()
        .verb
        .unwrap_or_else(|| Verb::Paper(paper::Arguments::default()));
    let done = match verb {
        Verb::Paper(arguments) => paper::run(&arguments),
        Verb::Run(arguments) => run::run(&arguments),
        Verb::Replay(arguments) => replay::run(&arguments),
        Verb::Compare(arguments) => compare::run(&arguments),
        Verb::Drift(arguments) => drift::run(&arguments),
        Verb::Pil(arguments) => pil::run(&arguments),
        Verb::Drive(arguments) => drive::run(&arguments),
        Verb::Sweep(arguments) => sweep::run(&arguments),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            eprintln!("error: {fault}");
            fault.exit_code()
        }
    }
}
