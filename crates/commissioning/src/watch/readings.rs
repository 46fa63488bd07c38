//! Detection of readings that the encoder cannot have.

use super::WatchSettings;
use super::model::Model;
use identifier_core::number::Number;
use identifier_core::reason::Reason;
use identifier_core::units::Units;

/// Bounds of readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Readings<N> {
    /// Counts that no sample may have.
    farthest: N,
    /// Samples without a reading that are too many.
    pub(super) lost_after: i32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ReadingsState<N> {
    last: Option<N>,
    /// Samples running without a reading.
    missing: i32,
    /// By how many counts an increment may differ from the one before.
    change: N,
    /// By how many counts it last did: the most, halved with every reading since.
    half_cycle: N,
}

impl<N: Number> Readings<N> {
    /// The longest time without a reading, s.
    const MAX_GAP: f64 = 1e-3;
    /// The fewest samples without a reading that are too many.
    const MIN_MISSING: f64 = 2.0;
    /// The factor on the allowed speed beyond which a reading is invalid.
    const SPEED_MARGIN: f64 = 2.0;
    /// The part of that which a servo that moves has on the average already.
    const FAST: f64 = 0.1;
    /// The part of an increment beyond that by which a servo that moves may have become faster within a sample.
    const SUDDEN: f64 = 0.5;
    /// The factor by which a command changes an increment more than just before: a jump comes out of nothing.
    const GROWTH: f64 = 4.0;
    /// Counts that rounding and noise may add.
    const QUANTISATION_COUNTS: f64 = 4.0;

    pub(super) fn new(settings: &WatchSettings, units: &Units) -> Self {
        let farthest =
            Self::SPEED_MARGIN * settings.speed * units.velocity() + Self::QUANTISATION_COUNTS;
        let samples = libm::round(Self::MAX_GAP / units.sample_time());
        Self {
            farthest: N::from_f64(farthest.min(N::REACH.to_f64())),
            lost_after: samples.max(Self::MIN_MISSING) as i32,
        }
    }

    pub(super) fn start(&self) -> ReadingsState<N> {
        ReadingsState {
            last: None,
            missing: 0,
            change: N::REACH,
            half_cycle: N::ZERO,
        }
    }

    /// By how many counts an increment of a servo may differ from the one before.
    pub(super) fn change_of(model: &Model) -> N {
        /// Standard deviations that noise stays within.
        const DEVIATIONS: f64 = 8.0;
        let change = Self::SPEED_MARGIN * model.most_acceleration
            + Self::QUANTISATION_COUNTS
            + DEVIATIONS * model.unexplained;
        N::from_f64(change)
    }

    pub(super) fn know(state: &mut ReadingsState<N>, change: N) {
        state.change = change;
    }

    /// The smallest jump that is seen for certain, counts.
    #[cfg(test)]
    pub(super) fn smallest_jump(&self, state: &ReadingsState<N>) -> f64 {
        let by_speed = self.farthest.to_f64() * (1.0 + 1.0 / Self::SPEED_MARGIN);
        by_speed.min(state.change.to_f64() * (1.0 + 1.0 / Self::SPEED_MARGIN))
    }

    /// Takes a reading of a servo of this mean speed, counts a sample, under a command.
    pub(super) fn process(
        &self,
        state: &mut ReadingsState<N>,
        increment: Option<N>,
        speed: N,
        command: N,
    ) -> Result<(), Reason> {
        let Some(increment) = increment else {
            state.last = None;
            state.missing = state.missing.saturating_add(1);
            return if state.missing >= self.lost_after {
                Err(Reason::EncoderLost)
            } else {
                Ok(())
            };
        };
        // The motion since the last reading shows now.
        let farthest = self.farthest * N::from_count(state.missing.saturating_add(1));
        let last = state.last.unwrap_or(increment);
        state.missing = 0;
        state.last = Some(increment);
        // Not "beyond", so that NaN is no reading.
        let near = |other: N| (increment - other).magnitude() <= state.change;
        let mirrored = (increment + last).magnitude() <= N::from_f64(0.5) * state.change;
        let possible = increment.magnitude() <= farthest;
        let change = (increment - last).magnitude();
        // One that was nearly as fast a sample before is a motion, however fast; noise moves nothing on the average.
        let is_fast = speed.magnitude() > N::from_f64(Self::FAST) * self.farthest
            && change <= N::from_f64(Self::SUDDEN) * increment.magnitude();
        // A motor that oscillates on its spring is that fast to and fro.
        let half_cycles =
            command != N::ZERO && change <= N::from_f64(Self::GROWTH) * state.half_cycle;
        let is_motion = near(last) && (is_fast || half_cycles);
        let less = N::from_f64(0.5) * state.half_cycle;
        state.half_cycle = if change > less { change } else { less };
        // A constant count is not a jump. Another check decides whether the servo can have stopped.
        if possible && (near(last) || increment == N::ZERO) {
            Ok(())
        } else if possible && mirrored {
            Err(Reason::Reversed)
        } else if is_motion {
            Err(Reason::SpeedExceeded)
        } else {
            Err(Reason::EncoderJumped)
        }
    }
}
