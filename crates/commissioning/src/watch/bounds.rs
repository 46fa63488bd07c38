//! Travel, speed and time.

use super::WatchSettings;
use identifier_core::number::Number;
use identifier_core::reason::Reason;
use identifier_core::units::Units;

/// Bounds of position, speed and time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds<N> {
    /// Counts.
    travel: [N; 2],
    /// Counts a sample.
    speed: N,
    /// Forgetting factor of the mean speed, per sample.
    forgetting: N,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct BoundsState<N> {
    /// Mean of the increments, counts a sample.
    pub(super) speed: N,
    late: LateSamples,
}

/// The judgement of late samples: successive ones, or more than a fifth of all, become too many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LateSamples(u32);

impl LateSamples {
    /// By so much a late sample raises the count, while one in time lowers it by one.
    const WEIGHT: u32 = 4;

    /// Takes in whether a sample ended too late.
    ///
    /// # Errors
    /// [`Reason::Overrun`] at this number of successive late samples, at least one. For three also at seven of which
    /// every other one is late.
    #[inline]
    pub fn take(&mut self, late: bool, most: u32) -> Result<(), Reason> {
        if !late {
            self.0 = self.0.saturating_sub(1);
            return Ok(());
        }
        self.0 = self.0.saturating_add(Self::WEIGHT);
        if self.0 >= most.saturating_mul(Self::WEIGHT) {
            return Err(Reason::Overrun);
        }
        Ok(())
    }
}

impl<N: Number> Bounds<N> {
    /// Late samples running that are too many.
    pub(super) const MAX_LATE_SAMPLES: u32 = 3;
    /// The mean over this time, s, is the speed where the encoder resolves it,
    const FINE_MEAN_TIME: f64 = 2e-3;
    /// and over this one where it does not.
    const COARSE_MEAN_TIME: f64 = 20e-3;
    /// The share of the speed that a count makes up where the encoder resolves it.
    const RESOLVED_SHARE: f64 = 0.05;

    pub(super) fn new(settings: &WatchSettings, units: &Units) -> Self {
        let travel = settings.travel.map(|end| end * units.position());
        let speed = settings.speed * units.velocity();
        let over = |time: f64| -libm::expm1(-units.sample_time() / time);
        let forgetting = (Self::RESOLVED_SHARE * speed)
            .min(over(Self::FINE_MEAN_TIME))
            .max(over(Self::COARSE_MEAN_TIME));
        // A count is passed up to one before it shows.
        Self {
            travel: [N::from_f64(travel[0] - 1.0), N::from_f64(travel[1] + 1.0)],
            speed: N::from_f64(speed + forgetting),
            forgetting: N::from_f64(forgetting),
        }
    }

    pub(super) fn start(&self) -> BoundsState<N> {
        BoundsState {
            speed: N::ZERO,
            late: LateSamples::default(),
        }
    }

    /// Samples until a speed of 1.25 of the allowed one, and three counts in the time of the mean beyond
    /// that, is seen.
    #[cfg(test)]
    pub(super) fn samples_until_too_fast(&self) -> f64 {
        /// The part of a speed step that its mean still lacks when the rest is beyond the bound.
        const REMAINDER: f64 = 0.2;
        libm::log(REMAINDER) / libm::log1p(-self.forgetting.to_f64().min(0.999))
    }

    pub(super) fn time(&self, state: &mut BoundsState<N>, late: bool) -> Result<(), Reason> {
        state.late.take(late, Self::MAX_LATE_SAMPLES)
    }

    pub(super) fn motion(
        &self,
        state: &mut BoundsState<N>,
        increment: N,
        position: N,
    ) -> Result<(), Reason> {
        let [low, high] = self.travel;
        if position < low || position > high {
            return Err(Reason::TravelLeft);
        }
        state.speed += self.forgetting * (increment - state.speed);
        if state.speed.magnitude() > self.speed {
            return Err(Reason::SpeedExceeded);
        }
        Ok(())
    }
}
