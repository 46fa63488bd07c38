//! The program `servo-id`.

use std::process::ExitCode;

fn main() -> ExitCode {
    servo_id::cli::main()
}
