//! The line to the drive, in a thread of its own. However long a screen or a disk takes, reports are read and the link
//! is kept alive.

mod event;
mod talk;

use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread::{self, JoinHandle};

use drive_link::Command;

pub use self::event::{Ending, LinkError, LinkEvent};
use self::talk::Talk;
use crate::drive::{AtEnd, Driven};

/// The line to a drive, served by a thread. However it is dropped, the servo is left as [`AtEnd`] orders.
#[derive(Debug)]
pub struct Link {
    orders: Option<Sender<Command>>,
    events: Receiver<LinkEvent>,
    thread: Option<JoinHandle<Result<Ending, LinkError>>>,
}

impl Link {
    /// Serves a drive.
    #[must_use]
    pub fn open(drive: Driven, at_end: AtEnd) -> Self {
        let (orders, ordered) = mpsc::channel();
        let (report, events) = mpsc::channel();
        let thread = thread::spawn(move || {
            let mut talk = Talk::new(drive, report);
            talk.run(&ordered)?;
            talk.end(at_end)
        });
        Self {
            orders: Some(orders),
            events,
            thread: Some(thread),
        }
    }

    /// Sends a command; its answer is an event.
    pub fn order(&self, command: Command) {
        if let Some(orders) = &self.orders {
            // The loss of the line is an event of its own.
            let _ = orders.send(command);
        }
    }

    /// The next event, if there is one.
    pub fn next_event(&mut self) -> Option<LinkEvent> {
        match self.events.try_recv() {
            Ok(event) => Some(event),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => self.end().err().map(LinkEvent::Lost),
        }
    }

    /// Ends it, and returns how the servo was left.
    ///
    /// # Errors
    /// If the drive is lost, or does not release its servo.
    pub fn close(mut self) -> Result<Ending, LinkError> {
        self.end()
    }

    fn end(&mut self) -> Result<Ending, LinkError> {
        self.orders = None;
        let ended = self.thread.take().and_then(|thread| thread.join().ok());
        ended.unwrap_or(Err(LinkError::Ended))
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        if self.thread.is_some() {
            // Nothing is left to report it to.
            let _ = self.end();
        }
    }
}
