use super::super::regression::{Regression, RegressionState};
use super::motion::MotionRecord;
use super::pass::{BestServoFit, ServoFitPass, next_trial};
use super::prior::ServoPrior;
use super::{A, B, COULOMB, DELAY, LOAD, UNKNOWNS};
use crate::fit::ROUNDING;
use crate::fit::colour::Colour;
use crate::fit::levenberg_marquardt::{Descent, DescentSettings, Explanation};
use crate::measurement::direction::direction;
use crate::model::FrictionStep;
use crate::number::Number;

/// A fit under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ServoFit<N> {
    prior: ServoPrior<N>,
    bounds: [[N; UNKNOWNS]; 2],
    stage: ServoFitStage<N>,
    /// The piece that comes next.
    next: usize,
    /// The pieces that a pass takes: first a few, then twice as many, then all of them, as a model that
    /// is not near is far away after many turns.
    few: usize,
    taken: usize,
    pass: Option<ServoFitPass<N>>,
    descent: Descent<N, UNKNOWNS, Colour<N>>,
    best: Option<BestServoFit<N>>,
    /// Starts that were tried, and from where the next ones are taken.
    starts: u32,
    first: [N; UNKNOWNS],
    /// True if the servo has moved in the linear pass.
    moved: bool,
    over: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum ServoFitStage<N> {
    /// The linear estimate is gathered.
    Linear(Regression<N>, RegressionState<N>, N),
    /// The model is fitted.
    Model,
}

impl<N: Number> ServoFit<N> {
    /// The descent from a start.
    const DESCENT: DescentSettings = DescentSettings {
        damping: 1e-3,
        max_passes: 12,
        min_change: 1e-4,
    };
    /// A motion is explained if the variance of the errors is below this many times the encoder's.
    const EXPLAINED: f64 = 1.5;
    /// Factors on gain and friction of the linear estimate, and additions to its delay (samples):
    /// further starts where the motion is not explained.
    const LADDER: [[f64; 3]; 9] = [
        [1.0, 1.0, 0.0],
        [1.0, 1.0, -0.9],
        [1.0, 1.0, 1.0],
        [1.0, 1.5, 0.0],
        [1.0, 0.6, 0.0],
        [0.7, 1.0, 0.0],
        [1.4, 1.0, 0.0],
        [2.0, 1.0, 0.0],
        [0.4, 0.5, 0.0],
    ];

    pub(super) fn from_nothing(
        prior: ServoPrior<N>,
        bounds: [[N; UNKNOWNS]; 2],
        regression: Regression<N>,
        delay: f64,
    ) -> Self {
        let stage = ServoFitStage::Linear(regression, RegressionState::NOTHING, N::from_f64(delay));
        Self::at(prior, bounds, stage, [N::ZERO; UNKNOWNS])
    }

    /// Starts with this many pieces.
    pub(super) fn few_first(mut self, pieces: usize) -> Self {
        self.few = pieces;
        self.taken = match self.stage {
            ServoFitStage::Linear(..) => usize::MAX,
            ServoFitStage::Model => pieces,
        };
        self
    }

    pub(super) fn from_known(
        prior: ServoPrior<N>,
        bounds: [[N; UNKNOWNS]; 2],
        first: [N; UNKNOWNS],
    ) -> Self {
        Self::at(prior, bounds, ServoFitStage::Model, first)
    }

    fn at(
        prior: ServoPrior<N>,
        bounds: [[N; UNKNOWNS]; 2],
        stage: ServoFitStage<N>,
        first: [N; UNKNOWNS],
    ) -> Self {
        Self {
            prior,
            bounds,
            stage,
            next: 0,
            few: usize::MAX,
            taken: usize::MAX,
            pass: None,
            descent: Descent::begin(&Self::DESCENT),
            best: None,
            starts: 0,
            first,
            moved: false,
            over: false,
        }
    }

    /// The unknowns that explain the motion best; none if none was tried.
    pub(super) fn best(&self) -> Option<&BestServoFit<N>> {
        self.best.as_ref()
    }

    /// The linear estimate, or the prior one.
    pub(super) fn first(&self) -> &[N; UNKNOWNS] {
        &self.first
    }

    /// True if there is no more to do.
    pub(super) fn is_over(&self) -> bool {
        self.over
    }

    /// Continues by a piece.
    pub(super) fn advance<const W: usize>(
        &mut self,
        step: &FrictionStep<N>,
        motion: &MotionRecord<N, W>,
    ) {
        self.over = self.ends(step, motion);
    }

    /// For viscous friction and delay that explain the motion best: true if it is as large as it may be.
    pub(super) fn are_at_upper_bounds(&self, best: &BestServoFit<N>) -> [bool; 2] {
        let [_, high] = &self.bounds;
        [
            best.unknowns[A] >= high[A],
            best.unknowns[DELAY] >= high[DELAY],
        ]
    }

    /// Continues by a piece; true if there is no more to do.
    fn ends<const W: usize>(
        &mut self,
        step: &FrictionStep<N>,
        motion: &MotionRecord<N, W>,
    ) -> bool {
        if self.next < self.taken
            && let Some(piece) = motion.get(self.next)
        {
            match (&mut self.stage, &mut self.pass) {
                (ServoFitStage::Linear(regression, gathered, _), _) => {
                    let direction = direction(self.next, |index| Some(motion.get(index)?.travel));
                    if direction != N::ZERO && !self.moved {
                        self.moved = true;
                        if self.next > 2
                            && let Some(before) = motion.get(self.next - 1)
                        {
                            gathered.broke_away(before.command, direction);
                        }
                    }
                    regression.observe_for(
                        piece.samples,
                        gathered,
                        piece.travel,
                        direction,
                        piece.command,
                    );
                }
                (ServoFitStage::Model, Some(pass)) => pass.take(step, motion, self.next),
                (ServoFitStage::Model, None) => {
                    self.begin_pass(motion, self.first);
                    return false;
                }
            }
            self.next += 1;
            return false;
        }
        self.next = 0;
        if let ServoFitStage::Linear(_, gathered, delay) = self.stage {
            let Some(servo) = gathered.estimate() else {
                return true;
            };
            self.first[A] = servo.viscous;
            self.first[B] = servo.gain;
            self.first[COULOMB] = servo.coulomb();
            self.first[DELAY] = delay;
            self.first[LOAD] = servo.load();
            self.stage = ServoFitStage::Model;
            self.begin_start(motion);
            return false;
        }
        if let Some(trial) = self.end_pass() {
            self.begin_pass(motion, trial);
            return false;
        }
        let this = self.descent.best().copied();
        if self.taken < motion.len()
            && let Some(this) = this
        {
            self.taken = self.taken.saturating_mul(2);
            self.descent = Descent::begin(&Self::DESCENT);
            self.begin_pass(motion, this.unknowns);
            return false;
        }
        if let Some(this) = this
            && this.is_better_than(self.best.as_ref())
        {
            self.best = Some(this);
        }
        self.starts += 1;
        let explained = self.best.is_some_and(|best| {
            let pieces = motion.len() as f64;
            best.equations.cost().to_f64() < Self::EXPLAINED * ROUNDING * pieces
        });
        if explained || self.starts as usize >= Self::LADDER.len() {
            return true;
        }
        self.begin_start(motion);
        false
    }

    fn begin_start<const W: usize>(&mut self, motion: &MotionRecord<N, W>) {
        let factor = Self::LADDER.get(self.starts as usize).copied();
        let mut trial = self.first;
        let [gain, friction, delay] = factor.unwrap_or([1.0, 1.0, 0.0]).map(N::from_f64);
        trial[B] = trial[B] * gain;
        trial[COULOMB] = trial[COULOMB] * friction;
        trial[DELAY] += delay;
        self.descent = Descent::begin(&Self::DESCENT);
        self.taken = self.few;
        self.begin_pass(motion, trial);
    }

    fn begin_pass<const W: usize>(&mut self, motion: &MotionRecord<N, W>, unknowns: [N; UNKNOWNS]) {
        let [low, high] = &self.bounds;
        let trial = core::array::from_fn(|i| unknowns[i].limited(low[i], high[i]));
        self.pass = Some(ServoFitPass::at(&trial, &self.prior, motion));
        self.next = 0;
    }

    /// The unknowns of the next pass; none if this one was the last from this start.
    fn end_pass(&mut self) -> Option<[N; UNKNOWNS]> {
        let pass = self.pass.take()?;
        let pass = Explanation {
            unknowns: pass.unknowns,
            equations: pass.equations,
            sums: pass.colour,
        };
        next_trial(&mut self.descent, &Self::DESCENT, pass, &self.bounds)
    }
}
