//! Emulated boards.

use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use std::{io, thread};

use servo_id::port::Port;

/// The Olimex STM32-H405, which carries the STM32F405RG: the only one of the firmware's boards that is emulated, by the
/// name that its feature has too.
pub(crate) const BOARD: &str = "olimex-stm32-h405";

/// Time within which an emulator connects.
const PATIENCE: Duration = Duration::from_secs(30);

/// Time between two looks at whether it has.
const LOOK: Duration = Duration::from_millis(5);

/// Longest wait of a read of the serial line.
const TICK: Duration = Duration::from_millis(5);

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
    /// Starts a binary, the USART2 of which is the port; `more` are further arguments of the emulator.
    pub(crate) fn start(binary: &Path, more: &[&str]) -> Result<(Self, Port), String> {
        let line = Awaited::new()?;
        // The second serial line of the emulator is USART2.
        let child = emulator(BOARD, binary)
            .args(["-serial", "null", "-serial"])
            .arg(format!("tcp:{},nodelay=on", line.address))
            .args(more)
            .stdout(Stdio::null())
            .spawn()
            .map_err(missing)?;
        let mut running = Self(child);
        let stream = line.connection(&mut running)?;
        stream
            .set_nodelay(true)
            .and_then(|()| stream.set_read_timeout(Some(TICK)))
            .map_err(|error| error.to_string())?;
        Ok((running, Port::over("the emulator", stream)))
    }
}

/// An address of this machine to which an emulator connects. It is held before the emulator starts, so that no other
/// program can have it.
pub(crate) struct Awaited {
    listener: TcpListener,
    pub(crate) address: SocketAddr,
}

impl Awaited {
    pub(crate) fn new() -> Result<Self, String> {
        let bound = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).and_then(|listener| {
            listener.set_nonblocking(true)?;
            let address = listener.local_addr()?;
            Ok(Self { listener, address })
        });
        bound.map_err(|error| format!("no port is free on this machine: {error}"))
    }

    /// The emulator's connection.
    ///
    /// # Errors
    /// If it has ended, or does not connect in time.
    pub(crate) fn connection(&self, running: &mut Running) -> Result<TcpStream, String> {
        let until = Instant::now() + PATIENCE;
        loop {
            match self.listener.accept() {
                Ok((stream, _)) => {
                    let blocking = stream.set_nonblocking(false).map(|()| stream);
                    return blocking.map_err(|error| error.to_string());
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(error.to_string()),
            }
            if let Ok(Some(ended)) = running.0.try_wait() {
                return Err(format!("the emulator has ended with {ended}"));
            }
            if Instant::now() > until {
                return Err(format!(
                    "the emulator has not connected within {} s",
                    PATIENCE.as_secs()
                ));
            }
            thread::sleep(LOOK);
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn running(program: &str, argument: &str) -> Running {
        let child = Command::new(program).arg(argument).spawn();
        Running(child.expect("the program is there"))
    }

    #[test]
    fn an_emulator_that_has_ended_is_not_awaited() {
        let awaited = Awaited::new().expect("a port is free");
        let ended = awaited.connection(&mut running("sleep", "0"));
        assert!(ended.is_err_and(|fault| fault.contains("has ended with exit status: 0")));
    }

    #[test]
    fn a_connection_is_accepted_and_its_reads_wait() {
        let awaited = Awaited::new().expect("a port is free");
        let mut here = TcpStream::connect(awaited.address).expect("it listens");
        let mut there = awaited
            .connection(&mut running("sleep", "60"))
            .expect("it is connected");
        let sender = thread::spawn(move || {
            thread::sleep(2 * LOOK);
            io::Write::write_all(&mut here, &[7])
        });
        let mut byte = [0];
        io::Read::read_exact(&mut there, &mut byte).expect("a byte comes");
        assert_eq!(byte, [7]);
        sender.join().expect("it ends").expect("it is sent");
    }
}
