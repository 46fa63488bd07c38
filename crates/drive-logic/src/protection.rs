//! The supervision that disables a driven servo.

use commissioning::watch::LateSamples;
use drive_link::{Dither, Ended, Fault, NotAllowed, Settings, Why};
use identifier_core::control::ControlSample;
use identifier_core::error::Allowed;
use identifier_core::number::Number;
use identifier_core::settings::ControllerSettings;
use identifier_core::units::Units;

use crate::chip::Lines;
use crate::closed_loop::Handover;
use crate::limits::{AMPLITUDES_OF_TRAVEL, AllowedRange};
use crate::reference::MAX_DISTANCE_COUNTS;
use crate::time::samples;

/// Amplitudes of the dither for which the largest position error must leave room. They are a step of two, and the
/// overshoot that the step before may have left.
const AMPLITUDES_OF_ERROR: f64 = 3.0;

/// Part of the command that the dither requests and that must move the servo. Otherwise there is nothing to identify
/// from, or no encoder.
const SHARE_OF_DITHER: f64 = 0.9;

/// Counts within which a servo has not moved: one line of an encoder that is broken still flickers.
pub(crate) const FLICKER_COUNTS: u32 = 4;

/// The time by which a servo may be ahead of its largest speed, s.
const SPEED_TIME: f64 = 5e-3;

/// Counts by which a distance is uncertain: each of its ends by one.
const QUANTISATION_COUNTS: f64 = 2.0;

/// Part by which a product of decimal fractions may be off.
const ROUNDING_OF_DECIMALS: f64 = 1e-9;

/// The time for which a limit switch must be open, s: contacts bounce, and lines catch disturbances.
const DEBOUNCE: f64 = 2e-3;

/// The watch over one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Protection {
    following_error: f32,
    /// The lower end of the travel, counts from the origin, its count, and the distance of the upper end from there, counts.
    lowest: i32,
    lowest_count: i32,
    width: u32,
    speed: SpeedWatch,
    stall: StallWatch,
    lines: LineWatch,
    max_late: u32,
    late: LateSamples,
}

/// The watch over the speed: the distance from a follower that is no faster than allowed. It shows the speed of an encoder
/// of any resolution, of a coarse one later. The follower moves at the end of each interval.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SpeedWatch {
    /// Samples of the interval, and those that are left of it.
    interval: u32,
    left: u32,
    /// The way of the follower in one at most, counts, and that of the servo beyond it, which is two counts more.
    way: f32,
    max_counts: u32,
    /// The place of the follower: whole counts, and the rest.
    from: i32,
    rest: f32,
}

/// The stall supervision. The servo must move when the command has changed by this much since its last motion. A
/// command that holds a load at rest is not such a one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StallWatch {
    change: f32,
    max_samples: u32,
    /// Samples since the last motion in which the servo was driven; count and command at which it came to
    /// rest.
    stalled: u32,
    from: i32,
    at_rest: f32,
    /// The direction of the last motion; 0 before the first.
    moved: f32,
}

/// The longest link timeout, s: about the longest that a heartbeat of CANopen may be apart (16 bits of ms, CiA 301).
const MAX_LINK_TIMEOUT: f64 = 60.0;

/// The largest position error, rad, speed, rad/s, and time, s, that the samples compute with.
pub(crate) fn largest(units: &Units) -> [f64; 3] {
    /// Counts in a sample that an encoder's counter of 16 bits distinguishes from those of the other direction.
    const COUNTS_IN_A_SAMPLE: f64 = i16::MAX as f64;
    [
        f64::from(f32::REACH) * units.position_unit(),
        COUNTS_IN_A_SAMPLE / units.velocity(),
        f64::from(u32::MAX) * units.sample_time(),
    ]
}

impl Protection {
    /// The protection of a run with this controller.
    ///
    /// # Errors
    /// The setting that is not allowed, or that contradicts another.
    pub(crate) fn new(
        settings: &Settings,
        controller: &ControllerSettings,
        units: &Units,
    ) -> Result<Self, NotAllowed> {
        let given = &settings.protection;
        let [farthest, fastest, longest] = largest(units);
        let travel = AllowedRange::new(given.travel);
        if !(travel.contains(0.0) && travel.width() > 0.0) {
            let given = given.travel;
            return Err(NotAllowed::new("travel", Why::WithoutStart { given }));
        }
        let most = MAX_DISTANCE_COUNTS * units.position_unit();
        for end in travel.ends() {
            Allowed::Within(-most, most).check("travel", end)?;
        }
        // The reference and the servo are within the travel: a larger error ends nothing.
        let largest_error = farthest.min(travel.width());
        if !(given.following_error > 0.0 && given.following_error <= farthest) {
            Allowed::PositiveUpTo(largest_error).check("following_error", given.following_error)?;
        }
        for (name, value, most) in [
            ("pace", given.pace, fastest),
            ("speed", given.speed, fastest),
            ("breakaway", given.breakaway, 1.0),
            ("stall_time", given.stall_time, longest),
            ("stop_time", given.stop_time, longest),
        ] {
            Allowed::PositiveUpTo(most).check(name, value)?;
        }
        for (name, value, most) in [
            ("duration", given.duration, longest),
            (
                "link_timeout",
                given.link_timeout,
                longest.min(MAX_LINK_TIMEOUT),
            ),
        ] {
            // Zero is none.
            if value != 0.0 {
                Allowed::PositiveUpTo(most).check(name, value)?;
            }
        }
        Allowed::Within(1.0, 255.0).check("overruns", given.overruns.into())?;
        let [low, high] = controller.limit;
        let limit = high.min(-low);
        let breakaway = given.breakaway * limit;
        let Dither { amplitude, .. } = settings.dither;
        let [below, above] = travel.ends().map(f64::abs);
        for (name, value, least, other) in [
            (
                "following_error",
                given.following_error,
                AMPLITUDES_OF_ERROR * amplitude,
                "dither's amplitude",
            ),
            (
                "travel",
                below.min(above),
                AMPLITUDES_OF_TRAVEL * amplitude,
                "dither's amplitude",
            ),
            ("speed", given.speed, given.pace, "pace"),
        ] {
            if value < least * (1.0 - ROUNDING_OF_DECIMALS) {
                return Err(NotAllowed::too_small(name, value, least, other));
            }
        }
        Allowed::PositiveUpTo(largest_error).check("following_error", given.following_error)?;
        let of_dither = SHARE_OF_DITHER * controller.kp * amplitude;
        let stalls_at = if of_dither > 0.0 {
            breakaway.min(of_dither)
        } else {
            breakaway
        };
        let [low, high] = travel.ends().map(|end| end * units.position());
        let lowest = (low - QUANTISATION_COUNTS) as i32;
        Ok(Self {
            following_error: f32::from_f64(given.following_error * units.position()),
            lowest,
            lowest_count: lowest,
            // Both ends are within 2³⁰ counts.
            width: ((high + QUANTISATION_COUNTS) as i32).wrapping_sub(lowest) as u32,
            speed: SpeedWatch::new(given.speed, units),
            stall: StallWatch {
                change: f32::from_f64(stalls_at),
                max_samples: samples(given.stall_time, units),
                stalled: 0,
                from: 0,
                at_rest: 0.0,
                moved: 0.0,
            },
            lines: LineWatch::new(units),
            max_late: u32::from(given.overruns),
            late: LateSamples::default(),
        })
    }

    /// From where another mode, or the load's command, has held the servo; the travel counts from an origin.
    pub(crate) fn start(&mut self, handover: &Handover) {
        self.set_origin(handover.origin);
        self.speed.from = handover.count;
        self.stall.from = handover.count;
        self.stall.at_rest = handover.last.command;
    }

    /// The same for an unknown servo, which has this number of samples for its first motion.
    pub(crate) fn of_unknown(mut self, patience: u32) -> Self {
        self.stall.stalled = self.stall.max_samples.saturating_sub(patience);
        self
    }

    /// The direction in which the servo has moved last; 0 before it has.
    pub(crate) fn moved(&self) -> f32 {
        self.stall.moved
    }

    /// The servo is identified.
    pub(crate) fn end_first_motion(&mut self) {
        self.stall.stalled = 0;
    }

    /// The travel counts from another origin.
    pub(crate) fn set_origin(&mut self, origin: i32) {
        self.lowest_count = origin.wrapping_add(self.lowest);
    }

    /// It has ended, and the axis is held until its brake has closed: a limit switch that ended it stays open.
    pub(crate) fn hold(&mut self, ended: Ended) {
        if ended == Ended::Faulted(Fault::LimitSwitch) {
            self.lines.ignore_switches();
        }
    }

    /// Checks the lines, before the servo is moved.
    #[inline]
    pub(crate) fn check_lines(&mut self, lines: Lines) -> Result<(), Fault> {
        self.lines.check(lines)
    }

    /// Checks a sample that ended at a count.
    #[inline]
    pub(crate) fn check(&mut self, sample: &ControlSample<f32>, count: i32) -> Result<(), Fault> {
        if sample.error.abs() > self.following_error {
            return Err(Fault::FollowingError);
        }
        let above_lowest = count.wrapping_sub(self.lowest_count);
        if above_lowest.cast_unsigned() > self.width {
            return Err(Fault::TravelLeft);
        }
        self.speed.check(count)?;
        self.stall.check(sample, count)
    }

    /// Takes in whether a sample ended too late.
    ///
    /// # Errors
    /// Too many did.
    #[inline]
    pub(crate) fn end_sample(&mut self, late: bool) -> Result<(), Fault> {
        self.late.take(late, self.max_late)
    }
}

/// The watch over the lines while the servo is driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineWatch {
    open: u32,
    max_open: u32,
}

impl LineWatch {
    pub(crate) fn new(units: &Units) -> Self {
        Self {
            open: 0,
            max_open: samples(DEBOUNCE, units),
        }
    }

    /// Has an open limit switch end nothing any longer.
    pub(crate) fn ignore_switches(&mut self) {
        self.max_open = u32::MAX;
    }

    /// Checks the lines of a sample.
    ///
    /// # Errors
    /// The fault for which the servo is disabled.
    #[inline]
    pub(crate) fn check(&mut self, lines: Lines) -> Result<(), Fault> {
        // A sag disables the amplifier too.
        if !lines.supply {
            return Err(Fault::SupplyLow);
        }
        if !lines.amplifier {
            return Err(Fault::AmplifierFault);
        }
        if lines.low_switch && lines.high_switch {
            self.open = 0;
            return Ok(());
        }
        self.open = self.open.saturating_add(1);
        if self.open >= self.max_open {
            Err(Fault::LimitSwitch)
        } else {
            Ok(())
        }
    }
}

impl SpeedWatch {
    /// Of a servo that may have this speed, rad/s.
    fn new(speed: f64, units: &Units) -> Self {
        /// The largest distance of two counts that 32 bits tell apart from the other way round.
        const MAX_DISTANCE: u32 = i32::MAX as u32;
        let interval = samples(SPEED_TIME, units);
        let way = speed * units.velocity() * f64::from(interval);
        Self {
            interval,
            left: interval,
            way: f32::from_f64(way),
            // A cast saturates.
            max_counts: ((way + QUANTISATION_COUNTS) as u32).min(MAX_DISTANCE),
            from: 0,
            rest: 0.0,
        }
    }

    #[inline]
    fn check(&mut self, count: i32) -> Result<(), Fault> {
        let ahead = count.wrapping_sub(self.from);
        if !is_within(ahead, self.max_counts) {
            return Err(Fault::SpeedExceeded);
        }
        self.left -= 1;
        if self.left == 0 {
            self.follow(ahead);
        }
        Ok(())
    }

    /// The follower goes on, at most to where the servo is ahead of its whole counts.
    #[cold]
    #[inline(never)]
    fn follow(&mut self, ahead: i32) {
        self.left = self.interval;
        let way = self.rest + (ahead as f32 - self.rest).limited(-self.way, self.way);
        let whole = way as i32;
        self.from = self.from.wrapping_add(whole);
        self.rest = way - whole as f32;
    }
}

impl StallWatch {
    #[inline]
    fn check(&mut self, sample: &ControlSample<f32>, count: i32) -> Result<(), Fault> {
        let moved = count.wrapping_sub(self.from);
        if !is_within(moved, FLICKER_COUNTS) {
            self.stalled = 0;
            self.moved = moved.signum() as f32;
            self.from = count;
            self.at_rest = sample.command;
        } else if (sample.command - self.at_rest).abs() >= self.change {
            self.stalled = self.stalled.saturating_add(1);
        }
        if self.stalled > self.max_samples {
            Err(Fault::EncoderSilent)
        } else {
            Ok(())
        }
    }
}

/// True if a distance is within a bound either way, counts: at most 2³¹ − 1.
#[inline]
pub(crate) fn is_within(counts: i32, max: u32) -> bool {
    counts.cast_unsigned().wrapping_add(max) <= max + max
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_that_is_stated_is_the_one_that_is_kept_with_any_encoder() {
        const LIMIT: f64 = 20.0;
        for counts in [12.0, 48.0, 400.0, 10_000.0, 1e6] {
            for rate in [250.0, 1e3, 2e4] {
                let units =
                    Units::new(1.0 / rate, core::f64::consts::TAU / counts).expect("allowed");
                // Until it ends at a speed, s and rad.
                let ends = |speed: f64, seconds: f64| {
                    let mut watch = SpeedWatch::new(LIMIT, &units);
                    let count = |k: u32| (f64::from(k) * speed / rate * units.position()) as i32;
                    let samples = 1..(seconds * rate) as u32;
                    let end = samples
                        .into_iter()
                        .find(|&k| watch.check(count(k)).is_err());
                    end.map(|k| f64::from(k) / rate)
                };
                for sign in [1.0, -1.0] {
                    assert_eq!(ends(sign * 0.999 * LIMIT, 100.0), None, "{counts} {rate}");
                    // Two counts and 5 ms ahead of the largest speed.
                    let ahead = 2.0 * core::f64::consts::TAU / counts + 5e-3 * LIMIT;
                    for over in [1.05, 1.5, 10.0] {
                        let most = ahead / ((over - 1.0) * LIMIT) + 2.0 / rate;
                        let after = ends(sign * over * LIMIT, 100.0).expect("it is too fast");
                        // Another count is needed to see it.
                        let seen = core::f64::consts::TAU / counts / (over * LIMIT);
                        assert!(
                            after <= 1.01 * most + seen + 1.0 / rate,
                            "{counts} {rate} {over}: {after} {most}"
                        );
                    }
                }
            }
        }
    }
}
