//! A line for tests, whose other end answers by a script and keeps what it has received.

mod status;

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use drive_link::{Command, Receiver, Report, Request, State, frame};

use crate::port::Port;
pub(crate) use status::status;

type Script = Box<dyn FnMut(&Request) -> Option<Report> + Send>;

struct ScriptedLine {
    receiver: Receiver,
    script: Script,
    received: Received,
    answers: VecDeque<u8>,
}

/// What the other end has received.
#[derive(Clone, Default)]
pub(crate) struct Received(Arc<Mutex<Vec<Request>>>);

impl Received {
    pub(crate) fn all(&self) -> Vec<Request> {
        self.0.lock().expect("no thread panicked").clone()
    }

    pub(crate) fn commands(&self) -> Vec<Command> {
        self.all().iter().map(|request| request.command).collect()
    }

    /// The times that it has received a command.
    pub(crate) fn count(&self, wanted: Command) -> usize {
        let commands = self.commands();
        commands
            .iter()
            .filter(|&&command| command == wanted)
            .count()
    }
}

/// A port to a script.
pub(crate) fn port(
    script: impl FnMut(&Request) -> Option<Report> + Send + 'static,
) -> (Port, Received) {
    let received = Received::default();
    let line = ScriptedLine {
        receiver: Receiver::new(),
        script: Box::new(script),
        received: received.clone(),
        answers: VecDeque::new(),
    };
    (Port::over("script", line), received)
}

/// A drive that obeys: its state follows its orders, unless an answer is the script's own.
pub(crate) fn obedient(
    mut own: impl FnMut(&Request) -> Option<Option<Report>> + Send + 'static,
) -> (Port, Received) {
    let mut state = State::Disabled;
    port(move |request| {
        let id = request.id;
        match request.command {
            Command::Start => state = State::Running,
            Command::Stop => state = State::Disabled,
            _ => {}
        }
        own(request).unwrap_or(Some(match request.command {
            Command::Hello | Command::KeepAlive => Report::Status {
                id: Some(id),
                status: status(state),
            },
            _ => Report::Done { id },
        }))
    })
}

impl Write for ScriptedLine {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for &byte in bytes {
            let Some(request) = self.receiver.take_request(byte) else {
                continue;
            };
            let request = request.expect("only whole requests are sent");
            let mut received = self.received.0.lock().expect("no thread panicked");
            received.push(request);
            drop(received);
            if let Some(report) = (self.script)(&request) {
                self.answers.extend(frame(&report).expect("it fits"));
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Read for ScriptedLine {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match (self.answers.pop_front(), bytes.first_mut()) {
            (Some(answer), Some(place)) => {
                *place = answer;
                Ok(1)
            }
            _ => {
                thread::sleep(Duration::from_millis(1));
                Err(ErrorKind::TimedOut.into())
            }
        }
    }
}
