//! A line to a chip: a serial port, or the TCP port of an emulator.

use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use drive_link::{Receiver, frame};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Bits a second of a serial port, as the firmware has it.
const BAUD: u32 = 1_000_000;

/// Longest wait for an answer before the question is repeated.
const PATIENCE: Duration = Duration::from_millis(1000);

/// Times that a question is asked.
const TRIES: u32 = 5;

/// Longest wait of a read for a byte.
const TICK: Duration = Duration::from_millis(5);

/// Prefix of an emulator's address.
const TCP: &str = "tcp:";

/// A line to a chip.
pub struct Port {
    name: String,
    line: Box<dyn Line>,
    receiver: Receiver,
}

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
        let line = match name.strip_prefix(TCP) {
            Some(address) => connect(address),
            None => serialport::new(name, BAUD)
                .timeout(TICK)
                .open()
                .map(|port| Box::new(port) as Box<dyn Line>)
                .map_err(io::Error::from),
        };
        match line {
            Ok(line) => Ok(Self {
                name: name.to_owned(),
                line,
                receiver: Receiver::new(),
            }),
            Err(error) => Err(PortError {
                port: name.to_owned(),
                fault: format!(
                    "cannot be opened: {error}; a port is the name of a serial device, such as /dev/ttyUSB0, or \
                     tcp:HOST:PORT"
                ),
            }),
        }
    }

    /// Over anything that carries bytes both ways. A read must end after a few milliseconds without a
    /// byte, with [`ErrorKind::WouldBlock`] or [`ErrorKind::TimedOut`].
    #[must_use]
    pub fn over(name: &str, stream: impl Read + Write + Send + 'static) -> Self {
        Self {
            name: name.to_owned(),
            line: buffered(stream),
            receiver: Receiver::new(),
        }
    }

    /// Asks until an answer comes that fits the question.
    ///
    /// # Errors
    /// If the line breaks, or no answer comes.
    pub fn ask<Q: Serialize, A: DeserializeOwned>(
        &mut self,
        question: &Q,
        fits: impl Fn(&A) -> bool,
    ) -> Result<A, PortError> {
        for _ in 0..TRIES {
            self.send(question)?;
            if let Some(answer) = self.listen(&fits, PATIENCE)? {
                return Ok(answer);
            }
        }
        Err(self.fault(format_args!(
            "no drive answers: is a firmware of this program's version running there, at {BAUD} baud?"
        )))
    }

    /// Sends a message, after a zero: what was on the line before it cannot spoil it.
    ///
    /// # Errors
    /// If the line breaks.
    pub fn send<Q: Serialize>(&mut self, message: &Q) -> Result<(), PortError> {
        let framed = frame(message).map_err(|error| self.fault(error))?;
        self.line
            .write_all(&[0])
            .and_then(|()| self.line.write_all(&framed))
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
    pub fn listen<A: DeserializeOwned>(
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

fn connect(address: &str) -> io::Result<Box<dyn Line>> {
    let stream = TcpStream::connect(address)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(TICK))?;
    Ok(buffered(stream))
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
