/// A serial line that never blocks.
pub trait Line {
    /// Has everything that has arrived until now heard for stops before it returns, whatever of it is decoded yet.
    fn listen(&mut self);

    /// The next byte that was received and heard.
    fn receive(&mut self) -> Option<u8>;

    /// Bytes that can be sent now.
    fn room(&self) -> usize;

    /// Sends bytes for which there is room.
    fn send(&mut self, bytes: &[u8]);
}
