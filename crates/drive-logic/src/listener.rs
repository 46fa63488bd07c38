//! Stops in the bytes of the line, obeyed as they arrive.

use drive_link::{Line, StopListener};
use heapless::Deque;

use crate::channel::LineEnd;

/// Listens to the line below the sample interrupt and above the background. A stop waits for no work of the background.
#[derive(Debug)]
pub struct LineListener<'a> {
    end: LineEnd<'a>,
    stops: StopListener,
}

impl<'a> LineListener<'a> {
    /// Before the first byte.
    #[must_use]
    pub const fn new(end: LineEnd<'a>) -> Self {
        Self {
            end,
            stops: StopListener::new(),
        }
    }

    /// Takes in a byte that was received; a whole stop disables the servo with the next sample.
    #[inline]
    pub fn take(&mut self, byte: u8) {
        if self.stops.take(byte) {
            self.end.stop(self.stops.is_resent());
        }
    }

    /// Takes in that bytes were lost or damaged. Orders that are not given yet are refused, for a stop may have been
    /// among them.
    pub fn disturbed(&mut self) {
        self.end.count_disturbance();
    }
}

/// Bytes that may wait to be decoded: two of the longest frames, and a power of two.
const WAITING: usize = 2048;
const _: () = assert!(WAITING > 2 * drive_link::MAX_FRAME_BYTES);

/// A line without an interrupt of its own, which is heard when the background looks at it.
#[derive(Debug)]
pub struct PolledLine<'a, L> {
    line: L,
    listener: LineListener<'a>,
    waiting: Deque<u8, WAITING>,
}

impl<'a, L> PolledLine<'a, L> {
    /// Listens to a line.
    pub const fn new(line: L, listener: LineListener<'a>) -> Self {
        Self {
            line,
            listener,
            waiting: Deque::new(),
        }
    }

    /// The line itself.
    pub fn line(&mut self) -> &mut L {
        &mut self.line
    }
}

impl<L: Line> Line for PolledLine<'_, L> {
    fn listen(&mut self) {
        self.line.listen();
        while let Some(byte) = self.line.receive() {
            // One that finds no room is lost, which spoils its frame; but no stop.
            let _ = self.waiting.push_back(byte);
            self.listener.take(byte);
        }
    }

    fn receive(&mut self) -> Option<u8> {
        self.waiting.pop_front()
    }

    fn room(&self) -> usize {
        self.line.room()
    }

    fn send(&mut self, bytes: &[u8]) {
        self.line.send(bytes);
    }
}
