use crate::model::Innovation;
use crate::number::Number;

/// The gain of the Kalman filter that keeps the model with the record, from block to block.
///
/// The states are position and velocity, which are unknown before the first block. A white acceleration disturbs the
/// velocity. It is so small that the memory of the filter, the *horizon*, is N blocks. L is N⁻⁴ over the variance of
/// the measured position. That variance is unknown, and all others are in units of it. The innovations have the
/// variance S times it (Mehra, "On the identification of variances and adaptive Kalman filtering", IEEE Transactions
/// on Automatic Control 15(2), 1970).
///
/// The determinant of the covariance is a state, as the difference that gives it loses it in single precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct KalmanGain<N> {
    position: N,
    cross: N,
    velocity: N,
    determinant: N,
    disturbance: N,
    /// Blocks so far, until the gain counts as constant.
    blocks: u32,
    settled: u32,
    /// 1/√S.
    pub(super) weight: N,
    /// The correction of the model.
    pub(super) innovation: Innovation<N>,
    /// The immediate change of its velocity, per innovation. It acts after the first block, which shows the velocity.
    /// Friction must not hold the model against it.
    pub(super) jump: N,
}

impl<N: Number> KalmanGain<N> {
    /// The gain is constant after this multiple of the horizon.
    const SETTLED: f64 = 5.0;

    /// Before the first block, at the first measured position; the velocity has a variance.
    pub(super) fn begin(horizon: N, velocity: N) -> Self {
        let per_horizon = horizon.reciprocal();
        let square = per_horizon * per_horizon;
        let mut gain = Self {
            position: N::ONE,
            cross: N::ZERO,
            velocity,
            determinant: velocity,
            disturbance: square * square,
            blocks: 0,
            settled: (horizon * N::from_f64(Self::SETTLED))
                .whole()
                .unsigned_abs(),
            weight: N::ONE,
            innovation: Innovation {
                position: N::ZERO,
                velocity: N::ZERO,
            },
            jump: N::ZERO,
        };
        gain.predict();
        gain
    }

    /// Takes in a block: the gain and the weight of its innovation.
    #[inline]
    pub(super) fn advance(&mut self) {
        if self.blocks >= self.settled {
            return;
        }
        let scale = self.position + N::ONE;
        let per_scale = scale.reciprocal();
        let position = self.position * per_scale;
        let velocity = self.cross * per_scale;
        self.weight = scale.reciprocal_root();
        self.blocks += 1;
        if self.blocks == 1 {
            self.jump = velocity;
            self.innovation.position = position;
        } else {
            self.jump = N::ZERO;
            // The correction of the velocity acts as an acceleration throughout the next block.
            self.innovation = Innovation {
                position: position + N::from_f64(0.5) * velocity,
                velocity,
            };
        }
        self.velocity = (self.velocity + self.determinant) * per_scale;
        self.determinant = self.determinant * per_scale;
        self.position = position;
        self.cross = velocity;
        self.predict();
    }

    /// Friction holds the model, so that its velocity is known.
    pub(super) fn stand(&mut self) {
        (self.cross, self.velocity, self.determinant) = (N::ZERO, N::ZERO, N::ZERO);
    }

    /// The covariance a block later.
    #[inline]
    fn predict(&mut self) {
        let [third, half, twelfth] = [1.0 / 3.0, 0.5, 1.0 / 12.0].map(N::from_f64);
        let disturbance = self.disturbance;
        let cross = self.cross + self.velocity;
        let position = self.position + self.cross + cross;
        self.determinant += disturbance * (third * self.velocity + position - cross)
            + disturbance * disturbance * twelfth;
        self.position = position + third * disturbance;
        self.cross = cross + half * disturbance;
        self.velocity += disturbance;
    }
}
