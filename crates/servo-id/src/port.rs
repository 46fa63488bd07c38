//! A line to a chip: a serial port, or the TCP port of an emulator.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use std::{fmt, thread};

use drive_link::{Command, FrameError, Message, Receiver, Report, Request, frame};
use serde::de::DeserializeOwned;

/// Bits a second of a serial port, as the firmware has it.
const BAUD: u32 = 1_000_000;

/// Longest wait for a connection to an emulator.
const MAX_CONNECTION_WAIT: Duration = Duration::from_secs(5);

/// Longest wait for the acknowledgement of a stop before the stop is repeated. A drive acknowledges within 2 ms, and a
/// USB adapter holds bytes back for up to 16 ms.
pub(crate) const STOP_INTERVAL: Duration = Duration::from_millis(20);

/// The time for which a stop is repeated.
const STOP_TIME: Duration = Duration::from_secs(1);

/// Stops that are sent before the program ends without waiting for an acknowledgement.
const LAST_STOPS: u32 = 3;

/// Longest wait of a read for a byte.
const TICK: Duration = Duration::from_millis(5);

/// Prefix of an emulator's address.
const TCP: &str = "tcp:";

/// A line to a chip.
pub struct Port {
    name: String,
    line: Box<dyn Line>,
    /// The line once more, for another thread.
    second: Option<Box<dyn Write + Send>>,
    receiver: Receiver,
    /// The number of the last request.
    id: u8,
}

/// A line, and the same for another thread.
type TwoLines = (Box<dyn Line>, Box<dyn Write + Send>);

trait Line: Read + Write + Send {}
impl<L: Read + Write + Send> Line for L {}

impl fmt::Debug for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Port")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// A fault of a line.
#[derive(Debug, thiserror::Error)]
#[error("{port}: {fault}")]
pub struct PortError {
    port: String,
    fault: String,
}

impl Port {
    /// Opens a serial port by its name, or an emulator's port as `tcp:HOST:PORT`.
    ///
    /// # Errors
    /// If there is no such port, or another program has it.
    pub fn open(name: &str) -> Result<Self, PortError> {
        let opened = match name.strip_prefix(TCP) {
            Some(address) => connect(address),
            None => open_serial(name),
        };
        let (line, second) = opened.map_err(|error| PortError {
            port: name.to_owned(),
            fault: match error.kind() {
                ErrorKind::ResourceBusy => error.to_string(),
                _ => format!(
                    "cannot be opened: {error}; a port is the name of a serial device, such as /dev/ttyUSB0, or \
                     tcp:HOST:PORT"
                ),
            },
        })?;
        Ok(Self {
            second: Some(second),
            ..Self::at(name, line)
        })
    }

    /// Over anything that carries bytes both ways. A read must end after a few milliseconds without a
    /// byte, with [`ErrorKind::WouldBlock`] or [`ErrorKind::TimedOut`].
    #[must_use]
    pub fn over(name: &str, stream: impl Read + Write + Send + 'static) -> Self {
        Self::at(name, buffered(stream))
    }

    fn at(name: &str, line: Box<dyn Line>) -> Self {
        // Random, as the last answer to the program before this one may still be on the line.
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        Self {
            name: name.to_owned(),
            line,
            second: None,
            receiver: Receiver::new(),
            id: now.map_or(0, |now| (now.subsec_micros() >> 4) as u8),
        }
    }

    /// A number for the next request.
    pub(crate) fn next_id(&mut self) -> u8 {
        self.id = self.id.wrapping_add(1);
        self.id
    }

    /// Sends a stop, which needs no answer to anything before it, until the drive acknowledges it or a second is over.
    /// False without an acknowledgement. A stop is the same in every version of the protocol from 18 on.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn stop(&mut self, hear: &impl Fn(&Report)) -> Result<bool, PortError> {
        let id = self.next_id();
        let is_done = |report: &Report| {
            hear(report);
            matches!(report, Report::Done { id: same } if *same == id)
        };
        let until = Instant::now() + STOP_TIME;
        while Instant::now() < until {
            self.send(&Request::without_order(id, Command::Stop))?;
            if self.listen(&is_done, STOP_INTERVAL)?.is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Sends stops from another thread, whatever this one waits for. The first call has it; it does nothing where the
    /// system has the line only once.
    pub(crate) fn last_stop(&mut self) -> impl FnOnce() + Send + 'static {
        let request = Request::without_order(self.next_id(), Command::Stop);
        let second = self.second.take().zip(framed(&request).ok());
        move || {
            if let Some((mut line, bytes)) = second {
                for _ in 0..LAST_STOPS {
                    // The program ends: nothing is left to report it to.
                    let _ = line.write_all(&bytes).and_then(|()| line.flush());
                    thread::sleep(STOP_INTERVAL);
                }
            }
        }
    }

    /// No answer came to a question that was repeated.
    pub(crate) fn unanswered(&self) -> PortError {
        self.fault(format_args!(
            "no drive answers: is a firmware of this program's version running there, at {BAUD} baud?"
        ))
    }

    /// Sends a message, after a zero: what was on the line before it cannot spoil it.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn send<Q: Message>(&mut self, message: &Q) -> Result<(), PortError> {
        let bytes = framed(message).map_err(|error| self.fault(error))?;
        self.line
            .write_all(&bytes)
            .and_then(|()| self.line.flush())
            .map_err(|error| self.broken(&error))
    }

    /// Writes raw bytes.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn write_raw(&mut self, bytes: &[u8]) -> Result<(), PortError> {
        self.line
            .write_all(bytes)
            .map_err(|error| self.broken(&error))
    }

    /// The first message that fits, if it comes before patience ends.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn listen<A: Message + DeserializeOwned>(
        &mut self,
        fits: &impl Fn(&A) -> bool,
        patience: Duration,
    ) -> Result<Option<A>, PortError> {
        let until = Instant::now() + patience;
        let mut byte = [0];
        // One byte at a time: what follows the message belongs to the next.
        while Instant::now() < until {
            match self.line.read(&mut byte) {
                Ok(0) => return Err(self.broken(&ErrorKind::BrokenPipe.into())),
                Ok(_) => {}
                Err(error) if is_silence(&error) => continue,
                Err(error) => return Err(self.broken(&error)),
            }
            let [byte] = byte;
            // A corrupted answer is requested again.
            if let Some(Ok(message)) = self.receiver.take::<A>(byte)
                && fits(&message)
            {
                return Ok(Some(message));
            }
        }
        Ok(None)
    }

    /// The same sentence whether reading or writing notices first that the other end is gone.
    fn broken(&self, error: &io::Error) -> PortError {
        match error.kind() {
            ErrorKind::BrokenPipe | ErrorKind::ConnectionReset | ErrorKind::ConnectionAborted => self.fault(
                "the connection is closed: the drive was switched off, or another program uses it",
            ),
            _ => self.fault(error),
        }
    }

    fn fault(&self, fault: impl fmt::Display) -> PortError {
        PortError {
            port: self.name.clone(),
            fault: fault.to_string(),
        }
    }
}

/// Buffered on the way in, so that a byte at a time costs little.
struct Stream<S> {
    incoming: io::BufReader<S>,
}

impl<S: Read> Read for Stream<S> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.incoming.read(bytes)
    }
}

impl<S: Write> Write for Stream<S> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.incoming.get_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.incoming.get_mut().flush()
    }
}

/// The frame of a message after a zero, to be written in one piece: two threads may write.
fn framed(message: &impl Message) -> Result<Vec<u8>, FrameError> {
    frame(message).map(|frame| [&[0], frame.as_slice()].concat())
}

fn connect(address: &str) -> io::Result<TwoLines> {
    let mut failed = ErrorKind::AddrNotAvailable.into();
    for address in address.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, MAX_CONNECTION_WAIT) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                stream.set_read_timeout(Some(TICK))?;
                let second = stream.try_clone()?;
                return Ok((buffered(stream), Box::new(second)));
            }
            Err(error) if error.kind() == ErrorKind::TimedOut => {
                let limit = MAX_CONNECTION_WAIT.as_secs();
                let fault = format!("nothing answers within {limit} s");
                failed = io::Error::new(ErrorKind::TimedOut, fault);
            }
            Err(error) => failed = error,
        }
    }
    Err(failed)
}

fn open_serial(name: &str) -> io::Result<TwoLines> {
    let opened = serialport::new(name, BAUD).timeout(TICK).open();
    let line = opened.map_err(|error| match error.kind() {
        // On Unix a lock of another program, and nothing else. On Windows a device that is not there, too.
        serialport::ErrorKind::NoDevice if cfg!(unix) => io::Error::new(
            ErrorKind::ResourceBusy,
            "another program holds the port: Ctrl-C in that program stops the drive; without it, switch the drive's \
             enable or the motor's supply off",
        ),
        _ => error.into(),
    })?;
    let second = line.try_clone()?;
    Ok((Box::new(line), Box::new(second)))
}

fn buffered(stream: impl Read + Write + Send + 'static) -> Box<dyn Line> {
    Box::new(Stream {
        incoming: io::BufReader::new(stream),
    })
}

fn is_silence(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted_line;

    #[test]
    fn a_stop_is_repeated_until_it_is_acknowledged_under_one_number() {
        let mut heard = 0;
        let (mut port, received) = scripted_line::port(move |request| {
            heard += 1;
            // The first two are lost.
            (heard > 2).then_some(Report::Done { id: request.id })
        });
        assert!(port.stop(&|_| ()).expect("the line is whole"));
        let sent = received.all();
        assert!(sent.len() >= 3, "{sent:?}");
        for request in &sent {
            assert_eq!((request.id, request.command), (sent[0].id, Command::Stop));
        }
    }

    #[test]
    fn a_stop_that_nobody_acknowledges_is_sent_for_a_second() {
        let (mut port, received) = scripted_line::port(|request| {
            // The answer to something else.
            Some(Report::Done {
                id: request.id.wrapping_add(1),
            })
        });
        let begun = Instant::now();
        assert!(!port.stop(&|_| ()).expect("the line is whole"));
        assert!(begun.elapsed() >= STOP_TIME);
        // A machine that is busy sends fewer, and one that is not no more.
        let sent = received.count(Command::Stop);
        assert!((2..=51).contains(&sent), "{sent}");
    }
}
