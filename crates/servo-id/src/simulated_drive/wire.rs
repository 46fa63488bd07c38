use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;

use drive_link::Line;

/// Bytes that may wait to be read, as many as in a drive's own memory.
const ROOM: usize = 16_384;

/// Bytes that are read at a time.
const GULP: usize = 1024;

/// The wire to a connected host; without one, sent bytes are lost.
#[derive(Debug, Default)]
pub struct Wire {
    line: Option<TcpStream>,
    outgoing: VecDeque<u8>,
    incoming: VecDeque<u8>,
}

impl Wire {
    /// A client connects and replaces the one before: a serial line has one other end.
    pub fn connect(&mut self, line: TcpStream) {
        let ready = line
            .set_nonblocking(true)
            .and_then(|()| line.set_nodelay(true));
        *self = Self {
            line: ready.is_ok().then_some(line),
            ..Self::default()
        };
    }

    /// Sends as much as goes without waiting.
    pub fn flush(&mut self) {
        while let (Some(line), false) = (&mut self.line, self.outgoing.is_empty()) {
            let (next, _) = self.outgoing.as_slices();
            match line.write(next) {
                Ok(sent @ 1..) => drop(self.outgoing.drain(..sent)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                _ => self.line = None,
            }
        }
        if self.line.is_none() {
            self.outgoing.clear();
        }
    }

    /// True if bytes wait to be read.
    pub fn has_received(&mut self) -> bool {
        if self.incoming.is_empty() {
            self.gulp();
        }
        !self.incoming.is_empty()
    }

    /// Takes in what has arrived.
    fn gulp(&mut self) {
        let mut gulp = [0; GULP];
        let Some(line) = &mut self.line else { return };
        match line.read(&mut gulp) {
            Ok(read @ 1..) => self.incoming.extend(gulp.iter().take(read)),
            Err(error)
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            _ => self.line = None,
        }
    }
}

impl Line for Wire {
    fn listen(&mut self) {}

    fn receive(&mut self) -> Option<u8> {
        self.has_received();
        self.incoming.pop_front()
    }

    fn room(&self) -> usize {
        ROOM.saturating_sub(self.outgoing.len())
    }

    fn send(&mut self, bytes: &[u8]) {
        self.outgoing.extend(bytes);
    }
}
