//! How a run ends when nobody stops it and nothing is wrong with the servo: its time is over, or the
//! host is silent. The servo comes to rest under control, and only then is let go.

use drive_link::{Ended, Fault, Protection};
use identifier_core::units::Units;

use crate::rest::Rest;
use crate::time::samples;

/// The watch over the end of a run.
///
/// One count runs down in every sample, to the next thing that may happen; only when it has run out, or
/// the host was heard, is anything looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ending {
    /// Samples to the next look, and those that it was begun with.
    left: u32,
    begun_with: u32,
    phase: Phase,
    /// Samples that the run has left at the last look, if it has an end.
    run_left: Option<u32>,
    /// Samples for which the host may be silent, if there is such a bound; those that it was at the
    /// last look.
    silent_most: Option<u32>,
    silent: u32,
    rest: Rest,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Driving,
    /// The reference stands.
    ComingToRest(Ended),
}

/// What a sample means for the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Course {
    /// It goes on.
    On,
    /// The reference is to stand from now on.
    Rest,
    /// It has ended.
    Ended(Ended),
}

impl Ending {
    pub(crate) fn new(given: &Protection, units: &Units) -> Self {
        let bound = |time: f64| (time > 0.0).then(|| samples(time, units));
        Self {
            left: 1,
            begun_with: 1,
            phase: Phase::Driving,
            run_left: bound(given.duration),
            silent_most: bound(given.link_timeout),
            silent: 0,
            rest: Rest::within(given.stop_time, units),
        }
    }

    /// From now on.
    pub(crate) fn start(&mut self) {
        self.begin();
    }

    /// The host was heard.
    pub(crate) fn heard(&mut self) {
        if let Phase::Driving = self.phase {
            self.take_in_time();
            self.silent = 0;
            self.begin();
        }
    }

    /// Takes in the samples since it was last looked.
    fn take_in_time(&mut self) {
        let passed = self.begun_with - self.left;
        self.silent = self.silent.saturating_add(passed);
        self.run_left = self.run_left.map(|left| left.saturating_sub(passed));
        self.begun_with = self.left;
    }

    /// Begins to count down to the next thing that may happen.
    fn begin(&mut self) {
        let until_timeout = self
            .silent_most
            .map(|most| most.saturating_sub(self.silent));
        let next = until_timeout.into_iter().chain(self.run_left).min();
        self.left = next.unwrap_or(u32::MAX).max(1);
        self.begun_with = self.left;
    }

    /// Looks at a sample that ended at a count.
    #[inline]
    pub(crate) fn check(&mut self, count: i32) -> Course {
        self.left -= 1;
        if self.left == 0 {
            self.look(count)
        } else {
            Course::On
        }
    }

    #[cold]
    #[inline(never)]
    fn look(&mut self, count: i32) -> Course {
        if let Phase::ComingToRest(why) = self.phase {
            self.left = 1;
            return if self.rest.is_over(count) {
                Course::Ended(why)
            } else {
                Course::On
            };
        }
        self.take_in_time();
        if self.run_left == Some(0) {
            self.begin_rest(Ended::Over, count)
        } else if self.silent_most.is_some_and(|most| self.silent >= most) {
            self.begin_rest(Ended::Faulted(Fault::LinkSilent), count)
        } else {
            self.begin();
            Course::On
        }
    }

    fn begin_rest(&mut self, why: Ended, at: i32) -> Course {
        self.phase = Phase::ComingToRest(why);
        self.rest.begin(at);
        // From now on every sample is looked at.
        self.left = 1;
        Course::Rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ending(duration: f64, link_timeout: f64) -> Ending {
        let given = Protection {
            following_error: 1.0,
            travel: 1.0,
            pace: 1.0,
            speed: 1.0,
            breakaway: 1.0,
            stall_time: 1.0,
            overruns: 1,
            duration,
            link_timeout,
            stop_time: 0.05,
        };
        let units = Units::new(1e-3, 1e-3).expect("allowed");
        let mut ending = Ending::new(&given, &units);
        ending.start();
        ending
    }

    /// Samples until the first answer that is not "on".
    fn until(ending: &mut Ending, mut count: impl FnMut(u32) -> i32) -> (u32, Course) {
        (1..100_000)
            .map(|k| (k, ending.check(count(k))))
            .find(|(_, course)| *course != Course::On)
            .expect("it ends")
    }

    #[test]
    fn a_run_ends_when_its_time_is_over_and_the_servo_stands() {
        let mut ending = ending(2.0, 0.0);
        assert_eq!(until(&mut ending, |k| k as i32), (2000, Course::Rest));
        // It stands at once: 20 samples show that.
        let end = until(&mut ending, |_| 2000);
        assert_eq!(end, (20, Course::Ended(Ended::Over)));
    }

    #[test]
    fn a_servo_that_does_not_come_to_rest_is_let_go_when_the_time_for_that_is_over() {
        let mut ending = ending(0.0, 0.3);
        assert_eq!(until(&mut ending, |k| 9 * k as i32), (300, Course::Rest));
        let end = until(&mut ending, |k| 9 * k as i32);
        let silent = Ended::Faulted(Fault::LinkSilent);
        assert_eq!(end, (50, Course::Ended(silent)));
    }

    #[test]
    fn whoever_is_heard_keeps_the_run_alive_and_without_a_bound_nobody_needs_to_be() {
        let mut bounded = ending(0.0, 0.3);
        for k in 0..10_000 {
            if k % 299 == 0 {
                bounded.heard();
            }
            assert_eq!(bounded.check(0), Course::On);
        }
        let mut free = ending(0.0, 0.0);
        for _ in 0..1_000_000 {
            assert_eq!(free.check(0), Course::On);
        }
    }
}
