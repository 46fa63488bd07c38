use super::margins::Margins;
use super::placement::Design;
use super::possible_servos::PossibleServos;
use super::prediction::{Prediction, Rise, Scene};
use super::search::{Case, Judge, Largest, Search, Verdict};
use super::{Cap, Goal, Tuning, TuningError, TuningSettings};
use crate::commission::IdentifiedServo;

/// Finds gains for an identified servo, in slices of work that are short enough for the background of a
/// chip: a slice is one frequency of one servo or one sample of a predicted step.
///
/// It takes fewer than 20 000 slices, whatever it is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuner {
    judge: Judge,
    scene: Scene,
}

/// A tuning under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TunerState(Task);

#[derive(Debug, Clone, Copy, PartialEq)]
enum Task {
    /// Judges what was asked for.
    Ask(Case, Corrections),
    /// Looks for the largest bandwidth; for a bandwidth that was asked for in vain, or for its own sake.
    Search(Search, Option<f64>),
    /// Times the rise of a design, to correct its bandwidth by.
    Time(Found, Rise, Corrections),
    Predict(Found, Prediction),
    End(Result<Tuning, TuningError>),
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Found {
    design: Design,
    margins: Margins,
    cap: Option<Cap>,
}

/// The corrections of a bandwidth towards a response time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Corrections {
    /// How often it may still be corrected.
    left: u32,
    /// The power of the bandwidth with which the rise time falls: one, and more with friction.
    slope: f64,
    /// Bandwidth and rise time that were tried last.
    last: Option<[f64; 2]>,
}

impl Tuner {
    /// The rise time of an ideal loop times its ω: from 10 to 90 % of
    /// 1 + 0.625 e^(−ωt/5) − (1.625 + 1.5 ωt) e^(−ωt), the step response of the placement without delay.
    pub const RISE: f64 = 1.913_806_957_6;

    /// For an identified servo.
    ///
    /// # Errors
    /// A setting out of its range, or [`TuningError::NotKnown`] for a servo that is no servo, or known so
    /// badly that b may be zero.
    pub fn new(settings: &TuningSettings, servo: &IdentifiedServo) -> Result<Self, TuningError> {
        settings.check()?;
        let coulomb = servo.parameters.coulomb.max(0.0);
        if !coulomb.is_finite() {
            return Err(TuningError::NotKnown);
        }
        let servos = PossibleServos::new(servo, settings.command_delay, settings.sample_time)?;
        Ok(Self {
            judge: Judge::new(&servos, settings),
            scene: Scene {
                servos,
                coulomb,
                settings: *settings,
            },
        })
    }

    /// Begins.
    #[must_use]
    pub fn start(&self) -> TunerState {
        TunerState(match self.scene.settings.goal {
            Goal::ResponseTime(time) => {
                Task::Ask(self.judge.open(Self::RISE / time), Corrections::FOR_TIME)
            }
            Goal::Bandwidth(bandwidth) => Task::Ask(self.judge.open(bandwidth), Corrections::NONE),
            Goal::Stiffest => Task::Search(Search::from(&self.judge, self.first_guess()), None),
        })
    }

    /// A slice of work. Returns the gains when they are found; from then on the same again.
    pub fn work(&self, state: &mut TunerState) -> Option<Result<Tuning, TuningError>> {
        let next = match &mut state.0 {
            Task::Ask(case, corrections) => {
                let bandwidth = case.bandwidth();
                match self.judge.work(case)? {
                    Verdict::Keeps(design, margins) => {
                        let found = Found {
                            design,
                            margins,
                            cap: None,
                        };
                        self.correct_or_predict(found, *corrections)
                    }
                    Verdict::Breaks(_) => {
                        Task::Search(Search::from(&self.judge, 0.5 * bandwidth), Some(bandwidth))
                    }
                }
            }
            Task::Search(search, asked) => match (search.work(&self.judge)?, *asked) {
                (None, _) => Task::End(Err(TuningError::NotKnown)),
                (Some(largest), Some(bandwidth)) => Task::End(Err(TuningError::TooFast {
                    bandwidth,
                    most: largest.design.bandwidth,
                    cap: largest.cap,
                })),
                (Some(largest), None) => self.predict(largest.into()),
            },
            Task::Time(found, rise, corrections) => match rise.work()? {
                Err(error) => Task::End(Err(error)),
                Ok(time) => self.corrected(*found, time, *corrections),
            },
            Task::Predict(found, prediction) => Task::End(
                prediction
                    .work(&self.scene)?
                    .map(|promise| found.tuning(promise)),
            ),
            Task::End(result) => return Some(*result),
        };
        state.0 = next;
        match &state.0 {
            Task::End(result) => Some(*result),
            _ => None,
        }
    }

    /// A tenth of what delay and hold would leave to an ideal loop.
    fn first_guess(&self) -> f64 {
        let TuningSettings { sample_time, .. } = self.scene.settings;
        0.1 / (sample_time + self.scene.servos.identified().delay)
    }

    fn correct_or_predict(&self, found: Found, corrections: Corrections) -> Task {
        if corrections.left == 0 {
            return self.predict(found);
        }
        match Rise::begin(&self.scene, &found.design) {
            Ok(rise) => Task::Time(found, rise, corrections),
            Err(error) => Task::End(Err(error)),
        }
    }

    /// Goes on after a rise that took so long: predicts, or tries the bandwidth at which the rise should
    /// take as long as was asked for.
    fn corrected(&self, found: Found, time: f64, corrections: Corrections) -> Task {
        /// How close a rise time comes to what was asked for.
        const CLOSE: f64 = 0.01;
        let Goal::ResponseTime(asked) = self.scene.settings.goal else {
            return self.predict(found);
        };
        let bandwidth = found.design.bandwidth;
        if libm::fabs(time / asked - 1.0) < CLOSE || corrections.left == 1 {
            return self.predict(found);
        }
        let corrections = corrections.after(bandwidth, time);
        let next = bandwidth * libm::pow(time / asked, 1.0 / corrections.slope);
        Task::Ask(self.judge.open(next), corrections)
    }

    fn predict(&self, found: Found) -> Task {
        match Prediction::begin(&self.scene, &found.design, &found.margins) {
            Ok(prediction) => Task::Predict(found, prediction),
            Err(error) => Task::End(Err(error)),
        }
    }
}

/// Gains for an identified servo, all at once.
///
/// # Errors
/// As [`Tuner::new`]; [`TuningError::TooFast`] with what would do, or [`TuningError::DoesNotArrive`].
pub fn tune(settings: &TuningSettings, servo: &IdentifiedServo) -> Result<Tuning, TuningError> {
    let tuner = Tuner::new(settings, servo)?;
    let mut state = tuner.start();
    loop {
        if let Some(result) = tuner.work(&mut state) {
            return result;
        }
    }
}

impl Corrections {
    const NONE: Self = Self {
        left: 0,
        slope: 1.0,
        last: None,
    };
    /// Each leaves a small part of what is amiss.
    const FOR_TIME: Self = Self {
        left: 6,
        ..Self::NONE
    };

    /// After another bandwidth and its rise time: the slope is that between the last two.
    fn after(self, bandwidth: f64, time: f64) -> Self {
        /// Counts and samples make a rise time uneven.
        const SLOPES: (f64, f64) = (0.5, 8.0);
        let slope = self.last.map_or(self.slope, |[before, took]| {
            let slope = libm::log(took / time) / libm::log(bandwidth / before);
            let (least, most) = SLOPES;
            if slope >= least {
                slope.min(most)
            } else {
                least
            }
        });
        Self {
            left: self.left - 1,
            slope,
            last: Some([bandwidth, time]),
        }
    }
}

impl From<Largest> for Found {
    fn from(largest: Largest) -> Self {
        Self {
            design: largest.design,
            margins: largest.margins,
            cap: Some(largest.cap),
        }
    }
}

impl Found {
    fn tuning(&self, promise: super::Promise) -> Tuning {
        let Design {
            bandwidth,
            kp,
            kd,
            ki,
            cutoff,
            ..
        } = self.design;
        Tuning {
            kp,
            kd,
            ki,
            cutoff,
            bandwidth,
            cap: self.cap,
            promise,
        }
    }
}
