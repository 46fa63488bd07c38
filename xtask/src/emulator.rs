//! Emulated boards.

use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use host_sim::port::Port;

/// The Olimex STM32-H405, which carries the STM32F405RG: the board that the firmware is for.
pub(crate) const BOARD: &str = "olimex-stm32-h405";

/// Runs a binary to its end on a board and returns its output.
pub(crate) fn run(board: &str, binary: &Path) -> Result<String, String> {
    run_with(board, binary, &[])
}

/// The same with further arguments of the emulator.
pub(crate) fn run_with(board: &str, binary: &Path, more: &[&str]) -> Result<String, String> {
    let output = emulator(board, binary)
        .args(more)
        .args(["-serial", "null"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .output()
        .map_err(missing)?;
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

/// A board that runs until this is dropped.
pub(crate) struct Running(Child);

impl Running {
    /// Starts a binary and opens the port of its USART2; `more` are further arguments of the emulator.
    pub(crate) fn start(binary: &Path, more: &[&str]) -> Result<(Self, Port), String> {
        let name = format!("tcp:127.0.0.1:{}", free_port()?);
        // The second serial line of the emulator is USART2.
        let child = emulator(BOARD, binary)
            .args(["-serial", "null", "-serial"])
            .arg(format!("{name},server=on,wait=off,nodelay=on"))
            .args(more)
            .stdout(Stdio::null())
            .spawn()
            .map_err(missing)?;
        let running = Self(child);
        let mut last = String::new();
        for _ in 0..100 {
            match Port::open(&name) {
                Ok(port) => return Ok((running, port)),
                Err(error) => last = error.to_string(),
            }
            thread::sleep(Duration::from_millis(50));
        }
        Err(last)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The emulator's time is that of its instructions, one per tick: a slow machine is a slow board.
fn emulator(board: &str, binary: &Path) -> Command {
    let mut command = Command::new("qemu-system-arm");
    command
        .args(["-M", board, "-nographic", "-monitor", "none"])
        .args(["-icount", "shift=0,sleep=off", "-kernel"])
        .arg(binary)
        .stdin(Stdio::null());
    command
}

fn missing(error: io::Error) -> String {
    format!(
        "qemu-system-arm does not start ({error}): it must be version 9.1 or later; `.ci/run` says \
         where to get it"
    )
}

fn free_port() -> Result<u16, String> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, 0))
        .and_then(|listener| listener.local_addr())
        .map(|address| address.port())
        .map_err(|error| format!("no port is free on this machine: {error}"))
}
