//! The motions before the slides: fitted, predicted, and searched for what the model lacks.

use super::super::corrected::know_alone;
use super::super::message::{DecisionKind, Identified};
use super::super::{
    CommissionSettings, Diagnosis, EffectSearch, Phase, PredictionErrors, RoughModel,
};
use super::{CommissionSolver, Early, Then, Work};
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::tuning::Resonance;

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// Unexplained position where the model lacks something, counts.
    const UNEXPLAINED: f64 = 1.0;

    /// Unexplained position where the model lacks nothing, counts: twice the encoder's rounding.
    const EXPLAINED: f64 = 0.6;

    /// The least part of the unexplained motion that an effect must explain to be named.
    const NAMED: f64 = 0.8;

    /// Second motions after which there is too little evidence.
    const MAX_REFINEMENTS: u32 = 5;

    /// The same of a servo that has slid before as one mass did not explain its first motion.
    const MAX_REFINEMENTS_AFTER_SLIDES: u32 = 2;

    /// The standard error up to which b is known, a part of itself.
    const KNOWN_GAIN: f64 = 0.02;

    /// A servo that moved by a rough model.
    pub(super) fn roughly(&self, servo: &RoughModel<N>) -> Option<IdentifiedServo> {
        let CommissionSettings {
            sample_time,
            resolution,
            ..
        } = self.settings;
        let mut rough = IdentifiedServo {
            parameters: servo.to_si(sample_time, resolution)?,
            delay: self.settings.command_delay + sample_time,
            covariance: [[0.0; 5]; 5],
            unexplained: 0.0,
        };
        for (place, value) in rough.values().into_iter().enumerate() {
            know_alone(&mut rough, place, value);
        }
        Some(rough)
    }

    /// Takes a servo that was fitted.
    pub(super) fn take_servo(&mut self, servo: IdentifiedServo) -> Option<DecisionKind<N>> {
        self.servo = Some(servo);
        let unexplained = servo.unexplained > Self::UNEXPLAINED * self.settings.resolution;
        if !unexplained {
            self.explained = Some(servo);
        }
        if unexplained && self.is_first_doubt() {
            return self.slide_early(Reason::NotPredicted);
        }
        let then = match self.motion {
            Phase::Refine if !self.is_known(&servo) && unexplained => Then::Predict,
            Phase::Refine if !self.is_known(&servo) => Then::Again,
            _ => Then::Publish,
        };
        self.explain(servo.unexplained, then)
    }

    /// Judges how a motion that nothing was fitted to was predicted.
    pub(super) fn judge(&mut self, prediction: &PredictionErrors) -> Option<DecisionKind<N>> {
        if prediction.refutes()
            && !self.is_refitted
            && let Some(servo) = self.explained
        {
            self.refit(servo);
            return None;
        }
        let then = match self.motion {
            _ if prediction.refutes() => Then::Slide(Some(Reason::NotPredicted)),
            Phase::Refine => Then::Again,
            _ => Then::Slide(None),
        };
        self.explain(prediction.rms, then)
    }

    /// Fits the motion that was not predicted, to find out if load and friction alone have changed, once.
    fn refit(&mut self, mut servo: IdentifiedServo) {
        self.is_refitted = true;
        let most = servo.parameters.b * self.settings.limits.command[1];
        for place in [IdentifiedServo::COULOMB, IdentifiedServo::LOAD] {
            know_alone(&mut servo, place, most);
        }
        self.work = Work::Refitting(self.fitter.begin(&self.record, Some(&servo)));
    }

    /// Takes the servo of such a fit, if it explains the motion. Otherwise the misfit of the prediction is judged.
    pub(super) fn take_refit(
        &mut self,
        refitted: Result<IdentifiedServo, Reason>,
    ) -> Option<DecisionKind<N>> {
        let is_explained = |servo: &IdentifiedServo| {
            servo.unexplained < Self::EXPLAINED * self.settings.resolution
        };
        match refitted {
            Ok(servo) if is_explained(&servo) => self.take_servo(servo),
            Ok(_) => self.proceed(Then::Predict),
            Err(_) => self.proceed(Then::Slide(Some(Reason::NotPredicted))),
        }
    }

    /// Searches the effect that a model lacks, if it was not found before. `left` is the unexplained part of a motion
    /// (rad). A finding from a fit that failed is dropped once a motion is explained.
    fn explain(&mut self, left: f64, then: Then) -> Option<DecisionKind<N>> {
        let counts = left / self.settings.resolution;
        if counts < Self::EXPLAINED && self.suspect.take().is_some() {
            self.work = Work::Then(then);
            return Some(DecisionKind::Suspects(None));
        }
        let begun = self.servo.as_ref().filter(|_| counts > Self::UNEXPLAINED);
        let begun = begun.map(|servo| self.fitter.begin_diagnosis(servo, &self.record));
        self.diagnose(begun, then)
    }

    pub(super) fn diagnose(
        &mut self,
        begun: Option<EffectSearch<N>>,
        then: Then,
    ) -> Option<DecisionKind<N>> {
        match begun.filter(|_| self.suspect.is_none()) {
            Some(begun) => {
                self.work = Work::EffectSearch(begun, then);
                None
            }
            None => {
                self.work = Work::Nothing;
                self.proceed(then)
            }
        }
    }

    /// Suspects what was found if it explains enough.
    pub(super) fn suspect(&mut self, found: Option<Diagnosis>) -> Option<DecisionKind<N>> {
        self.suspect = found.filter(|found| found.share >= Self::NAMED);
        self.suspect
            .map(|found| DecisionKind::Suspects(Some(found.reason)))
    }

    pub(super) fn proceed(&mut self, then: Then) -> Option<DecisionKind<N>> {
        match then {
            Then::Publish => self.publish(DecisionKind::Identified),
            Then::Predict => {
                let servo = self.servo.as_ref()?;
                self.work = Work::Predicting(self.fitter.begin_prediction(servo, &self.record));
                None
            }
            Then::Again => {
                self.refined += 1;
                let most = match self.early {
                    Early::Over { .. } => Self::MAX_REFINEMENTS_AFTER_SLIDES,
                    _ => Self::MAX_REFINEMENTS,
                };
                if self.refined >= most {
                    return self.then(Then::Slide(Some(Reason::TooLittleEvidence)));
                }
                self.publish(DecisionKind::Uncertain)
            }
            Then::Slide(doubt) => match (doubt, self.early) {
                // It has slid. An effect that explains most of the motions themselves is the better name.
                (Some(_), Early::Over { shown: Some(shown) })
                    if self.may_resonate()
                        && (shown.resonance.is_some() || self.suspect.is_some()) =>
                {
                    self.masses = Some(shown);
                    self.fail_by_second_mass()
                }
                (Some(reason), Early::Over { .. }) => self.fail(reason),
                _ => self.survey(doubt),
            },
            Then::MissLines => self.miss_lines(),
            Then::Settle if self.early == Early::UnderWay => self.settle_early(),
            Then::Settle => match self.doubt {
                Some(reason) => self.fail(reason),
                None => self.then(Then::Tune),
            },
            Then::Tune => {
                self.tune(self.settings.goal, self.first_step(), false);
                self.publish(DecisionKind::Verified)
            }
            Then::Prove => self.prove(),
            Then::Fail(reason) => self.fail(reason),
        }
    }

    /// Takes the next step in the next slice.
    pub(super) fn then(&mut self, then: Then) -> Option<DecisionKind<N>> {
        self.work = Work::Then(then);
        None
    }

    fn publish(
        &self,
        answer: impl Fn(Identified<N>) -> DecisionKind<N>,
    ) -> Option<DecisionKind<N>> {
        let mut identified = Identified::new(self.servo.as_ref()?, &self.settings);
        if let Some(Resonance { mode, .. }) = self.designed_resonance() {
            let known = identified.known;
            identified.known = known.map(|known| known.with_load_on_a_spring(mode.ratio));
        }
        Some(answer(identified))
    }

    /// True if no other effect than a second mass explains most of the motions.
    pub(super) fn may_resonate(&self) -> bool {
        let suspect = self.suspect.map(|found| found.reason);
        suspect.is_none_or(|reason| reason == Reason::LacksResonance)
    }

    /// True if two motions determine a servo well enough to tune for it.
    fn is_known(&self, servo: &IdentifiedServo) -> bool {
        servo.standard_error(IdentifiedServo::B) <= Self::KNOWN_GAIN * servo.parameters.b
    }

    pub(super) fn fail(&mut self, reason: Reason) -> Option<DecisionKind<N>> {
        self.work = Work::Nothing;
        Some(DecisionKind::Failed(reason))
    }
}
