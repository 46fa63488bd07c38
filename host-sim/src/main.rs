//! The simulator's command line.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::cli::main()
}
