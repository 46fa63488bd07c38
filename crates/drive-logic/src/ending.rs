//! The end of a run without a fault of the servo: its time is over, or the host is silent. The servo comes to rest under
//! control, and is disabled only then.

use drive_link::{Ended, Fault, Protection};
use identifier_core::units::Units;

use crate::protection::FLICKER_COUNTS;
use crate::time::samples;

/// Counts by which a displacement is uncertain: each of its ends by one.
const QUANTISATION_COUNTS: u32 = 2;
/// The time for which a servo that is at rest has not moved, s.
pub(crate) const REST_TIME: f64 = 0.02;

/// A place at which a servo is at standstill: the count, and the samples for which it has been there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Standstill {
    at: i32,
    samples: u32,
}

impl Standstill {
    /// The samples of standstill, after one at a count.
    pub(crate) fn take(&mut self, count: i32) -> u32 {
        if count.wrapping_sub(self.at).unsigned_abs() > FLICKER_COUNTS {
            (self.at, self.samples) = (count, 0);
        } else {
            self.samples = self.samples.saturating_add(1);
        }
        self.samples
    }
}

/// The motion of a disabled axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Coasting {
    short: Displacement,
    long: Displacement,
    /// A long window is over.
    is_long_over: bool,
}

/// The displacement in a window of samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Displacement {
    /// The count at which it began, if it has, and the samples that are left of it.
    from: Option<i32>,
    left: u32,
    /// That of the window before, counts.
    before: u32,
}

impl Displacement {
    /// A sample later; true if the window is over.
    fn take(&mut self, count: i32, window: u32) -> bool {
        let from = self.from.unwrap_or(count);
        if self.from.is_none() {
            (self.from, self.left) = (Some(count), window);
            return false;
        }
        self.left = self.left.saturating_sub(1);
        let is_over = self.left == 0;
        if is_over {
            self.before = count.wrapping_sub(from).unsigned_abs();
            (self.from, self.left) = (Some(count), window);
        }
        is_over
    }
}

impl Coasting {
    /// The shortest long window, s.
    const LONG_TIME: f64 = 0.02;
    /// Short windows of a long one, as a power of two.
    const LONG: u32 = 4;
    /// Counts at the largest speed in a long window at least: that speed is seen to a fifth.
    const RESOLVED_COUNTS: f64 = 10.0;

    /// Samples of a long window that shows a speed, counts per sample, at a sample time, s.
    pub(crate) fn window(speed: f64, sample_time: f64) -> u32 {
        let samples = (Self::LONG_TIME / sample_time).max(Self::RESOLVED_COUNTS / speed);
        // A cast saturates.
        ((samples as u32) >> Self::LONG).max(1) << Self::LONG
    }

    /// From the count of the last sample before it was disabled.
    pub(crate) fn begin(count: i32, window: u32) -> Self {
        let mut coasting = Self::default();
        coasting.take(count, window);
        coasting
    }

    /// A sample later: the counts that the axis coasts in a long window. The lesser of what a long and a short window
    /// show: an axis that has just been put elsewhere moves no longer, and a coarse encoder shows nothing in a short one.
    pub(crate) fn take(&mut self, count: i32, window: u32) -> u32 {
        self.short.take(count, window >> Self::LONG);
        self.is_long_over |= self.long.take(count, window);
        let in_short = |counts: u32| counts.saturating_mul(1 << Self::LONG);
        let short = self.short.before;
        if self.is_long_over {
            let most = in_short(short.saturating_add(QUANTISATION_COUNTS));
            let least = self.long.before.saturating_sub(QUANTISATION_COUNTS);
            least.min(most)
        } else {
            in_short(short.saturating_sub(QUANTISATION_COUNTS))
        }
    }
}

/// A servo that comes to rest, or does not within its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rest {
    max_samples: u32,
    needed: u32,
    standstill: Standstill,
    /// The samples that are left.
    left: u32,
}

impl Rest {
    /// Within this time, s.
    pub(crate) fn within(time: f64, units: &Units) -> Self {
        let max_samples = samples(time, units);
        Self {
            max_samples,
            needed: samples(REST_TIME, units),
            standstill: Standstill::default(),
            left: max_samples,
        }
    }

    /// From a count on.
    pub(crate) fn begin(&mut self, count: i32) {
        self.standstill = Standstill {
            at: count,
            samples: 0,
        };
        self.left = self.max_samples;
    }

    /// True if it is at rest after a sample at a count, or its time is over.
    pub(crate) fn is_over(&mut self, count: i32) -> bool {
        self.left = self.left.saturating_sub(1);
        self.standstill.take(count) >= self.needed || self.left == 0
    }
}

/// The time that a run or a commissioning has, and a host may be silent.
///
/// One count runs down in every sample, to the earlier of the two. Computation follows only at its end, or after a
/// received frame of the host.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Deadline {
    /// Samples to the next evaluation, and those that were left at the last.
    left: u32,
    begun_with: u32,
    /// Samples that the run had left at the last evaluation, if its time is bounded.
    run_left: Option<u32>,
    /// Samples for which the host may be silent, if that is bounded. The other is its silence at the last evaluation.
    max_silence: Option<u32>,
    silence: u32,
}

impl Deadline {
    /// None that a held axis lives to see.
    pub(crate) const NEVER: Self = Self {
        left: u32::MAX,
        begun_with: u32::MAX,
        run_left: None,
        max_silence: None,
        silence: 0,
    };

    /// For a time and a silence of the host, s; 0 for unbounded.
    pub(crate) fn new(duration: f64, link_timeout: f64, units: &Units) -> Self {
        let bound = |time: f64| (time > 0.0).then(|| samples(time, units));
        let mut deadline = Self {
            left: 1,
            begun_with: 1,
            run_left: bound(duration),
            max_silence: bound(link_timeout),
            silence: 0,
        };
        deadline.count_down();
        deadline
    }

    /// A frame of the host was received.
    pub(crate) fn link_alive(&mut self) {
        self.evaluate();
        self.silence = 0;
        self.count_down();
    }

    /// Takes in the samples since the last evaluation.
    fn evaluate(&mut self) {
        let passed = self.begun_with - self.left;
        self.silence = self.silence.saturating_add(passed);
        self.run_left = self.run_left.map(|left| left.saturating_sub(passed));
        self.begun_with = self.left;
    }

    /// Counts down to the next deadline.
    fn count_down(&mut self) {
        let until_timeout = self.max_silence.map(|max| max.saturating_sub(self.silence));
        let next = until_timeout.into_iter().chain(self.run_left).min();
        self.left = next.unwrap_or(u32::MAX).max(1);
        self.begun_with = self.left;
    }

    /// A sample later: whether it may have passed.
    #[inline]
    fn is_due(&mut self) -> bool {
        self.left -= 1;
        self.left == 0
    }

    /// The end of the run by a deadline that has passed, if any.
    fn passed(&mut self) -> Option<Ended> {
        self.evaluate();
        let passed = if self.run_left == Some(0) {
            Some(Ended::Over)
        } else if self.max_silence.is_some_and(|max| self.silence >= max) {
            Some(Ended::Faulted(Fault::LinkLost))
        } else {
            None
        };
        // Once it has passed, the next sample evaluates again.
        self.count_down();
        passed
    }

    /// The way in which it has passed, a sample later.
    #[inline]
    pub(crate) fn check(&mut self) -> Option<Ended> {
        if self.is_due() { self.passed() } else { None }
    }
}

/// The watch over the end of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ending {
    deadline: Deadline,
    /// The way in which it ends, while the servo comes to rest.
    resting: Option<Ended>,
    rest: Rest,
}

/// The meaning of a sample for the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Course {
    /// It continues.
    Continues,
    /// The reference is to stand from now on.
    Rests,
    /// It has ended.
    Ended(Ended),
}

impl Ending {
    pub(crate) fn new(given: &Protection, units: &Units) -> Self {
        Self {
            deadline: Deadline::new(given.duration, given.link_timeout, units),
            resting: None,
            rest: Rest::within(given.stop_time, units),
        }
    }

    /// A frame of the host was received.
    pub(crate) fn link_alive(&mut self) {
        if self.resting.is_none() {
            self.deadline.link_alive();
        }
    }

    /// It has ended, and the axis is held until its brake has closed.
    pub(crate) fn hold(&mut self) {
        self.deadline = Deadline::NEVER;
    }

    /// Checks a sample that ended at a count.
    #[inline]
    pub(crate) fn check(&mut self, count: i32) -> Course {
        if self.deadline.is_due() {
            self.evaluate(count)
        } else {
            Course::Continues
        }
    }

    #[cold]
    #[inline(never)]
    fn evaluate(&mut self, count: i32) -> Course {
        if let Some(why) = self.resting {
            self.deadline.left = 1;
            return if self.rest.is_over(count) {
                Course::Ended(why)
            } else {
                Course::Continues
            };
        }
        self.resting = self.deadline.passed();
        if self.resting.is_none() {
            return Course::Continues;
        }
        self.rest.begin(count);
        Course::Rests
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ending(duration: f64, link_timeout: f64) -> Ending {
        let given = Protection {
            duration,
            link_timeout,
            stop_time: 0.05,
            ..Protection::OF_A_BARE_MOTOR
        };
        Ending::new(&given, &Units::new(1e-3, 1e-3).expect("allowed"))
    }

    /// Samples until the first answer that is not "continues".
    fn until(ending: &mut Ending, mut count: impl FnMut(u32) -> i32) -> (u32, Course) {
        (1..100_000)
            .map(|k| (k, ending.check(count(k))))
            .find(|(_, course)| *course != Course::Continues)
            .expect("it ends")
    }

    #[test]
    fn an_axis_that_was_put_elsewhere_coasts_no_longer_once_it_stands() {
        let window = Coasting::window(0.1, 1e-3);
        let mut coasting = Coasting::begin(0, window);
        let coasted = |coasting: &mut Coasting, count: i32, samples: u32| {
            (0..samples).map(|_| coasting.take(count, window)).last()
        };
        assert_eq!(coasted(&mut coasting, 0, 2 * window), Some(0));
        let moving = (1..2 * window).map(|k| coasting.take(40 * k as i32, window));
        assert!(moving.last() > Some(10 * window));
        let stands = coasted(&mut coasting, 80 * window as i32, window / 4);
        assert!(
            stands <= Some(QUANTISATION_COUNTS << Coasting::LONG),
            "{stands:?}"
        );
    }

    #[test]
    fn a_run_ends_when_its_time_is_over_and_the_servo_rests() {
        let mut ending = ending(2.0, 0.0);
        assert_eq!(until(&mut ending, |k| k as i32), (2000, Course::Rests));
        // It stands at once: 20 samples show that.
        let end = until(&mut ending, |_| 2000);
        assert_eq!(end, (20, Course::Ended(Ended::Over)));
    }

    #[test]
    fn a_host_that_comes_back_while_the_servo_comes_to_rest_does_not_keep_it() {
        let mut ending = ending(0.0, 0.3);
        assert_eq!(until(&mut ending, |_| 0), (300, Course::Rests));
        ending.link_alive();
        let lost = Ended::Faulted(Fault::LinkLost);
        assert_eq!(until(&mut ending, |_| 0), (20, Course::Ended(lost)));
    }

    #[test]
    fn the_earlier_of_both_ends_a_run_whose_time_and_silence_are_bounded() {
        let mut silent = ending(10.0, 0.3);
        assert_eq!(until(&mut silent, |_| 0), (300, Course::Rests));
        let lost = Ended::Faulted(Fault::LinkLost);
        assert_eq!(until(&mut silent, |_| 0), (20, Course::Ended(lost)));
        let mut over = ending(0.2, 0.3);
        assert_eq!(until(&mut over, |_| 0), (200, Course::Rests));
        assert_eq!(until(&mut over, |_| 0), (20, Course::Ended(Ended::Over)));
        // And while the host talks, its silence begins anew and the time does not.
        let mut talking = ending(0.5, 0.3);
        for k in 1..500 {
            if k % 100 == 0 {
                talking.link_alive();
            }
            assert_eq!(talking.check(0), Course::Continues, "{k}");
        }
        assert_eq!(talking.check(0), Course::Rests);
    }

    #[test]
    fn a_servo_that_does_not_come_to_rest_is_disabled_after_the_stop_time() {
        let mut ending = ending(0.0, 0.3);
        assert_eq!(until(&mut ending, |k| 9 * k as i32), (300, Course::Rests));
        let end = until(&mut ending, |k| 9 * k as i32);
        let silent = Ended::Faulted(Fault::LinkLost);
        assert_eq!(end, (50, Course::Ended(silent)));
    }

    #[test]
    fn a_line_of_the_encoder_that_flickers_is_rest_and_a_motion_beyond_is_none() {
        let units = Units::new(1e-3, 1e-3).expect("allowed");
        for (moved, wanted) in [(FLICKER_COUNTS, 20), (FLICKER_COUNTS + 1, 50)] {
            let mut rest = Rest::within(0.05, &units);
            rest.begin(0);
            let over = (1..).find(|k| rest.is_over((k % 2 * moved).cast_signed()));
            assert_eq!(over, Some(wanted), "{moved} counts");
        }
    }

    #[test]
    fn a_run_survives_while_the_host_talks_and_a_timeout_of_zero_disables_the_watch() {
        let mut bounded = ending(0.0, 0.3);
        for k in 0..10_000 {
            if k % 299 == 0 {
                bounded.link_alive();
            }
            assert_eq!(bounded.check(0), Course::Continues);
        }
        let mut free = ending(0.0, 0.0);
        for _ in 0..1_000_000 {
            assert_eq!(free.check(0), Course::Continues);
        }
    }
}
