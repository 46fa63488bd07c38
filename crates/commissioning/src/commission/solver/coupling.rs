//! The name of a coupling for which no gains are found. A resonance is the same in small motions; with backlash it is
//! softer.

use super::super::Phase;
use super::super::message::DecisionKind;
use super::super::response::ResponseEstimate;
use super::super::sliding::{Lines, SlidePlan};
use super::{CommissionSolver, Work};
use identifier_core::number::Number;
use identifier_core::reason::Reason;

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// The part of the usual velocities of the lines in slides that compare.
    const QUIETER: f64 = 0.3;

    /// The standard errors by which a resonance is lower in small motions. Also the ratio by which the gain is larger
    /// if the motor no longer reaches its load.
    const LOWER: f64 = 3.0;
    const ALONE: f64 = 1.3;

    /// Fails because of a second mass, once slides with smaller lines have shown whether its coupling has backlash.
    pub(super) fn fail_by_second_mass(&mut self) -> Option<DecisionKind<N>> {
        let (Some(masses), None, Some(servo)) = (self.masses, &self.louder, &self.servo) else {
            return self.fail(Reason::LacksResonance);
        };
        let lines = Lines::survey(self.settings.sample_time);
        let mode = masses.resonance.map(|resonance| resonance.mode);
        let plan = SlidePlan::new(&self.settings, servo, true, mode.as_ref(), &lines);
        let Some(plan) = plan else {
            return self.fail(Reason::LacksResonance);
        };
        // The fit that has led here has no more lines.
        self.work = Work::Nothing;
        self.louder = Some(masses);
        self.tried = None;
        self.response.begin(&lines);
        self.motion = Phase::Slide;
        Some(DecisionKind::Slide(plan.quieter(Self::QUIETER)))
    }

    /// The reason by what smaller lines have shown.
    pub(super) fn compare(
        &mut self,
        louder: &ResponseEstimate,
        quieter: &ResponseEstimate,
    ) -> Option<DecisionKind<N>> {
        let is_lower = match (&louder.resonance, &quieter.resonance) {
            (Some(louder), Some(quieter)) => {
                let lower = libm::log(louder.mode.frequency / quieter.mode.frequency);
                lower > Self::LOWER * libm::hypot(louder.errors[0], quieter.errors[0])
            }
            _ => false,
        };
        // Where no size shows a second mass, only motions over all of the travel took the load along.
        let servo = self.servo.filter(|_| louder.resonance.is_none());
        let together = servo.map_or(louder.gain, |servo| louder.gain.min(servo.parameters.b));
        let alone = libm::log(quieter.gain / together);
        // Lines that one mass does not explain are not those of the motor alone.
        let is_alone = quieter.is_one_mass()
            && alone > libm::log(Self::ALONE).max(Self::LOWER * quieter.gain_error);
        self.fail(if is_lower || is_alone {
            Reason::LacksBacklash
        } else {
            Reason::LacksResonance
        })
    }
}
