use super::prediction::PredictionPass;
use crate::fit::ROUNDING;
use crate::number::Number;

/// Finds position and velocity with which a record begins, for a servo that is known, from pass to pass.
///
/// The error depends on the position in a straight line, but with friction not on the velocity: where the
/// model sticks and turns depends on it. So a few velocities are tried, each with a Gauss–Newton step from
/// it, and the best is taken; the first, if it explains the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placing<N> {
    /// Standard deviation of the velocity, and the largest, counts per sample.
    deviation: N,
    fastest: N,
    /// Passes taken.
    passes: usize,
    explained: bool,
    best: Option<Placed<N>>,
}

/// Counts and counts per sample, and the remaining sum of squared errors.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Placed<N> {
    place: [N; 2],
    left: N,
}

impl<N: Number> Placing<N> {
    /// The velocities that are tried, in standard deviations.
    const STARTS: [f64; 5] = [0.0, 1.0, -1.0, 2.5, -2.5];

    /// A motion is explained if the variance of the errors is below this many times the encoder's.
    const EXPLAINED: f64 = 1.5;

    /// Passes from each of them.
    const PASSES: usize = 3;

    pub(super) fn new(deviation: N, fastest: N) -> Self {
        Self {
            deviation,
            fastest,
            passes: 0,
            explained: false,
            best: None,
        }
    }

    /// True if the best has been found: a pass with it is the last.
    pub(super) fn is_done(&self) -> bool {
        self.explained || self.passes == Self::STARTS.len() * Self::PASSES
    }

    /// Judges a pass with this position and velocity over a number of pieces; returns those of the next.
    pub(super) fn next(
        &mut self,
        pass: &PredictionPass<N>,
        pieces: usize,
        place: [N; 2],
    ) -> [N; 2] {
        let [position, velocity] = place;
        let left = pass.left_by_position();
        let here = Placed {
            place: [position + pass.step_of_position(), velocity],
            left,
        };
        if self.best.is_none_or(|best| left < best.left) {
            self.best = Some(here);
        }
        self.passes += 1;
        self.explained = left.to_f64() < Self::EXPLAINED * ROUNDING * pieces as f64;
        if self.is_done() {
            return self.best.map_or(here.place, |best| best.place);
        }
        match Self::STARTS.get(self.passes / Self::PASSES) {
            Some(&start) if self.passes.is_multiple_of(Self::PASSES) => {
                [N::ZERO, N::from_f64(start) * self.deviation]
            }
            _ => {
                let [along, faster] = pass.placed();
                let velocity = velocity + faster;
                [
                    position + along,
                    velocity.limited(-self.fastest, self.fastest),
                ]
            }
        }
    }
}
