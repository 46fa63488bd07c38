//! The masses that the response of the slides shows.

use super::super::Reason;
use super::super::message::DecisionKind;
use super::super::response::ResponseEstimate;
use super::{CommissionSolver, Then, Work};
use crate::number::Number;

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// The ratio by which the gain of the response may differ from that of the motions before. If friction holds a load, the
    /// motor alone answers.
    const MAX_GAIN_RATIO: f64 = 1.6;

    /// Begins to fit masses to the response; without enough lines gains are looked for without.
    pub(super) fn respond(&mut self) -> Work<N> {
        let is_doubted = self.doubt.is_some();
        let servo = self.servo.as_ref();
        let fit = servo.and_then(|servo| self.response.fit(servo, is_doubted));
        fit.map_or(Work::Then(Then::Settle), Work::Responding)
    }

    /// Takes in the masses that the response shows. Two explain what one did not.
    pub(super) fn take_masses(&mut self, masses: ResponseEstimate) -> Option<DecisionKind<N>> {
        self.masses = Some(masses);
        let servo = self.servo.as_mut()?;
        let gain = masses.gain / servo.parameters.b;
        // A gain that is uncertain itself is no measure.
        let most = match self.doubt {
            Some(_) => Self::MAX_GAIN_RATIO * Self::MAX_GAIN_RATIO,
            None => Self::MAX_GAIN_RATIO,
        };
        let is_weaker = self.doubt.is_none() && gain < 1.0 / most;
        if is_weaker || gain > most {
            let is_weak = gain < 1.0 && masses.resonance.is_none();
            return self.fail(match self.doubt {
                Some(reason) => reason,
                None if is_weak => Reason::ActuatorWeak,
                None => Reason::LacksResonance,
            });
        }
        // A load that changes with the angle can look like a second mass in part.
        let unclear = !masses.is_explained() && self.doubt.is_some();
        if masses.resonance.is_none() || unclear {
            return self.proceed(Then::Settle);
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
            // An effect that explains most of the motions themselves is the better name.
            Some(reason) if self.suspect.is_some() => return self.fail(reason),
            Some(_) => return self.fail(Reason::LacksResonance),
        }
        self.work = Work::Then(Then::Tune);
        let is_new = self.suspect.is_none();
        is_new.then_some(DecisionKind::Suspects(Some(Reason::LacksResonance)))
    }
}
