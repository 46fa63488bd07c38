use super::axis_forces::AxisForces;
use super::closed_loop::{PredictedSample, PredictedStep};
use super::placement::Design;
use super::possible_servos::{PossibleServo, PossibleServos};
use super::prediction::{PredictionInputs, ResponsePrediction};
use super::resonance::Resonance;
use super::response_time::ByTime;
use super::sampled_response::SampledServo;
use super::search::{Case, Found, GainCheck, Search, Verdict};
use super::shown::Shown;
use super::{Goal, Tuning, TuningError, TuningSettings};
use crate::number::Complex;
use crate::parameters::IdentifiedServo;

/// Finds gains for an identified servo, in slices of work that are short enough for the background of a chip. A slice
/// is one frequency of one servo or one sample of a predicted step.
///
/// Any goal takes fewer than 25 000 slices, and fewer than 60 000 for a servo of two masses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuner {
    judge: GainCheck,
    scene: PredictionInputs,
}

/// A tuning in progress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TunerState(Task);

#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap here, and a program holds one tuning; it is large on 64 bits alone"
)]
enum Task {
    /// Nothing was done yet.
    Begin,
    /// Looks for the bandwidth of a response time.
    Time(ByTime),
    /// Judges the requested gains.
    Ask(Case),
    /// Looks for the largest bandwidth: for one that was asked for in vain, or for its own sake.
    Search(Search, Option<f64>),
    /// These gains keep everything.
    Found(Found),
    Predict(Found, ResponsePrediction),
    End(Result<Tuning, TuningError>),
}

impl Tuner {
    /// The rise time of an ideal loop times its ω, from 10 to 90 % of the step. The response is (1 + 2s)/((1 + 3s)(1 +
    /// s)(1 + s + s²)), s over ω. This is the placement with its reference filter and without delay.
    pub const RISE: f64 = 3.406_5;

    /// For an identified servo.
    ///
    /// # Errors
    /// A setting out of its range. [`TuningError::NotKnown`] if the parameters are no servo's, or so uncertain that b
    /// may be zero.
    pub fn new(settings: &TuningSettings, servo: &IdentifiedServo) -> Result<Self, TuningError> {
        Self::for_response(settings, servo, None)
    }

    /// The same for a servo whose response was measured, with the resonance that it shows.
    ///
    /// # Errors
    /// As [`Tuner::new`].
    pub fn for_response(
        settings: &TuningSettings,
        servo: &IdentifiedServo,
        resonance: Option<&Resonance>,
    ) -> Result<Self, TuningError> {
        settings.check()?;
        // The predicted response has no second mass, which a reference model would excite.
        let settings = &TuningSettings {
            feed_forward: settings.feed_forward && resonance.is_none(),
            ..*settings
        };
        let coulomb = servo.parameters.coulomb.max(0.0);
        if !coulomb.is_finite() {
            return Err(TuningError::NotKnown);
        }
        let servos = PossibleServos::new(servo, settings.command_delay, settings.sample_time)?;
        let frictions = [coulomb, servo.most_coulomb()];
        Ok(Self {
            judge: GainCheck::new(&servos, frictions, resonance, settings),
            scene: PredictionInputs {
                servos,
                coulomb,
                forces: AxisForces::default(),
                mode: resonance.map(|resonance| resonance.mode),
                settings: *settings,
            },
        })
    }

    /// The same with forces on the axis beside the servo, which the predicted response has.
    #[must_use]
    pub fn with_forces(mut self, forces: AxisForces) -> Self {
        self.scene.forces = forces;
        self
    }

    /// Begins.
    #[must_use]
    pub fn start(&self) -> TunerState {
        TunerState(Task::Begin)
    }

    /// Works to the end, all at once.
    ///
    /// # Errors
    /// [`TuningError::TooFast`] with a bandwidth that would do, or [`TuningError::DoesNotArrive`].
    pub fn run(&self, shown: Shown<'_>) -> Result<Tuning, TuningError> {
        let mut state = self.start();
        loop {
            if let Some(result) = self.work_with(&mut state, shown) {
                return result;
            }
        }
    }

    fn first_task(&self) -> Task {
        match self.scene.settings.goal {
            Goal::ResponseTime(time) => {
                let bandwidth = Self::RISE / time;
                match ByTime::begin(&self.scene, &self.judge, bandwidth, time) {
                    Ok(by_time) => Task::Time(by_time),
                    Err(_) => Task::Ask(self.judge.open(bandwidth, false)),
                }
            }
            Goal::Bandwidth(bandwidth) => Task::Ask(self.judge.open(bandwidth, false)),
            Goal::Stiffest => Task::Search(Search::from(self.first_guess()), None),
        }
    }

    /// A slice of work. Returns the gains when they are ready, and the same from then on.
    pub fn work(&self, state: &mut TunerState) -> Option<Result<Tuning, TuningError>> {
        self.work_with(state, Shown::Nothing)
    }

    /// The same with what a motion has shown of the servo's response.
    pub fn work_with(
        &self,
        state: &mut TunerState,
        shown: Shown<'_>,
    ) -> Option<Result<Tuning, TuningError>> {
        let next = match &mut state.0 {
            Task::Begin => self.first_task(),
            Task::Time(by_time) => {
                let bandwidth = by_time.work(&self.scene, &self.judge)?;
                Task::Ask(self.judge.open(bandwidth, false))
            }
            Task::Ask(case) => match self.judge.work(case, shown)? {
                Verdict::Passes(design, margins) => Task::Found(Found {
                    design,
                    margins,
                    cap: None,
                }),
                Verdict::Fails(_) if self.judge.has_notch() && !case.is_notched() => {
                    Task::Ask(self.judge.open(case.bandwidth(), true))
                }
                Verdict::Fails(_) => {
                    let asked = case.bandwidth();
                    Task::Search(Search::from(0.5 * asked), Some(asked))
                }
            },
            Task::Search(search, asked) => match (search.work(&self.judge, shown)?, *asked) {
                (Some(found), None) => Task::Found(found),
                (
                    Some(Found {
                        design,
                        cap: Some(cap),
                        ..
                    }),
                    Some(bandwidth),
                ) => Task::End(Err(TuningError::TooFast {
                    bandwidth,
                    most: design.bandwidth,
                    cap,
                })),
                _ => Task::End(Err(TuningError::NotKnown)),
            },
            Task::Found(found) => self.predict(*found),
            Task::Predict(found, prediction) => Task::End(
                prediction
                    .work(&self.scene)?
                    .map(|predicted_response| found.tuning(predicted_response)),
            ),
            Task::End(result) => return Some(*result),
        };
        state.0 = next;
        match &state.0 {
            Task::End(result) => Some(*result),
            _ => None,
        }
    }

    /// |S(jω)| of gains at a frequency ω, rad/s: for the identified servo, for two masses if they were measured, and the
    /// largest for all possible servos. None from half of the sampling frequency on.
    #[must_use]
    pub fn sensitivity(&self, tuning: &Tuning, frequency: f64) -> Option<[f64; 2]> {
        self.judge
            .sensitivity(&Design::from_tuning(tuning), frequency)
    }

    /// True if a controller, command units per rad at ν = tan(ωT/2), bears the resonances that nothing has shown.
    #[must_use]
    pub fn bears_hidden(&self, shown: Shown<'_>, controller: impl Fn(f64) -> Complex) -> bool {
        self.judge.bears_hidden(shown, controller)
    }

    /// The servos that gains are judged with, of one mass and then of two, each with the largest sensitivity that is allowed.
    pub fn sampled_servos(&self) -> impl Iterator<Item = (SampledServo, f64)> {
        (0..).map_while(|place| self.judge.servo(place))
    }

    /// The identified servo, first, and the corners of its uncertainty, each with all of its delay.
    #[must_use]
    pub fn possible_servos(&self) -> &[PossibleServo] {
        self.scene.servos.iter().as_slice()
    }

    /// The predicted step of gains.
    ///
    /// # Errors
    /// [`TuningError::OutOfRange`] for gains that no controller has.
    pub fn step(
        &self,
        tuning: &Tuning,
    ) -> Result<impl Iterator<Item = PredictedSample> + Copy + use<>, TuningError> {
        self.step_after(tuning, 0.0)
    }

    /// The same after an earlier motion that left the integral with a share of the friction: one in the direction of the step
    /// left all of it, one against it the negative.
    ///
    /// # Errors
    /// As [`Tuner::step`].
    pub fn step_after(
        &self,
        tuning: &Tuning,
        share: f64,
    ) -> Result<impl Iterator<Item = PredictedSample> + Copy + use<>, TuningError> {
        let closed_loop = self.scene.step_after(&Design::from_tuning(tuning), share)?;
        Ok(PredictedStep::new(closed_loop))
    }

    /// A tenth of the bandwidth that delay and hold would leave to an ideal loop.
    fn first_guess(&self) -> f64 {
        let TuningSettings { sample_time, .. } = self.scene.settings;
        0.1 / (sample_time + self.scene.servos.identified().delay)
    }

    fn predict(&self, found: Found) -> Task {
        match ResponsePrediction::begin(&self.scene, &found.design, &found.margins) {
            Ok(prediction) => Task::Predict(found, prediction),
            Err(error) => Task::End(Err(error)),
        }
    }
}

impl TuningSettings {
    /// Gains for an identified servo, all at once.
    ///
    /// # Errors
    /// As [`Tuner::new`]; [`TuningError::TooFast`] with a bandwidth that would do, or [`TuningError::DoesNotArrive`].
    pub fn tune(&self, servo: &IdentifiedServo) -> Result<Tuning, TuningError> {
        Tuner::new(self, servo)?.run(Shown::Nothing)
    }
}

impl Found {
    fn tuning(&self, predicted_response: super::PredictedResponse) -> Tuning {
        let design = &self.design;
        Tuning {
            kp: design.kp,
            kd: design.kd,
            ki: design.ki,
            cutoff: design.cutoff,
            reference_filter: design.reference_filter,
            notch: design.notch,
            feed_forward: design.feed_forward,
            bandwidth: design.bandwidth,
            cap: self.cap,
            predicted_response,
        }
    }
}
