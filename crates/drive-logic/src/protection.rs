//! What lets the servo go while the loop runs.

use drive_link::{Dither, Fault, NotAllowed, Settings};
use identifier_core::control::ControlSample;
use identifier_core::settings::ControllerSettings;
use identifier_core::units::Units;

use crate::chip::Lines;
use crate::held::Held;
use crate::line_watch::LineWatch;
use crate::parts::{out_of_range, too_small};
use crate::reference::FARTHEST;
use crate::time::samples;

/// Amplitudes of the dither that the largest position error must leave room for: a step of two, and
/// the overshoot that the step before may have left.
const AMPLITUDES_OF_ERROR: f64 = 3.0;

/// Amplitudes of the dither by which targets stay within the travel.
const AMPLITUDES_OF_TRAVEL: f64 = 2.0;

/// Part of the command that the dither asks for, which must move the servo: otherwise there is nothing
/// to identify from, or no encoder.
const OF_DITHER: f64 = 0.9;

/// Counts within which a servo has not moved: one line of an encoder that is broken still flickers.
const FLICKER: u32 = 4;

/// The time over which the speed is averaged, s.
const SPEED_TIME: f64 = 5e-3;

/// Counts by which a distance is uncertain: each of its ends by one.
const ROUNDING: f64 = 2.0;

/// Part by which a product of decimal fractions may be off.
const ROUNDING_OF_DECIMALS: f64 = 1e-9;

/// The largest distance that is told from its opposite.
const MOST: u32 = i32::MAX.unsigned_abs();

/// The watch over one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Protection {
    following_error: f32,
    travel: u32,
    started_at: i32,
    speed: SpeedWatch,
    stall: StallWatch,
    lines: LineWatch,
    late_most: u32,
    late: u32,
}

/// Whether the servo goes further in a while than its speed allows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SpeedWatch {
    /// Samples of a while, and those that are left of it.
    while_long: u32,
    left: u32,
    most: u32,
    from: i32,
}

/// Whether the servo moves when it must: when the command has changed by as much since it last moved.
/// What holds a load at rest is not such a command.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StallWatch {
    change: f32,
    most: u32,
    /// Samples since the last motion in which the servo was driven; where it came to rest, and at which
    /// command.
    stalled: u32,
    from: i32,
    at_rest: f32,
}

/// How far a target may be from where the servo started, rad.
pub(crate) fn reach(settings: &Settings) -> f64 {
    settings.protection.travel - AMPLITUDES_OF_TRAVEL * settings.dither.amplitude
}

impl Protection {
    /// Of a run with this controller.
    ///
    /// # Errors
    /// The setting that is not allowed, or that contradicts another.
    pub(crate) fn new(
        settings: &Settings,
        controller: &ControllerSettings,
        units: &Units,
    ) -> Result<Self, NotAllowed> {
        let given = &settings.protection;
        for (name, value) in [
            ("following_error", given.following_error),
            ("travel", given.travel),
            ("pace", given.pace),
            ("speed", given.speed),
            ("breakaway", given.breakaway),
            ("stall_time", given.stall_time),
            ("stop_time", given.stop_time),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(out_of_range(name, value, (f64::MIN_POSITIVE, f64::MAX)));
            }
        }
        for (name, value) in [
            ("duration", given.duration),
            ("link_timeout", given.link_timeout),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(out_of_range(name, value, (0.0, f64::MAX)));
            }
        }
        if given.overruns == 0 {
            return Err(out_of_range("overruns", 0.0, (1.0, 255.0)));
        }
        let farthest = FARTHEST * units.position_unit();
        if given.travel > farthest {
            let within = (f64::MIN_POSITIVE, farthest);
            return Err(out_of_range("travel", given.travel, within));
        }
        let [low, high] = controller.limit;
        let limit = high.min(-low);
        if given.breakaway > 1.0 {
            let within = (f64::MIN_POSITIVE, 1.0);
            return Err(out_of_range("breakaway", given.breakaway, within));
        }
        let breakaway = given.breakaway * limit;
        let Dither { amplitude, .. } = settings.dither;
        for (name, value, least, other) in [
            (
                "following_error",
                given.following_error,
                AMPLITUDES_OF_ERROR * amplitude,
                "dither's amplitude",
            ),
            (
                "travel",
                given.travel,
                AMPLITUDES_OF_TRAVEL * amplitude,
                "dither's amplitude",
            ),
            ("speed", given.speed, given.pace, "pace"),
        ] {
            if value < least * (1.0 - ROUNDING_OF_DECIMALS) {
                return Err(too_small(name, value, least, other));
            }
        }
        let of_dither = OF_DITHER * controller.kp * amplitude;
        let stalls_at = if of_dither > 0.0 {
            breakaway.min(of_dither)
        } else {
            breakaway
        };
        let while_long = samples(SPEED_TIME, units);
        let counts_in_a_while = given.speed * units.velocity() * f64::from(while_long);
        Ok(Self {
            following_error: (given.following_error * units.position()) as f32,
            // Within 2³⁰ counts.
            travel: (given.travel * units.position() + ROUNDING) as u32,
            started_at: 0,
            speed: SpeedWatch {
                while_long,
                left: while_long,
                // A cast saturates.
                most: ((counts_in_a_while + ROUNDING) as u32).min(MOST),
                from: 0,
            },
            stall: StallWatch {
                change: stalls_at as f32,
                most: samples(given.stall_time, units),
                stalled: 0,
                from: 0,
                at_rest: 0.0,
            },
            lines: LineWatch::new(units),
            late_most: u32::from(given.overruns),
            late: 0,
        })
    }

    /// From where the servo stands.
    pub(crate) fn start(&mut self, count: i32) {
        self.started_at = count;
        self.speed.from = count;
        self.stall.from = count;
    }

    /// From where the servo was held by something else.
    pub(crate) fn go_on(&mut self, held: &Held) {
        self.start(held.count);
        self.started_at = held.started_at;
        self.stall.at_rest = held.last.command;
    }

    /// Looks at the lines, before the servo is moved.
    #[inline]
    pub(crate) fn check_lines(&mut self, lines: Lines) -> Result<(), Fault> {
        self.lines.check(lines)
    }

    /// Looks at a sample that ended at a count.
    #[inline]
    pub(crate) fn check(&mut self, sample: &ControlSample<f32>, count: i32) -> Result<(), Fault> {
        if sample.error.abs() > self.following_error {
            return Err(Fault::FollowingError);
        }
        let gone = count.wrapping_sub(self.started_at);
        if !is_within(gone, self.travel) {
            return Err(Fault::TravelExceeded);
        }
        self.speed.check(count)?;
        self.stall.check(sample, count)
    }

    /// Takes in that a sample ended in time.
    #[inline]
    pub(crate) fn ended_in_time(&mut self) {
        self.late = 0;
    }

    /// Takes in that a sample ended too late.
    #[cold]
    pub(crate) fn ended_late(&mut self) -> Result<(), Fault> {
        self.late = self.late.saturating_add(1);
        if self.late >= self.late_most {
            Err(Fault::Overrun)
        } else {
            Ok(())
        }
    }
}

impl SpeedWatch {
    #[inline]
    fn check(&mut self, count: i32) -> Result<(), Fault> {
        if !is_within(count.wrapping_sub(self.from), self.most) {
            return Err(Fault::Overspeed);
        }
        self.left -= 1;
        if self.left == 0 {
            self.left = self.while_long;
            self.from = count;
        }
        Ok(())
    }
}

impl StallWatch {
    #[inline]
    fn check(&mut self, sample: &ControlSample<f32>, count: i32) -> Result<(), Fault> {
        if !is_within(count.wrapping_sub(self.from), FLICKER) {
            self.stalled = 0;
            self.from = count;
            self.at_rest = sample.command;
        } else if (sample.command - self.at_rest).abs() >= self.change {
            self.stalled = self.stalled.saturating_add(1);
        }
        if self.stalled > self.most {
            Err(Fault::EncoderSilent)
        } else {
            Ok(())
        }
    }
}

/// Whether a distance is within so many counts either way: at most 2³¹ − 1.
#[inline]
fn is_within(counts: i32, most: u32) -> bool {
    counts.cast_unsigned().wrapping_add(most) <= most + most
}
