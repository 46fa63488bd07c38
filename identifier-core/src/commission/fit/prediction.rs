use super::super::IdentifiedServo;
use super::follower::Follower;
use super::motion::MotionRecord;
use super::placing::Placing;
use super::prior::at_first;
use super::servo_fitter::ServoFitter;
use super::{POSITION, UNKNOWNS, VELOCITY};
use crate::fit::ROUNDING;
use crate::linalg::NormalEquations;
use crate::number::Number;

/// The errors of a known servo's prediction of a motion, only position and velocity at its beginning being fitted;
/// rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PredictionErrors {
    /// Root mean square and largest magnitude of the prediction's errors.
    pub rms: f64,
    /// See above.
    pub worst: f64,
    /// The standard deviation of the encoder's rounding.
    pub rounding: f64,
    /// Root mean square and largest standard error of the prediction that follow from those of the
    /// servo's parameters.
    pub uncertain: f64,
    /// See above.
    pub most_uncertain: f64,
    /// From the lowest to the highest position of the motion.
    pub range: f64,
}

impl PredictionErrors {
    /// The part of the motion's range that a model may lack: what it is tuned for bears more.
    pub(super) const SHARE: f64 = 0.005;

    /// Largest root mean square of the errors, and largest error, in standard deviations of rounding and
    /// of the parameters.
    pub(super) const ERRORS: f64 = 3.0;
    const WORST: f64 = 6.0;

    /// True if the servo that was identified is not the one that moved.
    pub(crate) fn refutes(&self) -> bool {
        let band = |times: f64, uncertain: f64| {
            let (rounding, unknown) = (times * self.rounding, times * uncertain);
            let share = Self::SHARE * times * self.range;
            libm::sqrt(rounding * rounding + unknown * unknown + share * share)
        };
        let within = self.rms <= band(Self::ERRORS, self.uncertain)
            && self.worst <= band(Self::WORST, self.most_uncertain);
        !within
    }
}

/// A prediction under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PredictionRun<N> {
    pub(super) unknowns: [N; UNKNOWNS],
    /// Covariance of the servo's parameters, machine units.
    pub(super) covariance: [[N; 5]; 5],
    pub(super) next: usize,
    pub(super) pass: Option<PredictionPass<N>>,
    /// Position and velocity at the beginning, which are fitted first; none before the first pass.
    pub(super) placing: Option<Placing<N>>,
}

/// A pass over the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PredictionPass<N> {
    pub(super) follower: Follower<N>,
    pub(super) equations: NormalEquations<N, UNKNOWNS>,
    pub(super) worst: N,
    pub(super) uncertain: N,
    pub(super) most_uncertain: N,
    pub(super) position: N,
    pub(super) range: [N; 2],
}

impl<N: Number> PredictionPass<N> {
    /// Takes a piece that the follower has passed.
    pub(super) fn measure(&mut self, covariance: &[[N; 5]; 5], travel: N) {
        let error = self.follower.error;
        let own = &self.follower.positions;
        self.equations.add(own, error);
        if error.magnitude() > self.worst {
            self.worst = error.magnitude();
        }
        let mut variance = N::ZERO;
        for i in 0..5 {
            for j in 0..5 {
                variance += covariance[i][j] * own[i] * own[j];
            }
        }
        if variance > N::ZERO {
            self.uncertain += variance;
            if variance > self.most_uncertain {
                self.most_uncertain = variance;
            }
        }
        self.position += travel;
        let [low, high] = &mut self.range;
        if self.position < *low {
            *low = self.position;
        }
        if self.position > *high {
            *high = self.position;
        }
    }

    /// The step of the position at the beginning alone that explains the errors best.
    pub(super) fn step_of_position(&self) -> N {
        let step = self.equations.solve(N::ZERO, &Self::only(POSITION));
        step[POSITION]
    }

    /// The squared errors that remain with it.
    pub(super) fn left_by_position(&self) -> N {
        let explained = self.equations.explained_by(&Self::only(POSITION));
        self.equations.cost() - explained
    }

    fn only(unknown: usize) -> [bool; UNKNOWNS] {
        core::array::from_fn(|i| i == unknown)
    }

    /// The step of position and velocity at the beginning that explains the errors best.
    pub(super) fn placed(&self) -> [N; 2] {
        let free = core::array::from_fn(|i| i == POSITION || i == VELOCITY);
        let step = self.equations.solve(N::ZERO, &free);
        [step[POSITION], step[VELOCITY]]
    }
}

impl<N: Number> ServoFitter<N> {
    /// Begins the prediction of a motion by a servo that is known.
    #[must_use]
    pub(crate) fn begin_prediction(&self, servo: &IdentifiedServo) -> PredictionRun<N> {
        let scale = self.scale();
        PredictionRun {
            unknowns: self.unknowns(servo),
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| N::from_f64(servo.covariance[i][j] * scale[i] * scale[j]))
            }),
            next: 0,
            pass: None,
            placing: None,
        }
    }

    /// Continues by a piece of the record. Returns once it has ended.
    pub(crate) fn predict<const W: usize>(
        &self,
        predicting: &mut PredictionRun<N>,
        motion: &MotionRecord<N, W>,
    ) -> Option<PredictionErrors> {
        let pass = match &mut predicting.pass {
            Some(pass) => pass,
            empty => empty.insert(self.begin_pass(&predicting.unknowns, motion)),
        };
        if let Some(piece) = motion.get(predicting.next) {
            pass.follower.advance(&self.step, motion, predicting.next);
            pass.measure(&predicting.covariance, piece.travel);
            predicting.next += 1;
            return None;
        }
        let deviation = self.speed_at_first(motion, true);
        let fastest = Self::FASTEST_AT_FIRST * deviation;
        let placing = predicting
            .placing
            .get_or_insert_with(|| Placing::new(N::from_f64(deviation), N::from_f64(fastest)));
        if placing.is_done() {
            return Some(self.prediction(pass, motion.len()));
        }
        let unknowns = &mut predicting.unknowns;
        [unknowns[POSITION], unknowns[VELOCITY]] =
            placing.next(pass, motion.len(), [unknowns[POSITION], unknowns[VELOCITY]]);
        predicting.pass = None;
        predicting.next = 0;
        None
    }

    fn begin_pass<const W: usize>(
        &self,
        unknowns: &[N; UNKNOWNS],
        motion: &MotionRecord<N, W>,
    ) -> PredictionPass<N> {
        // A model that friction holds at first shows nothing of its initial velocity.
        let mut equations = NormalEquations::EMPTY;
        for (place, weight) in at_first(self.speed_at_first(motion, true)) {
            if let Some(&value) = unknowns.get(place) {
                equations.expect(place, N::from_f64(weight), -value);
            }
        }
        PredictionPass {
            follower: Follower::new(unknowns, motion),
            equations,
            worst: N::ZERO,
            uncertain: N::ZERO,
            most_uncertain: N::ZERO,
            position: N::ZERO,
            range: [N::ZERO; 2],
        }
    }

    fn prediction(&self, pass: &PredictionPass<N>, pieces: usize) -> PredictionErrors {
        let resolution = self.resolution();
        let mean_root = |sum: N| libm::sqrt(sum.to_f64() / pieces.max(1) as f64);
        let [low, high] = pass.range;
        PredictionErrors {
            rms: mean_root(pass.equations.cost()) * resolution,
            worst: pass.worst.to_f64() * resolution,
            rounding: libm::sqrt(ROUNDING) * resolution,
            uncertain: mean_root(pass.uncertain) * resolution,
            most_uncertain: libm::sqrt(pass.most_uncertain.to_f64()) * resolution,
            range: (high - low).to_f64() * resolution,
        }
    }
}
