//! The reference of a run: towards a target at a bounded speed, with dither on top.

use drive_link::Settings;
use identifier_core::control::Setpoint;
use identifier_core::error::OutOfRange;
use identifier_core::excitation::{Excitation, Prbs};
use identifier_core::number::Number;
use identifier_core::units::Units;

/// Order of the pseudo-random sequence: 511 decisions, longer than any time constant it meets.
const ORDER: u32 = 9;

/// The largest distance of a target from the start, counts: no two targets are further apart than 32 bits hold.
pub(crate) const MAX_DISTANCE_COUNTS: f64 = (1_u32 << 30) as f64;

/// The dither with its progress.
pub(crate) type Dither = (Prbs<f32>, <Prbs<f32> as Excitation<f32>>::State);

/// The reference with its progress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reference {
    dither: Option<Dither>,
    /// Counts per sample: on the way to a target of the host, and now.
    usual_pace: f32,
    pace: f32,
    target: i32,
    /// The way to the target: whole counts, and less than one count on top.
    at: Setpoint<f32>,
    arrived: bool,
    progress: Progress,
}

/// Whether the reference follows its target.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Progress {
    /// It does.
    Follows,
    /// It will, with this dither.
    Waits(Option<Dither>),
    /// It stays where it is, in spite of new targets.
    Stays,
}

impl Reference {
    pub(crate) fn new(settings: &Settings, units: &Units) -> Result<Self, OutOfRange> {
        let dither = if settings.dither.amplitude == 0.0 {
            None
        } else {
            let prbs = Prbs::new(
                units,
                settings.dither.amplitude,
                settings.dither.hold,
                ORDER,
            )?;
            Some((prbs, Excitation::<f32>::start(&prbs)))
        };
        let pace = f32::from_f64(settings.protection.pace * units.velocity());
        Ok(Self {
            dither,
            usual_pace: pace,
            pace,
            target: 0,
            at: Setpoint {
                count: 0,
                offset: 0.0,
            },
            arrived: true,
            progress: Progress::Follows,
        })
    }

    /// Stays at the servo's position, or the offset from it by which a loop without integral holds the load.
    pub(crate) fn start(&mut self, count: i32, offset: f32) {
        let whole = offset as i32;
        self.target = count.wrapping_add(whole);
        self.at = Setpoint {
            count: self.target,
            offset: offset - whole as f32,
        };
        self.arrived = true;
    }

    /// The same without an offset, after it has waited: it may have been sent elsewhere meanwhile.
    pub(crate) fn rest_at(&mut self, count: i32) {
        let sent = Some(self.target).filter(|target| *target != self.at.count);
        self.start(count, 0.0);
        self.target = sent.unwrap_or(count);
    }

    /// Resumes towards a target from a setpoint, an offset from a count.
    pub(crate) fn resume_to(&mut self, target: i32, count: i32, offset: f32) {
        self.at = Setpoint { count, offset };
        self.send(target);
    }

    /// Sends the servo elsewhere.
    pub(crate) fn send(&mut self, target: i32) {
        if !self.stays() {
            self.target = target;
            self.arrived &= self.waits();
        }
    }

    /// Sends the servo elsewhere at another pace, counts per sample, until [`resume_pace`](Self::resume_pace).
    pub(crate) fn send_at(&mut self, target: i32, pace: f32) {
        self.pace = pace;
        self.send(target);
    }

    /// Goes at the usual pace again.
    pub(crate) fn resume_pace(&mut self) {
        self.pace = self.usual_pace;
    }

    /// Takes the dither away.
    pub(crate) fn take_dither(&mut self) -> Option<Dither> {
        self.dither.take()
    }

    /// Dithers again.
    pub(crate) fn resume_dither(&mut self, dither: Option<Dither>) {
        self.dither = dither;
    }

    /// The target.
    pub(crate) fn target(&self) -> i32 {
        self.target
    }

    /// Whole counts to the target.
    pub(crate) fn distance(&self) -> i32 {
        self.target.wrapping_sub(self.at.count)
    }

    /// True if it is at its target.
    pub(crate) fn has_arrived(&self) -> bool {
        self.arrived
    }

    /// True if it stays where it is, in spite of new targets.
    pub(crate) fn stays(&self) -> bool {
        self.progress == Progress::Stays
    }

    /// True if it waits where it is, in spite of its target.
    pub(crate) fn waits(&self) -> bool {
        matches!(self.progress, Progress::Waits(_))
    }

    /// Waits where it is, without dither, until [`go`](Self::go).
    pub(crate) fn wait(&mut self) {
        self.progress = Progress::Waits(self.dither.take());
    }

    /// Follows its target after it has waited.
    pub(crate) fn go(&mut self) {
        if let Progress::Waits(dither) = self.progress {
            (self.dither, self.progress) = (dither, Progress::Follows);
            self.arrived = self.target == self.at.count;
        }
    }

    /// Stays where it is from now on, without dither.
    #[cold]
    #[inline(never)]
    pub(crate) fn stay(&mut self) {
        self.dither = None;
        self.send(self.at.count);
        self.progress = Progress::Stays;
    }

    /// The setpoint of this sample.
    #[inline]
    pub(crate) fn next(&mut self) -> Setpoint<f32> {
        if !self.arrived {
            self.advance();
        }
        let dither = match &mut self.dither {
            Some((prbs, state)) => prbs.process(state),
            None => 0.0,
        };
        Setpoint {
            count: self.at.count,
            offset: self.at.offset + dither,
        }
    }

    /// A sample's way towards the target.
    #[inline(never)]
    fn advance(&mut self) {
        let at = &mut self.at;
        let left = Setpoint {
            count: self.target,
            offset: -at.offset,
        }
        .error(at.count);
        at.offset += left.limited(-self.pace, self.pace);
        // Whole counts are carried over, so that a long way costs no digits.
        let whole = at.offset as i32;
        at.count = at.count.wrapping_add(whole);
        at.offset -= whole as f32;
        self.arrived = at.count == self.target && at.offset == 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::{Progress, Reference, Setpoint};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_target_is_reached_at_the_pace_and_kept(
            start: i32,
            away in -3_000_000_i32..3_000_000,
            pace in 0.01_f32..5000.0,
        ) {
            let mut reference = Reference {
                dither: None,
                usual_pace: pace,
                pace,
                target: 0,
                at: Setpoint { count: 0, offset: 0.0 },
                arrived: true,
                progress: Progress::Follows,
            };
            reference.start(start, 0.0);
            let target = start.wrapping_add(away);
            reference.send(target);
            let needed = f64::from(away.abs()) / f64::from(pace);
            prop_assume!(needed < 1e5);
            // Roundings of the pace itself are all that the way may differ by.
            let early = (0.999 * needed) as u32;
            for k in 0..(1.001 * needed) as u32 + 3 {
                let before = reference.at;
                let now = reference.next();
                let step = Setpoint { count: now.count, offset: now.offset - before.offset }.error(before.count);
                prop_assert!(step.abs() <= pace * 1.001 + 1e-6, "{step}");
                if k + 2 < early {
                    prop_assert!(now.count != target || now.offset != 0.0);
                }
            }
            prop_assert_eq!(reference.next(), Setpoint { count: target, offset: 0.0 });
        }
    }
}
