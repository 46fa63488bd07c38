use super::follower::Follower;
use super::motion::MotionRecord;
use super::prior::ServoPrior;
use super::{B, UNKNOWNS};
use crate::fit::levenberg_marquardt::{bounded_step, moved};
use crate::linalg::NormalEquations;
use crate::model::FrictionStep;
use crate::number::Number;

/// A pass over the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ServoFitPass<N> {
    pub(super) unknowns: [N; UNKNOWNS],
    follower: Follower<N>,
    pub(super) equations: NormalEquations<N, UNKNOWNS>,
    last_error: N,
    pub(super) lag_one: N,
}

/// The unknowns that explain the motion best so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BestServoFit<N> {
    pub(super) unknowns: [N; UNKNOWNS],
    pub(super) equations: NormalEquations<N, UNKNOWNS>,
    pub(super) lag_one: N,
}

impl<N: Number> ServoFitPass<N> {
    /// With these unknowns and prior knowledge.
    pub(super) fn at<const W: usize>(
        unknowns: &[N; UNKNOWNS],
        prior: &ServoPrior<N>,
        motion: &MotionRecord<N, W>,
    ) -> Self {
        let mut equations = NormalEquations::EMPTY;
        prior.add_to(&mut equations, unknowns);
        Self {
            unknowns: *unknowns,
            follower: Follower::new(unknowns, motion),
            equations,
            last_error: N::ZERO,
            lag_one: N::ZERO,
        }
    }

    /// Takes a piece of the record.
    pub(super) fn take<const W: usize>(
        &mut self,
        step: &FrictionStep<N>,
        motion: &MotionRecord<N, W>,
        index: usize,
    ) {
        self.follower.advance(step, motion, index);
        let error = self.follower.error;
        self.equations.add(&self.follower.positions, error);
        self.lag_one += error * self.last_error;
        self.last_error = error;
    }
}

/// Where a damped step from unknowns within bounds leads.
pub(super) fn next_trial<N: Number, const Q: usize>(
    equations: &NormalEquations<N, Q>,
    unknowns: &[N; Q],
    damping: N,
    [low, high]: &[[N; Q]; 2],
) -> [N; Q] {
    let mut step = bounded_step(equations, unknowns, damping, [true; Q], low, high);
    // A gain does not change its sign, nor its size at once.
    let gain = unknowns[B];
    let half = N::from_f64(0.5);
    step[B] = step[B].limited(-(half * gain), gain + gain);
    moved(unknowns, &step)
}
