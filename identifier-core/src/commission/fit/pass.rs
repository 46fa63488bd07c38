use super::follower::Follower;
use super::motion::MotionRecord;
use super::prior::ServoPrior;
use super::{B, UNKNOWNS};
use crate::fit::colour::Colour;
use crate::fit::levenberg_marquardt::{Descent, DescentSettings, Explanation};
use crate::linalg::NormalEquations;
use crate::model::FrictionStep;
use crate::number::Number;

/// A pass over the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ServoFitPass<N> {
    pub(super) unknowns: [N; UNKNOWNS],
    follower: Follower<N>,
    pub(super) equations: NormalEquations<N, UNKNOWNS>,
    pub(super) colour: Colour<N>,
}

/// The unknowns that explain the motion best.
pub(super) type BestServoFit<N> = Explanation<N, UNKNOWNS, Colour<N>>;

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
            colour: Colour::NONE,
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
        self.colour.add(error);
    }
}

/// The unknowns of the next pass of a descent within bounds; none if this one was the last.
pub(super) fn next_trial<N: Number, const Q: usize, T: Copy>(
    descent: &mut Descent<N, Q, T>,
    settings: &DescentSettings,
    pass: Explanation<N, Q, T>,
    [low, high]: &[[N; Q]; 2],
) -> Option<[N; Q]> {
    let mut next = descent.descend(settings, pass, [true; Q], [low, high])?;
    // A gain does not change its sign, nor its size at once.
    let gain = descent.best()?.unknowns[B];
    let [half, three] = [0.5, 3.0].map(N::from_f64);
    next[B] = next[B].limited(half * gain, three * gain);
    Some(next)
}
