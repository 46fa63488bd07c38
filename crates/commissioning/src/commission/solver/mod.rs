mod coupling;
mod gains;
mod masses;
mod motions;
mod proof;
mod surveys;
mod trial_step;

use super::message::{DecisionKind, EventKind};
use super::response::{LineMeasurement, MeasuredResponse, ResponseEstimate, ResponseFit};
use super::{
    CommissionError, CommissionSettings, Decision, Diagnosis, EffectSearch, MotionRecord, Phase,
    PredictionRun, RecordEvent, ServoFit, ServoFitter,
};
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::tuning::{MeasuredLine, Resonance, Tuner, TunerState, Tuning, TuningError};

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
    /// The last servo that explained the motion that it was fitted to.
    explained: Option<IdentifiedServo>,
    /// The servo as the first motion had it while it moved: every parameter is uncertain by itself.
    rough: Option<IdentifiedServo>,
    /// Number of second motions that were not informative enough.
    refined: u32,
    /// True once a motion that was not predicted was fitted with other friction and load.
    is_refitted: bool,
    /// The step that gains are looked for with, rad.
    step: f64,
    /// The effect that the model lacks by the evidence of the motions.
    suspect: Option<Diagnosis>,
    /// The response that slides have measured, and the masses that it shows.
    response: MeasuredResponse<N>,
    masses: Option<ResponseEstimate>,
    /// Why it fails if the response does not show two masses.
    doubt: Option<Reason>,
    /// Slides of such a servo so far, and whether it slides before all motions but the first.
    surveys: u32,
    early: Early,
    /// The gains whose proof is under way, and how many were disproved.
    tried: Option<Tuning>,
    disproved: u32,
    /// The masses by lines of the usual size, while smaller ones are measured.
    louder: Option<ResponseEstimate>,
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
    /// A motion that was not predicted is fitted with other friction and load.
    Refitting(ServoFit<N>),
    Predicting(PredictionRun<N>),
    /// The search for the lacking effect, before the next step.
    EffectSearch(EffectSearch<N>, Then),
    Then(Then),
    /// The response is measured from the sums of the slides.
    Measuring(LineMeasurement),
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
    /// Its own motion must be predicted, because its estimate is not within tolerance.
    Predict,
    /// The second motion is asked for once more.
    Again,
    /// The response is measured in slides. One mass does not explain the motions, for this reason, if there is one.
    Slide(Option<Reason>),
    /// The slides have shown no lines.
    MissLines,
    /// Gains are looked for as far as one mass explains the motions.
    Settle,
    /// Gains are looked for.
    Tune,
    /// The gains that were tried are proved by slides.
    Prove,
    /// It has failed for this.
    Fail(Reason),
}

/// The slides that follow a first motion which one mass does not explain.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Early {
    NotYet,
    UnderWay,
    /// They have not shown two masses, or a second one but not both well.
    Over {
        shown: Option<ResponseEstimate>,
    },
}

impl<N: Number, const W: usize> CommissionSolver<N, W> {
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
            explained: None,
            rough: None,
            refined: 0,
            is_refitted: false,
            step: 0.0,
            suspect: None,
            response: MeasuredResponse::new(&settings),
            masses: None,
            doubt: None,
            surveys: 0,
            early: Early::NotYet,
            tried: None,
            disproved: 0,
            louder: None,
            work: Work::Nothing,
        })
    }

    /// Takes an event of the interrupt.
    pub fn take(&mut self, finding: &RecordEvent<N>) {
        match &finding.0 {
            EventKind::Begins(phase) => {
                if matches!(phase, Phase::ReleasedCheck | Phase::Probing) {
                    self.servo = None;
                    self.explained = None;
                    self.suspect = None;
                    self.refined = 0;
                    self.is_refitted = false;
                    self.masses = None;
                    self.surveys = 0;
                    self.early = Early::NotYet;
                    self.tried = None;
                    self.disproved = 0;
                    self.louder = None;
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
            EventKind::Ended(_) if self.motion == Phase::Slide => {
                self.work = Work::Measuring(self.response.begin_lines());
            }
            EventKind::Tried => self.work = Work::Then(Then::Prove),
            EventKind::Inconclusive(moved, reason) => {
                self.servo = self.servo.or_else(|| self.roughly(moved));
                let rings = *reason == Reason::Oscillating;
                if rings && self.is_first_doubt() && self.record.is_complete() {
                    // It is fitted once slides have shown no second mass.
                    self.rough = self.servo;
                    self.early = Early::UnderWay;
                }
                self.work = Work::Then(Then::Slide(Some(Reason::TooLittleEvidence)));
            }
            EventKind::Ended(moved) => {
                if matches!(self.motion, Phase::ReleasedCheck | Phase::Probing) {
                    self.rough = self.roughly(moved);
                }
                let record = &self.record;
                self.work = match (self.motion, &self.servo) {
                    _ if !record.is_complete() => Work::Then(Then::Fail(Reason::TooLittleEvidence)),
                    (Phase::Verify, Some(servo)) => {
                        Work::Predicting(self.fitter.begin_prediction(servo, record))
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

    /// The resonance in the response, if the servo is one of two masses. None if the lines leave the gain open.
    #[must_use]
    pub fn resonance(&self) -> Option<&Resonance> {
        let masses = self.masses.as_ref().filter(|masses| masses.is_known());
        masses?.resonance.as_ref()
    }

    /// A slice of work. It is up to a block of a pass, a point of the frequency response, or a sample of a predicted
    /// step. Returns an answer when there is one.
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
                        if self.is_first_doubt() {
                            return self.slide_early(reason);
                        }
                        self.diagnose(begun, Then::Slide(Some(reason)))
                    }
                }
            }
            Work::Refitting(fit) => {
                let refitted = self.fitter.work(fit, &self.record)?;
                self.take_refit(refitted)
            }
            Work::EffectSearch(diagnosing, then) => {
                let found = self.fitter.diagnose(diagnosing, &self.record)?;
                self.work = Work::Then(*then);
                self.suspect(found)
            }
            Work::Predicting(predicting) => {
                let prediction = self.fitter.predict(predicting, &self.record)?;
                self.judge(&prediction)
            }
            Work::Measuring(measuring) => {
                if !self.response.measure(measuring) {
                    return None;
                }
                match self.tried {
                    Some(tuning) => self.judge_proof(&tuning),
                    None => {
                        self.work = self.respond();
                        None
                    }
                }
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
                let is_explained = !unexplained && self.disproved == 0;
                let tuned = tuner.work_with(state, self.response.lines(), is_explained)?;
                let fitted = *fitted;
                self.take_tuning(tuned, fitted)
            }
        }
    }
}
