/// A serial line that never blocks.
pub trait Line {
    /// The next byte that was received.
    fn receive(&mut self) -> Option<u8>;

    /// Bytes that can be sent now.
    fn room(&self) -> usize;

    /// Sends bytes for which there is room.
    fn send(&mut self, bytes: &[u8]);
}
