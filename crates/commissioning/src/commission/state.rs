use super::frequency_response::ResponseMotion;
use super::governor::Governed;
use super::half_cycles::HalfCycles;
use super::holding::Holding;
use super::message::{Candidate, EventKind, Identified};
use super::noise::{Held, Hysteresis, RestNoise};
use super::standing::Standing;
use super::trial::{Trial, TrialResult};
use super::{Phase, ProbingState, RecordEvent, RoughModel};
use crate::watch::{Observation, ServoWatchState};
use identifier_core::control::ControlSample;
use identifier_core::fit::{Blocking, Recorder};
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::reason::Reason;
use identifier_core::tuning::{Tuning, TuningError};

/// A commissioning under way. Positions in counts from where it began.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommissionState<N: Number> {
    pub(super) phase: Phase,
    pub(super) activity: Activity<N>,
    /// Samples since the activity began.
    pub(super) passed: u32,
    hysteresis: Hysteresis<N>,
    count: Held,
    pub(super) rest_noise: RestNoise<N>,
    pub(super) position: N,
    pub(super) governed: Governed<N>,
    /// The command that acts, and the one that held the servo before anything was done.
    pub(super) command: N,
    pub(super) held: N,
    /// The largest ω T of the loops that hold the servo during identification.
    pub(super) bandwidth: N,
    /// The half-cycles under the loop that acts, and how many of them it drove.
    pub(super) half_cycles: HalfCycles<N>,
    pub(super) driven: u32,
    /// The same as the caller gets it: none where the stage is disabled.
    pub(super) acting: Option<N>,
    /// The sample, for the watch, whether it is watched, and whether all was over before it.
    pub(super) observation: Observation<N>,
    pub(super) is_watched: bool,
    pub(super) was_end: bool,
    pub(super) watch: ServoWatchState<N>,
    recorder: Recorder<N>,
    is_recording: bool,
    /// The event for the solver that comes before further blocks.
    pub(super) event: Option<EventKind<N>>,
    /// Not moved but changed in place: it is too large to be copied in a sample.
    pub(super) response_motion: ResponseMotion<N>,
    /// The model of the holding loop, and the test of a standstill under a command that must move the servo.
    pub(super) rough: RoughModel<N>,
    pub(super) standing: Standing<N>,
    pub(super) next: Next<N>,
    pub(super) identified: Option<Identified<N>>,
    pub(super) candidate: Option<Candidate<N>>,
    pub(super) tuning_error: Option<TuningError>,
    pub(super) trial: Option<TrialResult>,
    /// A trial that has ended, before it is a result.
    pub(super) measured: Option<Trial<N>>,
    pub(super) reason: Option<Reason>,
}

/// The activity that moves or holds the servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Activity<N: Number> {
    Free,
    Probing(ProbingState<N>),
    Holding(Holding<N>),
    /// By the plan in [`CommissionState::response_motion`].
    ResponseWindows(Holding<N>),
    OnTrial(Holding<N>, Trial<N>),
}

impl<N: Number> Activity<N> {
    /// Where a controller wants the servo; none where none acts.
    pub(super) fn setpoint(&self) -> Option<N> {
        match self {
            Self::Free | Self::Probing(_) => None,
            Self::Holding(holding) | Self::ResponseWindows(holding) | Self::OnTrial(holding, _) => {
                Some(holding.reference())
            }
        }
    }
}

impl<N: Number> Activity<N> {
    /// Confines the commands of this sample.
    pub(super) fn allow(&mut self, commands: [N; 2]) {
        match self {
            Self::Free => {}
            Self::Probing(probing) => probing.allow(commands),
            Self::Holding(holding) | Self::ResponseWindows(holding) | Self::OnTrial(holding, _) => {
                holding.allow(commands);
            }
        }
    }

    /// True if the command that acts must move the servo.
    pub(super) fn must_move(&self) -> bool {
        matches!(self, Self::Probing(probing) if probing.is_oscillating())
    }
}

/// The next step while the servo is held, by the solver's decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Next<N> {
    /// Nothing before the solver answers.
    Decision,
    /// The frequency-response motions once it is at rest.
    ResponseMotion,
    /// Gains are looked for.
    Tune,
    /// The trial once it is at rest.
    Trial,
    /// The test of a suspected fault, at this speed. Once the servo is at rest, a command in each direction decides;
    /// it has lasted this number of samples.
    Prove {
        fault: Reason,
        speed: N,
        up: bool,
        pushed: u32,
    },
    /// The end.
    End(Reason),
}

impl<N: Number> CommissionState<N> {
    pub(super) fn begun(
        count: i32,
        command: N,
        activity: Activity<N>,
        watch: ServoWatchState<N>,
        hysteresis: Hysteresis<N>,
        bandwidth: N,
    ) -> Self {
        Self {
            phase: Phase::Rest,
            activity,
            passed: 0,
            hysteresis,
            count: Held::at(count),
            rest_noise: RestNoise::default(),
            position: N::ZERO,
            governed: Governed::default(),
            command,
            held: command,
            bandwidth,
            half_cycles: HalfCycles::from(N::ZERO),
            driven: 0,
            acting: None,
            observation: Observation {
                increment: None,
                command,
                position: N::ZERO,
                setpoint: None,
                late: false,
                must_move: false,
                excited: false,
            },
            is_watched: false,
            was_end: false,
            watch,
            recorder: Recorder::default(),
            is_recording: matches!(activity, Activity::Free),
            event: match activity {
                Activity::Free => Some(EventKind::Begins),
                _ => None,
            },
            response_motion: ResponseMotion::default(),
            rough: RoughModel::default(),
            standing: Standing::at(N::ZERO),
            next: Next::Decision,
            identified: None,
            candidate: None,
            tuning_error: None,
            trial: None,
            measured: None,
            reason: None,
        }
    }

    /// Where it stands.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Standard deviation of the encoder's noise while the servo rested in the beginning, counts; that of rounding is not
    /// in it.
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.rest_noise.deviation().to_f64()
    }

    /// Position from where it began, counts.
    pub(super) fn moved(&self) -> f64 {
        f64::from(self.count.moved())
    }

    /// Why it ended without new gains, if it did.
    #[must_use]
    pub fn reason(&self) -> Option<Reason> {
        self.reason
    }

    /// The servo as identified so far.
    #[must_use]
    pub fn servo(&self) -> Option<&IdentifiedServo> {
        self.identified.as_ref().map(|known| &known.servo)
    }

    /// The new gains, on trial or applied, and their predicted response.
    #[must_use]
    pub fn tuning(&self) -> Option<&Tuning> {
        self.candidate.as_ref().map(|candidate| &candidate.tuning)
    }

    /// Where a controller wants the servo, counts from where it began; none where none acts.
    #[must_use]
    pub fn setpoint(&self) -> Option<N> {
        let setpoint = self.activity.setpoint()?;
        Some(self.hysteresis.in_counts(setpoint))
    }

    /// Why there are no gains, where that is why it ended, and which would do.
    #[must_use]
    pub fn tuning_error(&self) -> Option<&TuningError> {
        self.tuning_error.as_ref()
    }

    /// The measurements of the trial up to where it ended.
    #[must_use]
    pub fn trial(&self) -> Option<&TrialResult> {
        self.trial.as_ref()
    }

    /// Puts a commissioning that has run no sample yet at another count.
    pub fn begin_at(&mut self, count: i32) {
        self.count = Held::at(count);
    }

    /// Has the old gains, if there are any, hold the servo at rest for this many samples before the first motion.
    pub fn rest_for(&mut self, samples: u32) {
        if let Activity::Holding(holding) = &mut self.activity {
            holding.rest_for(samples);
        }
    }

    /// The last sample of the controller that holds the servo, for one that takes over from there; none where
    /// none acts.
    #[must_use]
    pub fn last_sample(&self) -> Option<ControlSample<N>> {
        let setpoint = self.activity.setpoint()?;
        let last = ControlSample {
            error: setpoint - self.position,
            increment: self.governed.speed(),
            velocity: self.governed.speed(),
            command: self.command,
        };
        Some(last.scaled(|units| self.hysteresis.in_counts(units)))
    }

    /// Takes in a count, and returns the increment since the last.
    pub(super) fn follow(&mut self, count: Option<i32>) -> Option<N> {
        let count = count?;
        if self.phase == Phase::Rest {
            self.rest_noise.take(count);
        }
        // A tight loop turns at every edge by itself.
        let is_open = matches!(self.phase, Phase::Rest | Phase::Probe);
        let [position, increment] = self.hysteresis.follow(&mut self.count, count, is_open);
        self.position = position;
        Some(increment)
    }

    /// Begins an activity, whose first command is that of the next sample.
    pub(super) fn begin(&mut self, activity: Activity<N>) {
        self.activity = activity;
        self.passed = 0;
        (self.half_cycles, self.driven) = (HalfCycles::from(self.position), 0);
        self.standing = Standing::at(self.position);
    }

    /// The suspected fault, while the old gains hold the servo for its test.
    pub(super) fn suspected_fault(&self) -> Option<Reason> {
        match self.next {
            Next::Prove { fault, .. } if !self.phase.is_end() => Some(fault),
            _ => None,
        }
    }

    pub(super) fn begin_record(&mut self) {
        self.recorder.begin_anew();
        self.is_recording = true;
        self.event = Some(EventKind::Begins);
    }

    pub(super) fn end_record(&mut self, event: EventKind<N>) {
        self.is_recording = false;
        self.event = Some(event);
    }

    pub(super) fn drop_record(&mut self) {
        self.is_recording = false;
        self.event = None;
    }

    /// Takes a sample into the record, with the command that acts from now on.
    pub(super) fn record(&mut self, blocking: &Blocking<N>, increment: N) {
        if self.is_recording {
            self.recorder.push(blocking, increment, self.command);
        }
    }

    /// The event for the solver in this sample.
    pub(super) fn finding(&mut self) -> Option<RecordEvent<N>> {
        // Asked first: an event is large, and to take none would copy one in every sample.
        if self.event.is_some() {
            return self.event.take().map(RecordEvent);
        }
        let block = self.is_recording.then(|| self.recorder.take())??;
        Some(RecordEvent(EventKind::Block(block)))
    }
}
