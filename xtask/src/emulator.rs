//! An emulated Olimex STM32-H405, which carries the STM32F405RG, one instruction a tick.

use std::path::Path;
use std::process::{Command, Stdio};

/// The board that the firmware is for.
pub(crate) const BOARD: &str = "olimex-stm32-h405";

/// Runs a binary to its end and answers with what it printed.
pub(crate) fn run(binary: &Path) -> Result<String, String> {
    run_on(BOARD, binary)
}

/// The same on another board.
pub(crate) fn run_on(board: &str, binary: &Path) -> Result<String, String> {
    let output = Command::new("qemu-system-arm")
        .args([
            "-M",
            board,
            "-nographic",
            "-monitor",
            "none",
            "-serial",
            "null",
        ])
        .args(["-icount", "shift=0,sleep=off"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(binary)
        .stdin(Stdio::null())
        .output()
        .map_err(|error| {
            format!(
                "qemu-system-arm does not start ({error}): it must be version 8.1 or later, from \
                 Debian's backports for instance"
            )
        })?;
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        Ok(printed)
    } else {
        Err(format!(
            "{} ended with {}: {printed}{}",
            binary.display(),
            output.status,
            String::from_utf8_lossy(&output.stderr)
        ))
    }
}
