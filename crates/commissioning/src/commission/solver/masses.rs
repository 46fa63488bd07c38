//! The masses that the response of the slides shows.

use super::super::message::DecisionKind;
use super::super::response::ResponseEstimate;
use super::{CommissionSolver, Early, Then, Work};
use identifier_core::number::Number;
use identifier_core::reason::Reason;

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// The ratio by which the gain of the response may differ from that of the motions before. If friction holds a load, the
    /// motor alone answers.
    const MAX_GAIN_RATIO: f64 = 1.6;

    /// Begins to fit masses to the response; without enough lines gains are looked for without.
    pub(super) fn respond(&mut self) -> Work<N> {
        if !self.response.has_lines() {
            return Work::Then(Then::MissLines);
        }
        let is_doubted = self.doubt.is_some();
        let servo = self.servo.as_ref();
        let fit = servo.and_then(|servo| self.response.fit(servo, is_doubted));
        fit.map_or(Work::Then(Then::MissLines), Work::Responding)
    }

    /// Takes in the masses that the response shows. Two explain what one did not.
    pub(super) fn take_masses(&mut self, shown: ResponseEstimate) -> Option<DecisionKind<N>> {
        if let Some(louder) = self.louder {
            return self.compare(&louder, &shown);
        }
        let before = self.masses.replace(shown);
        let gain = shown.gain / self.servo.as_ref()?.parameters.b;
        let most = Self::MAX_GAIN_RATIO;
        // A gain that is uncertain itself is no measure.
        if self.doubt.is_none() && !(1.0 / most..=most).contains(&gain) {
            let is_weak = gain < 1.0 && shown.resonance.is_none();
            return if is_weak {
                self.fail(Reason::ActuatorWeak)
            } else {
                self.fail_by_second_mass()
            };
        }
        if self.is_to_slide_again(&shown) {
            return self.slide_again();
        }
        // The last slides may have shown less than those before.
        let before = before.filter(|before| self.doubt.is_some() && before.shows_more_than(&shown));
        let masses = *self.masses.insert(before.unwrap_or(shown));
        let servo = self.servo.as_mut()?;
        // A load that changes with the angle can look like a second mass in part.
        let unclear = !masses.is_explained() && self.doubt.is_some();
        if masses.resonance.is_none() || unclear {
            return self.then(Then::Settle);
        }
        match self.doubt {
            _ if masses.is_known() => {
                masses.improve(servo);
                let balance = self.response.friction(&servo.parameters);
                if let Some([coulomb, load]) = balance.filter(|_| self.doubt.is_some()) {
                    (servo.parameters.coulomb, servo.parameters.load) = (coulomb, load);
                }
            }
            // The motions know the servo better.
            None => {}
            Some(_) if self.early == Early::UnderWay => return self.settle_early(),
            // An effect that explains most of the motions themselves is the better name.
            Some(reason) if !self.may_resonate() => return self.fail(reason),
            Some(_) => return self.fail_by_second_mass(),
        }
        self.work = Work::Then(Then::Tune);
        let is_new = self.suspect.is_none();
        is_new.then_some(DecisionKind::Suspects(Some(Reason::LacksResonance)))
    }
}
