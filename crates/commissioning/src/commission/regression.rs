use super::rough_model::RoughModel;
use identifier_core::number::Number;
use identifier_core::replay::NormalEquations;

/// A linear least-squares estimate of the servo while it moves, without a first guess.
///
/// Behind the filter 1/(p + λ)² the equation of motion is linear in [b, d − c, d + c, a, b δ]. The delay beyond the
/// assumed one is δ. Its error is the encoder's rounding: white, in counts. Literature on the equation error: Young,
/// Recursive Estimation and Time-Series Analysis, 2nd edition 2011, chapter 8.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Regression<N> {
    gains: [N; 2],
    /// Samples from one equation to the next.
    stride: u32,
}

/// The filters' states and the normal equations.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct RegressionState<N> {
    error: N,
    error_velocity: N,
    position: [N; ROW],
    velocity: [N; ROW],
    equations: NormalEquations<N, ROW>,
    /// The command that acted before.
    before: N,
    due: u32,
}

const GAIN: usize = 0;
const FORWARD: usize = 1;
const BACKWARD: usize = 2;
const VISCOUS: usize = 3;
/// b times the delay beyond the assumed one.
const LATE: usize = 4;
/// Unknowns of a row.
pub(crate) const ROW: usize = 5;

impl<N: Number> RegressionState<N> {
    /// Prior knowledge: a row as a measurement of standard deviation one rounding.
    pub(crate) fn expect(&mut self, row: &[N; ROW], value: N) {
        self.equations.add(row, value);
    }

    /// Clears the normal equations; the filters' states stay.
    pub(crate) fn forget(&mut self) {
        self.equations = NormalEquations::default();
    }

    /// The variances of the accelerations that it predicts under commands, for errors of variance one. The velocities
    /// are in their direction.
    pub(crate) fn variances(&self, accelerated: &[(N, N); 2]) -> [N; 2] {
        self.equations
            .variances(&accelerated.map(|(command, velocity)| {
                let mut row = [N::ZERO; ROW];
                row[GAIN] = command;
                row[if velocity > N::ZERO {
                    FORWARD
                } else {
                    BACKWARD
                }] = N::ONE;
                row[VISCOUS] = -velocity;
                row
            }))
    }

    /// The present estimate, if it is plausible.
    pub(crate) fn estimate(&self) -> Option<RoughModel<N>> {
        let free = [true; ROW];
        let found = self.equations.solve(N::ZERO, &free);
        let gain = found[GAIN];
        let sound = found.iter().all(|value| value.is_finite()) && gain > N::ZERO;
        // Friction is no drive.
        let (mut forward, mut backward) = (found[FORWARD], found[BACKWARD]);
        if backward < forward {
            let load = N::from_f64(0.5) * (forward + backward);
            (forward, backward) = (load, load);
        }
        sound.then(|| RoughModel {
            gain,
            per_gain: gain.reciprocal(),
            forward,
            backward,
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

    /// True if there is an equation in every sample.
    pub(crate) fn is_dense(&self) -> bool {
        self.stride == 1
    }

    /// Takes a sample: the distance and the direction of the motion (zero at standstill), and the command that acted.
    /// True if there is a new equation.
    #[inline]
    pub(crate) fn observe(
        &self,
        gathered: &mut RegressionState<N>,
        increment: N,
        direction: N,
        acted: N,
    ) -> bool {
        self.observe_for(N::ONE, gathered, increment, direction, acted)
    }

    /// The same over a time, samples.
    #[inline]
    pub(crate) fn observe_for(
        &self,
        time: N,
        gathered: &mut RegressionState<N>,
        increment: N,
        direction: N,
        acted: N,
    ) -> bool {
        let half = N::from_f64(0.5);
        let [follow, pull] = self.gains;
        let (follow, pull) = (follow * time, pull * time);
        let drive = pull * gathered.error;
        let before = gathered.error_velocity;
        let motion_direction = (before + half * drive) * time;
        gathered.error += increment - follow * gathered.error - motion_direction;
        gathered.error_velocity = before + drive;
        let mut own = [N::ZERO; ROW];
        if direction != N::ZERO {
            own[GAIN] = acted * time;
            own[if direction > N::ZERO {
                FORWARD
            } else {
                BACKWARD
            }] = time;
        }
        own[VISCOUS] = -increment;
        if direction != N::ZERO {
            own[LATE] = gathered.before - acted;
        }
        gathered.before = acted;
        for i in 0..ROW {
            let position = gathered.position[i];
            let velocity = gathered.velocity[i];
            let change = own[i] - pull * position;
            let motion_direction = (velocity + half * change) * time;
            gathered.position[i] = position - follow * position + motion_direction;
            gathered.velocity[i] = velocity + change;
        }
        gathered.due += 1;
        if gathered.due < self.stride {
            return false;
        }
        gathered.due = 0;
        if direction == N::ZERO {
            return false;
        }
        gathered.equations.add(&gathered.position, gathered.error);
        true
    }
}
