//! The command line under the name that it is installed by.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::cli::main()
}
