//! An emulated Olimex STM32-H405, which carries the STM32F405RG.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener};
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
    /// Starts a binary, with more arguments for the emulator, and opens its port.
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
    /// The same, an instruction a tick, with a line that is a file in one direction and a pipe in the
    /// other, of the folder that is given: a byte then costs a fraction of what it costs at a socket.
    pub(crate) fn start_beside(binary: &Path, folder: &Path) -> Result<(Self, Port), String> {
        let fault = |error: io::Error| format!("{}: {error}", folder.display());
        std::fs::create_dir_all(folder).map_err(fault)?;
        let (said, asked) = (folder.join("said"), folder.join("asked"));
        std::fs::write(&said, []).map_err(fault)?;
        let _ = std::fs::remove_file(&asked);
        let made = Command::new("mkfifo").arg(&asked).status().map_err(fault)?;
        if !made.success() {
            return Err(format!("{} cannot be made", asked.display()));
        }
        let child = emulator(BOARD)
            .arg("-chardev")
            .arg(format!(
                "file,id=line,path={},input-path={}",
                said.display(),
                asked.display()
            ))
            .args(["-serial", "null", "-serial", "chardev:line"])
            .args(["-icount", "shift=0,sleep=off", "-kernel"])
            .arg(binary)
            .stdout(Stdio::null())
            .spawn()
            .map_err(missing)?;
        let running = Self(child);
        // Waits until the emulator has opened the other end.
        let asked = File::options().write(true).open(&asked).map_err(fault)?;
        let said = File::open(&said).map_err(fault)?;
        Ok((running, Port::over("the emulator", Files { said, asked })))
    }
}

/// A line of two files.
struct Files {
    said: File,
    asked: File,
}

impl Read for Files {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self.said.read(bytes)? {
            0 => {
                thread::sleep(Duration::from_millis(5));
                Err(ErrorKind::WouldBlock.into())
            }
            read => Ok(read),
        }
    }
}

impl Write for Files {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.asked.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.asked.flush()
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
