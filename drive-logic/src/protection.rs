//! What lets the servo go while the loop runs.

use drive_link::{Fault, NotAllowed, Settings};
use identifier_core::control::ControlSample;
use identifier_core::units::Units;

use crate::parts::out_of_range;
use crate::reference::FARTHEST;

/// Part of the command limit from which on a servo counts as being driven.
const AT_THE_LIMIT: f64 = 0.9;

/// Part of the largest position error from which on it does.
const IN_ERROR: f64 = 0.05;

/// Counts within which a servo has not moved: one line of an encoder that is broken still flickers.
const FLICKER: f32 = 4.0;

/// The watch over one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Protection {
    following_error: f32,
    in_error: f32,
    strong: f32,
    stalled_most: u32,
    /// Samples running in which the servo was driven and did not move, and how far it moved in them.
    stalled: u32,
    moved: f32,
    late_most: u32,
    late: u32,
}

impl Protection {
    /// With the lowest and the highest command.
    ///
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(
        settings: &Settings,
        [low, high]: [f64; 2],
        units: &Units,
    ) -> Result<Self, NotAllowed> {
        let given = &settings.protection;
        for (name, value) in [
            ("following_error", given.following_error),
            ("travel", given.travel),
            ("speed", given.speed),
            ("stall_time", given.stall_time),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(out_of_range(name, value, (f64::MIN_POSITIVE, f64::MAX)));
            }
        }
        let farthest = FARTHEST * units.position_unit();
        if given.travel > farthest {
            let within = (f64::MIN_POSITIVE, farthest);
            return Err(out_of_range("travel", given.travel, within));
        }
        if given.overruns == 0 {
            return Err(out_of_range("overruns", 0.0, (1.0, 255.0)));
        }
        let limit = high.min(-low);
        Ok(Self {
            following_error: (given.following_error * units.position()) as f32,
            in_error: (IN_ERROR * given.following_error * units.position()) as f32,
            strong: (AT_THE_LIMIT * limit) as f32,
            stalled_most: (given.stall_time / units.sample_time()) as u32,
            stalled: 0,
            moved: 0.0,
            late_most: u32::from(given.overruns),
            late: 0,
        })
    }

    /// Looks at a sample.
    #[inline]
    pub(crate) fn check(&mut self, sample: &ControlSample<f32>) -> Result<(), Fault> {
        if sample.error.abs() > self.following_error {
            return Err(Fault::FollowingError);
        }
        let driven = sample.error.abs() > self.in_error || sample.command.abs() >= self.strong;
        self.moved += sample.increment;
        if driven && self.moved.abs() <= FLICKER {
            self.stalled = self.stalled.saturating_add(1);
        } else {
            self.stalled = 0;
            self.moved = 0.0;
        }
        if self.stalled > self.stalled_most {
            Err(Fault::EncoderSilent)
        } else {
            Ok(())
        }
    }

    /// Takes in whether a sample ended too late.
    #[inline]
    pub(crate) fn ended(&mut self, late: bool) -> Result<(), Fault> {
        self.late = if late { self.late.saturating_add(1) } else { 0 };
        if self.late >= self.late_most {
            Err(Fault::Overrun)
        } else {
            Ok(())
        }
    }
}
