use super::message::{Candidate, DecisionKind, EventKind, Identified};
use super::response::{MeasuredResponse, ResponseEstimate, ResponseFit};
use super::sliding::SlidePlan;
use super::{
    CommissionError, CommissionSettings, Decision, Diagnosis, EffectSearch, IdentifiedServo,
    MotionRecord, Phase, PredictionErrors, PredictionRun, Reason, RecordEvent, RoughModel,
    ServoFit, ServoFitter,
};
use crate::number::Number;
use crate::tuning::{
    Goal, MeasuredLine, Resonance, Tuner, TunerState, Tuning, TuningError, TuningSettings,
};

/// The background's half of a commissioning: it fits, verifies and tunes, a slice at a time. W is the
/// number of blocks of its record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommissionSolver<N: Number, const W: usize = 256> {
    settings: CommissionSettings,
    /// The phase of the motion that is recorded.
    motion: Phase,
    fitter: ServoFitter<N>,
    record: MotionRecord<N, W>,
    servo: Option<IdentifiedServo>,
    /// The servo as the first motion had it while it moved: every parameter is uncertain by itself.
    rough: Option<IdentifiedServo>,
    /// Number of second motions that were not informative enough.
    refined: u32,
    /// The step that gains are looked for with, rad.
    step: f64,
    /// The effect that the model lacks by the evidence of the motions.
    suspect: Option<Diagnosis>,
    /// The response that slides have measured, and the masses that it shows.
    response: MeasuredResponse<N>,
    masses: Option<ResponseEstimate>,
    /// Why it fails if the response does not show two masses.
    doubt: Option<Reason>,
    work: Work<N>,
}

/// The work under way.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap here, and a program holds one solver"
)]
enum Work<N: Number> {
    Nothing,
    Fitting(ServoFit<N>),
    Predicting(PredictionRun<N>),
    /// The search for the lacking effect, before the next step.
    EffectSearch(EffectSearch<N>, Then),
    Then(Then),
    /// One mass and two are fitted to the measured lines.
    Responding(ResponseFit),
    Tuning {
        tuner: Tuner,
        state: TunerState,
        /// True if the step was already chosen for the bandwidth that was found.
        fitted: bool,
    },
    NotTuned(TuningError),
}

/// The next step once a motion is explained as well as it can be.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Then {
    /// The servo is passed on.
    Publish,
    /// Its own motion is to be predicted, as it is not known well enough.
    Predict,
    /// The second motion is asked for once more.
    Again,
    /// The response is measured in slides. One mass does not explain the motions, for this reason, if there is one.
    Slide(Option<Reason>),
    /// Gains are looked for as far as one mass explains the motions.
    Settle,
    /// Gains are looked for.
    Tune,
    /// It has failed for this.
    Fail(Reason),
}

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// The part of the travel in its direction that the trial's step takes where none is given.
    const STEP: f64 = 0.25;

    /// The part that it takes where the encoder has few counts in that.
    const MAX_STEP: f64 = Candidate::<N>::MAX_END;

    /// The largest speed of a step of the reference, over the step and ω: e⁻¹ of the double pole, and a
    /// fifth for the zero of the integral and the corners of the uncertainty.
    const SPEED_OF_STEP: f64 = 0.45;

    /// The part of the largest speed that the trial's step may reach.
    const OF_SPEED: f64 = 0.7;

    /// The part of the command that it may ask for.
    const OF_COMMAND: f64 = 0.5;

    /// Minimum counts of a step that resolve an overshoot and a rise.
    const MIN_STEP_COUNTS: f64 = 40.0;

    /// The factor on the next step where friction holds the servo through one.
    const GROWTH: f64 = 4.0;

    /// Unexplained position where the model lacks something, counts.
    const UNEXPLAINED: f64 = 1.0;

    /// Unexplained position where the model lacks nothing, counts: twice the encoder's rounding.
    const EXPLAINED: f64 = 0.6;

    /// The least part of the unexplained motion that an effect must explain to be named.
    const NAMED: f64 = 0.8;

    /// The largest dead band, over the gains' command for the step: while the integral passes from one
    /// side of it to the other, the loop overshoots by about this part of the step.
    const MAX_DEAD_BAND: f64 = 0.02;

    /// Second motions after which there is too little evidence.
    const MAX_REFINEMENTS: u32 = 5;

    /// The standard error up to which b is known, a part of itself.
    const KNOWN_GAIN: f64 = 0.02;

    /// The largest standard error of ln b of a response: where it is larger, the lines do not reach below the antiresonance,
    /// where both masses move together.
    const KNOWN_RESPONSE: f64 = 0.05;

    /// The part of the command that the encoder's rounding may make up.
    const NOISE: f64 = 0.02;

    /// The ratio by which the gain of the response may differ from that of the motions before. If friction holds a load, the
    /// motor alone answers.
    const MAX_GAIN_RATIO: f64 = 1.6;

    /// For a commissioning with these settings.
    ///
    /// # Errors
    /// As [`CommissionIsr::new`](super::CommissionIsr::new).
    pub fn new(settings: &CommissionSettings) -> Result<Self, CommissionError> {
        settings.check()?;
        let settings = settings.in_units_of_noise();
        Ok(Self {
            settings,
            motion: Phase::Idle,
            fitter: ServoFitter::new(&settings.fit()),
            record: MotionRecord::EMPTY,
            servo: None,
            rough: None,
            refined: 0,
            step: 0.0,
            suspect: None,
            response: MeasuredResponse::new(&settings),
            masses: None,
            doubt: None,
            work: Work::Nothing,
        })
    }

    /// Takes an event of the interrupt.
    pub fn take(&mut self, finding: &RecordEvent<N>) {
        match &finding.0 {
            EventKind::Begins(phase) => {
                if matches!(phase, Phase::ReleasedCheck | Phase::Probing) {
                    self.servo = None;
                    self.suspect = None;
                    self.refined = 0;
                    self.masses = None;
                }
                self.motion = *phase;
                self.work = Work::Nothing;
                self.record = MotionRecord::EMPTY;
            }
            EventKind::Block(block) => {
                // A missing one shows when the motion has ended.
                let _ = self.record.take(block);
            }
            EventKind::Balance(balance) => self.response.take_balance(balance),
            EventKind::Line(sums) => self.response.take(sums),
            EventKind::Ended(_) if self.motion == Phase::Slide => self.work = self.respond(),
            EventKind::Inconclusive(moved) => {
                self.servo = self.servo.or_else(|| self.roughly(moved));
                self.work = Work::Then(Then::Slide(Some(Reason::TooLittleEvidence)));
            }
            EventKind::Ended(moved) => {
                if self.motion == Phase::Probing {
                    self.rough = self.roughly(moved);
                }
                let record = &self.record;
                self.work = match (self.motion, &self.servo) {
                    _ if !record.is_complete() => Work::Then(Then::Fail(Reason::TooLittleEvidence)),
                    (Phase::Verify, Some(servo)) => {
                        Work::Predicting(self.fitter.begin_prediction(servo))
                    }
                    (_, servo) => Work::Fitting(self.fitter.begin(record, servo.as_ref())),
                };
            }
        }
    }

    /// The frequency response that slides have measured, by frequency; empty before there were any.
    #[must_use]
    pub fn response(&self) -> &[MeasuredLine] {
        self.response.lines()
    }

    /// The resonance that the response shows, if the servo is one of two masses.
    #[must_use]
    pub fn resonance(&self) -> Option<&Resonance> {
        self.masses.as_ref()?.resonance.as_ref()
    }

    /// A slice of work: at most a block of a pass, a point of the frequency response, or a sample of a
    /// predicted step. Returns an answer when there is one.
    pub fn work(&mut self) -> Option<Decision<N>> {
        self.decide().map(Decision)
    }

    fn decide(&mut self) -> Option<DecisionKind<N>> {
        match &mut self.work {
            Work::Nothing => None,
            Work::NotTuned(error) => {
                let error = *error;
                self.work = Work::Nothing;
                Some(DecisionKind::NoGains(error))
            }
            Work::Then(then) => {
                let then = *then;
                self.work = Work::Nothing;
                self.proceed(then)
            }
            Work::Fitting(fit) => {
                let fitted = self.fitter.work(fit, &self.record)?;
                match fitted {
                    Ok(servo) => self.take_servo(servo),
                    Err(reason) => {
                        // Of an encoder's noise it would be no servo.
                        let is_quiet = self.settings.noise == 0.0;
                        self.servo = self.servo.or(self.rough.filter(|_| is_quiet));
                        let begun = self.fitter.begin_diagnosis_of(fit, &self.record);
                        self.diagnose(begun, Then::Slide(Some(reason)))
                    }
                }
            }
            Work::EffectSearch(diagnosing, then) => {
                let found = self.fitter.diagnose(diagnosing, &self.record)?;
                self.work = Work::Then(*then);
                self.suspect = found.filter(|found| found.share >= Self::NAMED);
                self.suspect
                    .map(|found| DecisionKind::Suspects(Some(found.reason)))
            }
            Work::Predicting(predicting) => {
                let prediction = self.fitter.predict(predicting, &self.record)?;
                self.judge(&prediction)
            }
            Work::Responding(fit) => {
                let masses = fit.work(self.response.lines())?;
                self.take_masses(masses)
            }
            Work::Tuning {
                tuner,
                state,
                fitted,
            } => {
                let unexplained = self.masses.is_some_and(|masses| !masses.is_one_mass());
                let lines = if unexplained {
                    self.response.lines()
                } else {
                    &[]
                };
                let tuned = tuner.work_with(state, lines)?;
                let fitted = *fitted;
                match tuned {
                    Ok(tuning) => self.offer(tuning, fitted),
                    Err(TuningError::DoesNotArrive) if self.step < self.most_room() => {
                        // Friction holds the servo through so small a step.
                        self.tune(self.settings.goal, Self::GROWTH * self.step, false);
                        None
                    }
                    Err(error) => {
                        self.work = Work::Nothing;
                        Some(DecisionKind::NoGains(error))
                    }
                }
            }
        }
    }

    /// A servo that moved by a rough model.
    fn roughly(&self, servo: &RoughModel<N>) -> Option<IdentifiedServo> {
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
            rough.know_alone(place, value);
        }
        Some(rough)
    }

    /// Takes a servo that was fitted.
    fn take_servo(&mut self, servo: IdentifiedServo) -> Option<DecisionKind<N>> {
        self.servo = Some(servo);
        let unexplained = servo.unexplained > Self::UNEXPLAINED * self.settings.resolution;
        let then = match self.motion {
            Phase::Refine if !self.is_known(&servo) && unexplained => Then::Predict,
            Phase::Refine if !self.is_known(&servo) => Then::Again,
            _ => Then::Publish,
        };
        self.explain(servo.unexplained, then)
    }

    /// Judges how a motion that nothing was fitted to was predicted.
    fn judge(&mut self, prediction: &PredictionErrors) -> Option<DecisionKind<N>> {
        let then = match self.motion {
            _ if is_refuted(prediction) => Then::Slide(Some(Reason::NotPredicted)),
            Phase::Refine => Then::Again,
            _ => Then::Slide(None),
        };
        self.explain(prediction.rms, then)
    }

    /// Looks for what a model lacks that leaves so much of a motion unexplained (rad), if it was not found
    /// before; what was found where a fit went astray is dropped once a motion is explained.
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

    fn diagnose(&mut self, begun: Option<EffectSearch<N>>, then: Then) -> Option<DecisionKind<N>> {
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

    fn proceed(&mut self, then: Then) -> Option<DecisionKind<N>> {
        match then {
            Then::Publish => self.publish(DecisionKind::Identified),
            Then::Predict => {
                let servo = self.servo.as_ref()?;
                self.work = Work::Predicting(self.fitter.begin_prediction(servo));
                None
            }
            Then::Again => {
                self.refined += 1;
                if self.refined >= Self::MAX_REFINEMENTS {
                    return self.then(Then::Slide(Some(Reason::TooLittleEvidence)));
                }
                self.publish(DecisionKind::Uncertain)
            }
            Then::Slide(doubt) => {
                self.doubt = doubt;
                let lines = self.response.begin();
                let servo = self.servo.as_ref();
                let plan = servo.and_then(|servo| {
                    SlidePlan::new(&self.settings, servo, doubt.is_some(), &lines)
                });
                let Some(plan) = plan else {
                    return self.then(Then::Settle);
                };
                self.motion = Phase::Slide;
                Some(DecisionKind::Slide(plan))
            }
            Then::Settle => match self.doubt {
                Some(reason) => self.fail(reason),
                None => self.then(Then::Tune),
            },
            Then::Tune => {
                self.tune(self.settings.goal, self.first_step(), false);
                self.publish(DecisionKind::Verified)
            }
            Then::Fail(reason) => self.fail(reason),
        }
    }

    /// Takes the next step in the next slice.
    fn then(&mut self, then: Then) -> Option<DecisionKind<N>> {
        self.work = Work::Then(then);
        None
    }

    /// Begins to fit masses to the response; without enough lines gains are looked for without.
    fn respond(&mut self) -> Work<N> {
        let is_doubted = self.doubt.is_some();
        let servo = self.servo.as_ref();
        let fit = servo.and_then(|servo| self.response.fit(servo, is_doubted));
        fit.map_or(Work::Then(Then::Settle), Work::Responding)
    }

    /// Takes in the masses that the response shows. Two explain what one did not.
    fn take_masses(&mut self, masses: ResponseEstimate) -> Option<DecisionKind<N>> {
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
            _ if masses.gain_error <= Self::KNOWN_RESPONSE => {
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

    fn publish(
        &self,
        answer: impl Fn(Identified<N>) -> DecisionKind<N>,
    ) -> Option<DecisionKind<N>> {
        let servo = self.servo.as_ref()?;
        Some(answer(Identified::new(servo, &self.settings)))
    }

    /// True if two motions determine a servo well enough to tune for it.
    fn is_known(&self, servo: &IdentifiedServo) -> bool {
        servo.standard_error(IdentifiedServo::B) <= Self::KNOWN_GAIN * servo.parameters.b
    }

    fn fail(&mut self, reason: Reason) -> Option<DecisionKind<N>> {
        self.work = Work::Nothing;
        Some(DecisionKind::Failed(reason))
    }

    /// Begins to look for gains.
    fn tune(&mut self, goal: Goal, step: f64, fitted: bool) {
        let step = step.min(self.most_room());
        self.step = step;
        let begun = self.servo.ok_or(TuningError::NotKnown).and_then(|servo| {
            let settings = TuningSettings {
                sample_time: self.settings.sample_time,
                resolution: self.settings.resolution,
                noise: self.settings.noise,
                cutoff: None,
                command: self.command(),
                command_delay: 0.0,
                goal,
                max_sensitivity: self.settings.max_sensitivity,
                max_noise: Self::NOISE,
                step,
                resonance: None,
            };
            let resonance = self.masses.and_then(|masses| masses.resonance);
            Tuner::for_response(&settings, &servo, resonance.as_ref())
        });
        self.work = match begun {
            Ok(tuner) => Work::Tuning {
                state: tuner.start(),
                tuner,
                fitted,
            },
            Err(error) => Work::NotTuned(error),
        };
    }

    /// Gains with the step that is to try them, which is chosen for them.
    fn offer(&mut self, tuning: Tuning, fitted: bool) -> Option<DecisionKind<N>> {
        let step = self.step_for(&tuning);
        let other = libm::fabs(step - tuning.promise.step) > 1e-3 * step;
        if !fitted && other {
            self.tune(Goal::Bandwidth(tuning.bandwidth), step, true);
            return None;
        }
        self.work = Work::Nothing;
        let dead = |suspect: &Diagnosis| suspect.dead_band > Self::MAX_DEAD_BAND * tuning.kp * step;
        if let Some(suspect) = self.suspect.filter(dead) {
            return self.fail(suspect.reason);
        }
        let servo = self.servo?;
        Some(match Candidate::new(&tuning, &servo, &self.settings) {
            Ok(candidate) => DecisionKind::Tuned(candidate),
            Err(_) => DecisionKind::Failed(Reason::NoGains),
        })
    }

    /// The step of the trial for gains: within speed, command and travel, and seen well by the encoder.
    fn step_for(&self, tuning: &Tuning) -> f64 {
        let limits = &self.settings.limits;
        let speed = Self::OF_SPEED * limits.speed / (Self::SPEED_OF_STEP * tuning.bandwidth);
        let command = Self::OF_COMMAND * self.command() / tuning.kp;
        let wanted = match self.settings.trial_step {
            Some(step) => step.min(speed),
            None => self.room().min(speed).min(command),
        };
        wanted.max(self.step)
    }

    /// The step that gains are looked for with: so small that it binds neither speed nor command.
    fn first_step(&self) -> f64 {
        let least = self.least_step().min(self.room());
        self.settings.trial_step.unwrap_or(least)
    }

    fn least_step(&self) -> f64 {
        Self::MIN_STEP_COUNTS * self.settings.resolution
    }

    /// The largest step within the travel, rad.
    fn room(&self) -> f64 {
        let [low, high] = self.settings.limits.travel;
        let farthest = high.max(-low);
        (Self::STEP * farthest).max(self.least_step().min(Self::MAX_STEP * farthest))
    }

    /// The largest that there can be, from one side of where it began to the other, where friction holds the servo through a
    /// smaller one, rad.
    fn most_room(&self) -> f64 {
        let [low, high] = self.settings.limits.travel;
        Self::MAX_STEP * (high - low)
    }

    /// The command that is left when the load is held.
    fn command(&self) -> f64 {
        let [low, high] = self.settings.limits.command;
        let holding = self.servo.map_or(0.0, |servo| {
            libm::fabs(servo.parameters.load / servo.parameters.b)
        });
        high.min(-low) - holding
    }
}

/// True if a servo that was identified is not the one that moved.
fn is_refuted(prediction: &PredictionErrors) -> bool {
    /// The part of the motion's range that a model may lack: what it is tuned for bears more.
    const SHARE: f64 = 0.005;
    /// Largest root mean square of the errors, and largest error, in standard deviations of rounding and
    /// of the parameters.
    const ERRORS: f64 = 3.0;
    const WORST: f64 = 6.0;
    let band = |times: f64, uncertain: f64| {
        let (rounding, unknown) = (times * prediction.rounding, times * uncertain);
        let share = SHARE * times * prediction.range;
        libm::sqrt(rounding * rounding + unknown * unknown + share * share)
    };
    let within = prediction.rms <= band(ERRORS, prediction.uncertain)
        && prediction.worst <= band(WORST, prediction.most_uncertain);
    !within
}
