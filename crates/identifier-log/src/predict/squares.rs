/// Squares of an error and of its reference quantity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Squares {
    pub(super) error: f64,
    whole: f64,
}

impl Squares {
    pub(super) fn add(&mut self, recorded: f64, simulated: f64) {
        let error = recorded - simulated;
        self.error += error * error;
        self.whole += recorded * recorded;
    }

    /// ‖recorded − simulated‖/‖recorded‖.
    pub(super) fn relative(&self) -> f64 {
        (self.error / self.whole).sqrt()
    }
}
