//! The serial line of a drive.

use std::collections::VecDeque;

use drive_link::{Command, Line, Request, frame};

/// A request as a host frames it, of which an order has the same number.
pub(crate) fn request_bytes(id: u8, command: Command) -> Vec<u8> {
    order_bytes(id, u32::from(id), command)
}

/// The same with another number of the order.
pub(crate) fn order_bytes(id: u8, order: u32, command: Command) -> Vec<u8> {
    let order = if command.may_move() { order } else { 0 };
    frame(&Request { id, order, command })
        .expect("it fits")
        .to_vec()
}

/// Bytes that the firmware's queues hold.
pub(crate) const ROOM: usize = 2047;

/// The bytes that wait at the drive's end of the line.
#[derive(Default)]
pub(crate) struct Wires {
    pub(crate) heard: VecDeque<u8>,
    pub(crate) to_say: VecDeque<u8>,
}

impl Line for Wires {
    fn listen(&mut self) {}

    fn receive(&mut self) -> Option<u8> {
        self.heard.pop_front()
    }

    fn room(&self) -> usize {
        ROOM - self.to_say.len()
    }

    fn send(&mut self, bytes: &[u8]) {
        assert!(bytes.len() <= self.room());
        self.to_say.extend(bytes);
    }
}

/// Numbers that look random, the same in every run.
pub(crate) struct Random(pub(crate) u32);

impl Random {
    pub(crate) fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    pub(crate) fn below(&mut self, most: u32) -> u32 {
        self.next() % most
    }
}
