//! An emulated Olimex STM32-H405, which carries the STM32F405RG.

use std::net::{Ipv4Addr, TcpListener};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use host_sim::port::Port;

/// The board that the firmware is for.
pub(crate) const BOARD: &str = "olimex-stm32-h405";

/// Runs a binary to its end, one instruction a tick, and answers with what it printed.
pub(crate) fn run(binary: &Path) -> Result<String, String> {
    run_on(BOARD, binary)
}

/// The same on another board.
pub(crate) fn run_on(board: &str, binary: &Path) -> Result<String, String> {
    let output = emulator(board)
        .args(["-serial", "null"])
        .args(["-icount", "shift=0,sleep=off"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(binary)
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

/// A board that goes on running, with its USART2 at the end of a port; it ends when this is dropped.
pub(crate) struct Running(Child);

impl Running {
    /// Starts a binary and opens its port.
    pub(crate) fn start(binary: &Path) -> Result<(Self, Port), String> {
        Self::start_with(binary, &[])
    }

    /// The same with more arguments for the emulator.
    pub(crate) fn start_with(binary: &Path, more: &[String]) -> Result<(Self, Port), String> {
        let number = free_port()?;
        // The second serial line of the emulator is USART2.
        let child = emulator(BOARD)
            .args(["-serial", "null", "-serial"])
            .arg(format!(
                "tcp:127.0.0.1:{number},server=on,wait=off,nodelay=on"
            ))
            .args(more)
            .arg("-kernel")
            .arg(binary)
            .stdout(Stdio::null())
            .spawn()
            .map_err(missing)?;
        let running = Self(child);
        let name = format!("tcp:127.0.0.1:{number}");
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

impl Running {
    /// The same, an instruction a tick, with its port at a socket of this machine, which takes a
    /// fraction of the time for every byte.
    pub(crate) fn start_near(binary: &Path) -> Result<(Self, Port), String> {
        let socket = std::env::temp_dir().join(format!("drive-{}", std::process::id()));
        let _ = std::fs::remove_file(&socket);
        let child = emulator(BOARD)
            .args(["-serial", "null", "-serial"])
            .arg(format!("unix:{},server=on,wait=off", socket.display()))
            .args(["-icount", "shift=0,sleep=off", "-kernel"])
            .arg(binary)
            .stdout(Stdio::null())
            .spawn()
            .map_err(missing)?;
        let running = Self(child);
        let mut last = String::new();
        for _ in 0..100 {
            match UnixStream::connect(&socket).and_then(|stream| {
                stream.set_read_timeout(Some(Duration::from_millis(5)))?;
                Ok(stream)
            }) {
                Ok(stream) => {
                    let _ = std::fs::remove_file(&socket);
                    return Ok((running, Port::over(&socket.display().to_string(), stream)));
                }
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

fn emulator(board: &str) -> Command {
    let mut command = Command::new("qemu-system-arm");
    command
        .args(["-M", board, "-nographic", "-monitor", "none"])
        .stdin(Stdio::null());
    command
}

fn missing(error: std::io::Error) -> String {
    format!(
        "qemu-system-arm does not start ({error}): it must be version 8.1 or later, from Debian's \
         backports for instance"
    )
}

fn free_port() -> Result<u16, String> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, 0))
        .and_then(|listener| listener.local_addr())
        .map(|address| address.port())
        .map_err(|error| format!("no port is free on this machine: {error}"))
}
