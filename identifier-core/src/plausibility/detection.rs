use crate::reason::Reason;

/// Within how many samples a fault is found, from the sample in which it begins to show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Samples running that are late.
    pub overrun: u32,
    /// Samples running without a reading.
    pub encoder_lost: u32,
    /// A jump of so many counts, or more, is found in the sample in which it happens.
    pub smallest_jump: f64,
    /// Samples with a speed of 1.25 times what is allowed, and three counts in the time that a speed is
    /// the mean of.
    pub speed: u32,
    /// Samples at standstill under a command that must move the servo.
    pub standing: u32,
    /// Samples of motion in which the command changes enough to tell.
    pub response: u32,
    /// Swings of an oscillation,
    pub swings: u32,
    /// none longer than so many samples.
    pub longest_swing: u32,
}

impl Detection {
    /// Within how many samples a reason is found; none for one that is not plausibility's to find.
    #[must_use]
    pub fn samples(&self, reason: Reason) -> Option<u32> {
        Some(match reason {
            Reason::Overrun => self.overrun,
            Reason::EncoderLost => self.encoder_lost,
            Reason::EncoderJumped | Reason::TravelLeft => 1,
            Reason::SpeedExceeded => self.speed,
            // A servo whose actuator dies comes to rest first.
            Reason::EncoderStuck | Reason::ActuatorDead => self.standing + self.response,
            Reason::ActuatorWeak | Reason::Reversed => self.response,
            Reason::Oscillating => self.swings * self.longest_swing,
            _ => return None,
        })
    }
}
