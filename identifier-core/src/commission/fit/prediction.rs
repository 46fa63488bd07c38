use super::follower::Follower;
use super::placing::Placing;
use super::{POSITION, UNKNOWNS, VELOCITY};
use crate::linalg::NormalEquations;
use crate::number::Number;

/// How well a known servo predicts a motion, only position and velocity at its beginning being fitted;
/// rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
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

/// A prediction under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictionPass<N> {
    pub(super) unknowns: [N; UNKNOWNS],
    /// Covariance of the servo's parameters, machine units.
    pub(super) covariance: [[N; 5]; 5],
    pub(super) next: usize,
    pub(super) pass: Option<Pass<N>>,
    /// Position and velocity at the beginning, which are fitted first; none before the first pass.
    pub(super) placing: Option<Placing<N>>,
}

/// A pass over the record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pass<N> {
    pub(super) follower: Follower<N>,
    pub(super) equations: NormalEquations<N, UNKNOWNS>,
    pub(super) worst: N,
    pub(super) uncertain: N,
    pub(super) most_uncertain: N,
    pub(super) position: N,
    pub(super) range: [N; 2],
}

impl<N: Number> Pass<N> {
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

    /// What is left of the squared errors with that.
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
