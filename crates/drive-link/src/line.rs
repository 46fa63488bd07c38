/// A line that nobody waits for.
pub trait Line {
    /// The next byte that came.
    fn hear(&mut self) -> Option<u8>;

    /// Bytes that can be said now.
    fn room(&self) -> usize;

    /// Says bytes for which there is room.
    fn say(&mut self, bytes: &[u8]);
}
