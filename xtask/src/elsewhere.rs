//! Somebody else's firmwares: they build for three cores and run on two emulated boards.

use std::process::Command;

use crate::{emulator, firmware};

/// Each is a workspace of its own in the folder of its name: one that takes our PID, and one with a
/// controller of its own, to which the identifier only listens.
const FIRMWARES: [&str; 2] = ["own-firmware", "own-cascade"];

/// Their targets, and the board of each that is emulated.
const TARGETS: [(&str, Option<&str>); 3] = [
    ("thumbv6m-none-eabi", Some("microbit")),
    ("thumbv7em-none-eabihf", Some(emulator::BOARD)),
    ("thumbv8m.main-none-eabihf", None),
];

/// Builds and runs them.
pub(crate) fn check() -> Result<(), String> {
    FIRMWARES.into_iter().try_for_each(check_one)
}

fn check_one(name: &str) -> Result<(), String> {
    let folder = firmware::root().join("examples").join(name);
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    for (target, board) in TARGETS {
        let status = Command::new(&cargo)
            .current_dir(&folder)
            .args(["build", "--release", "--locked", "--target", target])
            .args(["--target-dir", "target"])
            .status()
            .map_err(|error| format!("cargo does not start: {error}"))?;
        if !status.success() {
            return Err(format!("{name} does not build for {target}"));
        }
        let Some(board) = board else {
            println!("{name}, {target}: builds");
            continue;
        };
        let binary = folder
            .join("target")
            .join(target)
            .join("release")
            .join(name);
        emulator::run_on(board, &binary)?;
        println!("{name}, {target}: builds, and finds its servo on an emulated {board}");
    }
    Ok(())
}
