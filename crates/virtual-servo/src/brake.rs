/// A holding brake on the motor's shaft: it opens some time after it gets power, and closes some time after it loses it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualBrake {
    /// The times that it takes, s.
    opens: f64,
    closes: f64,
    is_powered: bool,
    /// Since the power changed, s.
    passed: f64,
    is_closed: bool,
}

impl VirtualBrake {
    /// The longest time in which a brake may open or close, s.
    pub const MAX_TIME: f64 = 1.0;

    /// Closed, without power; with the times that it takes to open and to close, s.
    #[must_use]
    pub fn closed(opens: f64, closes: f64) -> Self {
        Self {
            opens,
            closes,
            is_powered: false,
            passed: closes,
            is_closed: true,
        }
    }

    /// True if it holds the motor for the next time, s, with or without power.
    pub fn holds(&mut self, is_powered: bool, time: f64) -> bool {
        if is_powered != self.is_powered {
            (self.is_powered, self.passed) = (is_powered, 0.0);
        }
        let needed = if is_powered { self.opens } else { self.closes };
        // Half of the time, for sums of times are not exact.
        if self.passed + 0.5 * time >= needed {
            self.is_closed = !is_powered;
        }
        self.passed += time;
        self.is_closed
    }
}
