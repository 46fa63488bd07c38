//! Feed-forward of a reference model's motion.

#[cfg(test)]
mod tests;

use super::Gains;
use crate::constants::{Encode, encode};
use crate::error::{Allowed, OutOfRange};
use crate::measurement::velocity::Transfer;
use crate::number::Arithmetic;
use crate::units::Units;

/// Feed-forward of a reference model's motion, SI: u = (ÿ + a ẏ + c s(ẏ))/b, y = r/(1 + s/ω_m)³. Laid out as C does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct FeedForwardSettings {
    /// ω_m of the reference model's three poles, rad/s: from 10⁻⁵ to 1 per sample.
    pub bandwidth: f64,
    /// 1/b, command units per rad/s², at least 0.
    pub acceleration: f64,
    /// a/b, command units per rad/s, at least 0.
    pub velocity: f64,
    /// c/b, command units, at least 0.
    pub coulomb: f64,
    /// The speed below which s goes linearly through zero, rad/s, at least 10⁻⁶ position units per sample.
    pub coulomb_speed: f64,
}

/// A reference model of third order, y = r/(1 + s/ω_m)³, and the command that moves a servo along it.
///
/// The reference r is held over a sample. The model has three stages in series. Their lags x₁ = r − y₁, x₂ = y₁ − y₂
/// and x₃ = y₂ − y are kept. Their motion over a sample is exact, with h = ω_m T and E = e^(−h):
///
/// x₁ ← E x₁, x₂ ← E (x₂ + h x₁), x₃ ← E (x₃ + h x₂ + h²/2 x₁)
///
/// and y = r − x₁ − x₂ − x₃, ẏ = ω_m x₃. The lags decay, and r enters only as a distance from the position. So no
/// rounding adds up, counts may wrap, and y ends at r.
///
/// A command is held until the next sample. So the feed-forward is that of the mean acceleration and velocity until
/// then. The servo's q̇ + a q follows ẏ + a y exactly. Its q follows y to (ω_m T)²/12 of its acceleration over ω_m².
/// The last part of the feed-forward compensates the derivative, which acts on the measured velocity alone and would
/// brake. It is k_d ẏ as the controller's velocity estimate will show it. The default has no model, and gives no command.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FeedForward<N> {
    /// E; zero for none.
    pole: N,
    /// h.
    rate: N,
    /// h²/2.
    half_square: N,
    acceleration: N,
    velocity: N,
    coulomb: N,
    /// One over the speed from which friction is compensated in full.
    per_coulomb_speed: N,
}

encode! {
    [N: Encode] FeedForward<N> as "FeedForward" {
        pole, rate, half_square, acceleration, velocity, coulomb, per_coulomb_speed,
    }
}

/// State of a [`FeedForward`], machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ReferenceMotion<N> {
    /// The error r − q of the last sample.
    error: N,
    lags: [N; 3],
}

/// The motion of a reference model from a sample to the next, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MovingReference<N> {
    /// y − q in the sample.
    distance: N,
    /// The means of ẏ and ÿ until the next.
    velocity: N,
    acceleration: N,
}

impl<N: Arithmetic> FeedForward<N> {
    /// The range of ω_m T. Below it single precision does not keep E; above it the model is as fast as the sampling.
    const RATES: [f64; 2] = [1e-5, 1.0];

    /// The least `coulomb_speed`, position units per sample.
    const MIN_COULOMB_SPEED: f64 = 1e-6;

    /// The feed-forward of a controller with these gains and this estimate of the velocity.
    ///
    /// # Errors
    /// The setting that is out of its range, by name: `feed_forward.bandwidth`, `feed_forward.acceleration`,
    /// `feed_forward.velocity`, `feed_forward.coulomb` or `feed_forward.coulomb_speed`.
    pub fn new(
        units: &Units,
        settings: &FeedForwardSettings,
        gains: &Gains,
        velocity: &Transfer,
    ) -> Result<Self, OutOfRange> {
        const GAIN: Allowed = Allowed::Within(0.0, Gains::LARGEST);
        let [low, high] = Self::RATES.map(|rate| rate / units.rate());
        Allowed::Within(low, high).check("feed_forward.bandwidth", settings.bandwidth)?;
        GAIN.check("feed_forward.acceleration", settings.acceleration)?;
        GAIN.check("feed_forward.velocity", settings.velocity)?;
        GAIN.check("feed_forward.coulomb", settings.coulomb)?;
        let slowest = Self::MIN_COULOMB_SPEED / units.velocity();
        Allowed::AtLeast(slowest).check("feed_forward.coulomb_speed", settings.coulomb_speed)?;
        let rate = settings.bandwidth * units.rate();
        let [of_acceleration, of_velocity] = braking(units, gains, velocity);
        let acceleration = settings.acceleration + of_acceleration;
        let velocity = settings.velocity + of_velocity;
        Ok(Self {
            pole: N::signal(libm::exp(-rate), 0),
            rate: N::signal(rate, 0),
            half_square: N::signal(0.5 * rate * rate, 0),
            acceleration: N::signal(acceleration / units.acceleration(), 0),
            velocity: N::signal(velocity / units.velocity(), 0),
            coulomb: N::signal(settings.coulomb, 0),
            per_coulomb_speed: N::signal(1.0 / (settings.coulomb_speed * units.velocity()), 0),
        })
    }

    /// Moves the model on by a sample.
    #[inline]
    fn advance(
        &self,
        state: &mut ReferenceMotion<N>,
        error: N,
        increment: N,
    ) -> MovingReference<N> {
        let [first, second, third] = state.lags;
        let first = first + (error - (state.error - increment));
        let lag = first + second + third;
        let next = [
            first.part(self.pole),
            (second + first.part(self.rate)).part(self.pole),
            (third + second.part(self.rate) + first.part(self.half_square)).part(self.pole),
        ];
        let [next_first, next_second, next_third] = next;
        *state = ReferenceMotion { error, lags: next };
        MovingReference {
            distance: error - lag,
            velocity: (first - next_first) + (second - next_second) + (third - next_third),
            acceleration: (next_third - third).part(self.rate),
        }
    }

    /// The command for a motion.
    #[inline]
    fn command(&self, moving: &MovingReference<N>) -> N {
        let sign = moving.velocity.part(self.per_coulomb_speed);
        let sign = sign.bounded(-N::ONE, N::ONE);
        moving.acceleration.part(self.acceleration)
            + moving.velocity.part(self.velocity)
            + sign.part(self.coulomb)
    }

    /// A function of its own, for a sample without a model not to pay for its registers.
    #[inline(never)]
    fn follow(&self, state: &mut ReferenceMotion<N>, error: N, increment: N) -> (N, N) {
        let moving = self.advance(state, error, increment);
        (moving.distance, self.command(&moving))
    }

    /// True if there is a model.
    #[inline]
    pub(crate) fn is_there(&self) -> bool {
        self.pole > N::ZERO
    }

    /// The model at rest, at this distance from the servo.
    pub(crate) fn at_rest(error: N) -> ReferenceMotion<N> {
        ReferenceMotion {
            error,
            lags: [N::ZERO; 3],
        }
    }

    /// Takes the error r − q of a sample and the increment of q since the last one, machine units. Returns y − q,
    /// machine units, and the command that is added to the PID's.
    #[inline]
    pub(crate) fn process(
        &self,
        motion: &mut ReferenceMotion<N>,
        error: N,
        increment: N,
    ) -> (N, N) {
        if self.is_there() {
            self.follow(motion, error, increment)
        } else {
            // What is added changes no bit of a command.
            (error, -N::ZERO)
        }
    }
}

/// The commands per acceleration and velocity, SI, by which a derivative on the measured velocity would brake a motion.
/// The time runs from the middle of a hold back to the time of the velocity estimate.
fn braking(units: &Units, gains: &Gains, velocity: &Transfer) -> [f64; 2] {
    let lag = (1.0 + velocity.lag()) * units.sample_time();
    [-gains.kd() * lag, gains.kd()]
}
