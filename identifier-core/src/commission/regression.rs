use super::crude::Crude;
use crate::adaptation::NormalEquations;
use crate::number::Number;

/// A linear least-squares estimate of the servo while it moves, without a first guess.
///
/// Behind the filter 1/(p + λ)² the equation of motion is linear in [b, d − c, d + c, a], and its error is
/// the encoder's rounding: white, in counts (equation error; Young, Recursive Estimation and Time-Series
/// Analysis, 2nd edition 2011, chapter 8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Regression<N> {
    gains: [N; 2],
    /// Samples from one equation to the next.
    stride: u32,
}

/// The filters' states and what was gathered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gathered<N> {
    error: N,
    error_velocity: N,
    position: [N; 4],
    velocity: [N; 4],
    equations: NormalEquations<N, 4>,
    due: u32,
}

const GAIN: usize = 0;
const FORWARD: usize = 1;
const BACKWARD: usize = 2;
const VISCOUS: usize = 3;

impl<N: Number> Gathered<N> {
    pub(crate) const NOTHING: Self = Self {
        error: N::ZERO,
        error_velocity: N::ZERO,
        position: [N::ZERO; 4],
        velocity: [N::ZERO; 4],
        equations: NormalEquations::EMPTY,
        due: 0,
    };

    /// What is known before: a row as a measurement of standard deviation one rounding.
    pub(crate) fn expect(&mut self, row: &[N; 4], value: N) {
        self.equations.add(row, value);
    }

    /// The estimate as it is now, where it makes sense.
    pub(crate) fn estimate(&self) -> Option<Crude<N>> {
        let free = [true; 4];
        let found = self.equations.solve(N::ZERO, &free);
        let gain = found[GAIN];
        let sound = found.iter().all(|value| value.is_finite()) && gain > N::ZERO;
        sound.then(|| Crude {
            gain,
            per_gain: gain.reciprocal(),
            forward: found[FORWARD],
            backward: found[BACKWARD],
            viscous: found[VISCOUS].limited(N::ZERO, N::ONE),
        })
    }
}

impl<N: Number> Regression<N> {
    /// With a filter of both poles at λ T, and an equation every `stride` samples.
    pub(crate) fn new(lambda: f64, stride: u32) -> Self {
        Self {
            gains: [2.0 * lambda, lambda * lambda].map(N::from_f64),
            stride: stride.max(1),
        }
    }

    /// Takes a sample: how far the servo moved, in which direction (zero: it stood), under the command
    /// that acted. True if there is a new equation.
    #[inline]
    pub(crate) fn observe(
        &self,
        gathered: &mut Gathered<N>,
        increment: N,
        direction: N,
        acted: N,
    ) -> bool {
        let half = N::from_f64(0.5);
        let [follow, pull] = self.gains;
        let drive = pull * gathered.error;
        let before = gathered.error_velocity;
        gathered.error += increment - follow * gathered.error - before - half * drive;
        gathered.error_velocity = before + drive;
        let mut own = [N::ZERO; 4];
        if direction != N::ZERO {
            own[GAIN] = acted;
            if direction > N::ZERO {
                own[FORWARD] = N::ONE;
            } else {
                own[BACKWARD] = N::ONE;
            }
        }
        own[VISCOUS] = -increment;
        for i in 0..4 {
            let position = gathered.position[i];
            let velocity = gathered.velocity[i];
            let change = own[i] - pull * position;
            gathered.position[i] = position - follow * position + velocity + half * change;
            gathered.velocity[i] = velocity + change;
        }
        gathered.due += 1;
        if gathered.due < self.stride {
            return false;
        }
        gathered.due = 0;
        gathered.equations.add(&gathered.position, gathered.error);
        true
    }
}
