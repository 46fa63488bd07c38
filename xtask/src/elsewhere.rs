//! Somebody else's firmware: it builds for three cores and runs on two emulated boards.

use std::process::Command;

use crate::{emulator, firmware};

/// Where it is, a workspace of its own.
const FOLDER: &str = "examples/own-firmware";

/// Its targets, and the board of each that is emulated.
const TARGETS: [(&str, Option<&str>); 3] = [
    ("thumbv6m-none-eabi", Some("microbit")),
    ("thumbv7em-none-eabihf", Some(emulator::BOARD)),
    ("thumbv8m.main-none-eabihf", None),
];

/// Builds and runs it.
pub(crate) fn check() -> Result<(), String> {
    let folder = firmware::root().join(FOLDER);
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    for (target, board) in TARGETS {
        let status = Command::new(&cargo)
            .current_dir(&folder)
            .args(["build", "--release", "--locked", "--target", target])
            .args(["--target-dir", "target"])
            .status()
            .map_err(|error| format!("cargo does not start: {error}"))?;
        if !status.success() {
            return Err(format!("{FOLDER} does not build for {target}"));
        }
        let Some(board) = board else {
            println!("{target}: builds");
            continue;
        };
        let binary = folder
            .join("target")
            .join(target)
            .join("release/own-firmware");
        emulator::run_on(board, &binary)?;
        println!("{target}: builds, and finds its servo on an emulated {board}");
    }
    Ok(())
}
