//! Programs that build and try the project's parts, and where.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The root of the workspace.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap_or_else(|| Path::new("."))
}

/// The folder of cargo's output.
pub(crate) fn built() -> PathBuf {
    // Joining leaves a path alone that is absolute.
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// Cargo with these words in the project's root, and its output in the one folder for that.
pub(crate) fn cargo(words: &str) -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo
        .args(words.split_whitespace())
        .current_dir(root())
        .env("CARGO_TARGET_DIR", built());
    cargo
}

/// Installs a target of the compiler that the project names.
pub(crate) fn add_target(target: &str) -> Result<(), String> {
    let mut rustup = Command::new("rustup");
    run(rustup
        .args(["--quiet", "target", "add", target])
        .current_dir(root()))
}

/// Runs a program, which must succeed.
pub(crate) fn run(command: &mut Command) -> Result<(), String> {
    let name = command.get_program().display().to_string();
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{name} fails ({status})")),
        Err(error) => Err(format!("{name} does not start ({error})")),
    }
}
