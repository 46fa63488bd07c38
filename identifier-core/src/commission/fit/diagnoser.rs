use super::super::IdentifiedServo;
use super::effect_search::{Diagnosis, EffectSearch};
use super::motion::MotionRecord;
use super::servo_fit::ServoFit;
use super::servo_fitter::ServoFitter;
use super::{B, UNKNOWNS};
use crate::number::Number;

impl<N: Number> ServoFitter<N> {
    /// Begins to look for what the model of a servo lacks of a motion.
    #[must_use]
    pub fn begin_diagnosis<const W: usize>(
        &self,
        servo: &IdentifiedServo,
        motion: &MotionRecord<N, W>,
    ) -> EffectSearch<N> {
        self.diagnosing(&self.unknowns(servo), motion)
    }

    /// The same where a fit has not come to a servo; none where it had nothing to begin with.
    #[must_use]
    pub fn begin_diagnosis_of<const W: usize>(
        &self,
        fit: &ServoFit<N>,
        motion: &MotionRecord<N, W>,
    ) -> Option<EffectSearch<N>> {
        // Where the fit went to may be far away.
        let first = fit.first();
        (first[B] > N::ZERO).then(|| self.diagnosing(first, motion))
    }

    /// Continues by a piece of the record, or by the work between two passes. Returns once it has ended,
    /// with nothing if no effect explains anything.
    pub fn diagnose<const W: usize>(
        &self,
        diagnosing: &mut EffectSearch<N>,
        motion: &MotionRecord<N, W>,
    ) -> Option<Option<Diagnosis>> {
        diagnosing.goes_on(&self.step, motion)
    }

    fn diagnosing<const W: usize>(
        &self,
        own: &[N; UNKNOWNS],
        motion: &MotionRecord<N, W>,
    ) -> EffectSearch<N> {
        let bounds = self.bounds(motion, self.speed_at_first(motion, true));
        EffectSearch::new(own, &bounds, self.resolution(), motion)
    }
}
