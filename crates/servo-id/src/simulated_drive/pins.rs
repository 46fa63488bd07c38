use drive_logic::Chip;

/// The pins of a chip, led to a simulated servo.
pub trait SimulatedPins: Chip {
    /// Latches encoder and lines at the beginning of a sample.
    fn begin_sample(&mut self) {}

    /// Moves the servo until the next sample.
    fn pass(&mut self, sample_time: f64);

    /// The drive has power.
    fn is_powered(&self) -> bool {
        true
    }
}
