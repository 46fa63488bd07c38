/// The twist of the spring over a piece of a sample.
#[derive(Clone, Copy)]
pub(super) struct Twisting {
    /// w and ẇ.
    pub(super) twist: f64,
    pub(super) rate: f64,
    /// The acceleration of the load.
    pub(super) carried: f64,
}

impl Twisting {
    pub(super) const NONE: Self = Self {
        twist: 0.0,
        rate: 0.0,
        carried: 0.0,
    };

    /// In the middle of a piece of this length.
    pub(super) fn middle(&self, length: f64) -> f64 {
        self.twist + 0.5 * length * self.rate
    }

    /// At the end of the piece, the motor being faster by this.
    pub(super) fn end(&mut self, length: f64, faster: f64) {
        let before = self.rate;
        self.rate += faster - length * self.carried;
        self.twist += 0.5 * length * (before + self.rate);
    }
}
