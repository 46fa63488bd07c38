use super::super::rough_model::RoughModel;
use identifier_core::number::Number;

/// Velocity and unexplained acceleration of the servo from its counts and the command that acted.
///
/// It predicts with the rough model's acceleration and a remainder. It corrects position, velocity and remainder by
/// the error of the prediction. All three errors thus decay as pᵏ. Before the servo is identified, the remainder is
/// its whole acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Observer<N> {
    gains: [N; 3],
}

/// State of the observer, counts and samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ObserverState<N> {
    error: N,
    /// Velocity at the sample.
    pub(super) velocity: N,
    rest: N,
    /// Acceleration over the last sample.
    pub(super) acceleration: N,
}

impl<N: Number> ObserverState<N> {
    /// For a servo that has fallen this far in this time from rest, q = w t²/2.
    pub(super) fn falling(fallen: N, time: N) -> Self {
        let mean = fallen * time.reciprocal();
        let velocity = mean + mean;
        let acceleration = velocity * time.reciprocal();
        Self {
            velocity,
            rest: acceleration,
            acceleration,
            ..Self::default()
        }
    }

    /// The servo is at standstill.
    pub(super) fn stand(&mut self) {
        *self = Self::default();
    }

    /// Counts show that it no longer moves in the estimated direction.
    pub(super) fn turn(&mut self) {
        self.velocity = N::ZERO;
    }

    /// The rough model has changed: the acceleration stays.
    pub(super) fn adopt(&mut self, before: &RoughModel<N>, after: &RoughModel<N>, command: N) {
        let velocity = self.velocity;
        self.rest += before.acceleration(command, velocity) - after.acceleration(command, velocity);
    }
}

impl<N: Number> Observer<N> {
    /// With p = e^(−ω T): the α–β–γ filter with a triple pole.
    pub(super) fn new(omega: f64) -> Self {
        let pole = libm::exp(-omega);
        let off = 1.0 - pole;
        let gains = [
            1.0 - pole * pole * pole,
            1.5 * off * off * (1.0 + pole),
            off * off * off,
        ];
        Self {
            gains: gains.map(N::from_f64),
        }
    }

    /// Takes a sample: how far the servo moved under the command that acted.
    #[inline]
    pub(super) fn observe(
        &self,
        observed: &mut ObserverState<N>,
        servo: &RoughModel<N>,
        increment: N,
        acted: N,
    ) {
        let acceleration = servo.acceleration(acted, observed.velocity) + observed.rest;
        let motion_direction = observed.velocity + N::from_f64(0.5) * acceleration;
        observed.error += increment - motion_direction;
        let [position, velocity, rest] = self.gains;
        observed.velocity += acceleration + velocity * observed.error;
        observed.rest += rest * observed.error;
        observed.error = observed.error - position * observed.error;
        observed.acceleration = acceleration;
    }
}
