use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;

use drive_link::Line;

/// Bytes that wait for somebody to read them: then there is no room, as in a drive's own memory.
const ROOM: usize = 16_384;

/// Bytes that are read at a time.
const GULP: usize = 1024;

/// The wire to whoever is connected; without anybody, what is said is lost.
#[derive(Debug, Default)]
pub struct Wire {
    line: Option<TcpStream>,
    said: VecDeque<u8>,
    heard: VecDeque<u8>,
}

impl Wire {
    /// Somebody connects, and takes the place of whoever did before: a serial line has one other end.
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
        while let (Some(line), false) = (&mut self.line, self.said.is_empty()) {
            let (next, _) = self.said.as_slices();
            match line.write(next) {
                Ok(sent @ 1..) => drop(self.said.drain(..sent)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                _ => self.line = None,
            }
        }
        if self.line.is_none() {
            self.said.clear();
        }
    }

    fn listen(&mut self) {
        let mut gulp = [0; GULP];
        let Some(line) = &mut self.line else { return };
        match line.read(&mut gulp) {
            Ok(heard @ 1..) => self.heard.extend(gulp.iter().take(heard)),
            Err(error)
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            _ => self.line = None,
        }
    }
}

impl Line for Wire {
    fn receive(&mut self) -> Option<u8> {
        if self.heard.is_empty() {
            self.listen();
        }
        self.heard.pop_front()
    }

    fn room(&self) -> usize {
        ROOM.saturating_sub(self.said.len())
    }

    fn send(&mut self, bytes: &[u8]) {
        self.said.extend(bytes);
    }
}
