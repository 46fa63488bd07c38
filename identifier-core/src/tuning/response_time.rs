//! The bandwidth with which a step rises in a given time.

use super::closed_loop::ClosedLoop;
use super::placement::Design;
use super::prediction::{PredictionInputs, samples};
use super::search::GainCheck;
use super::{StepMeasure, TuningError};
use crate::number::Number;

/// A search for a bandwidth, by predicted steps. Margins are not checked here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ByTime {
    /// The requested rise time, s.
    asked: f64,
    rise: Rise,
    /// The fastest bandwidth that was too slow, rad/s.
    slow: Option<f64>,
    /// The slowest that was too fast, rad/s.
    fast: Option<f64>,
    left: u32,
}

/// A rise that is being timed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rise {
    bandwidth: f64,
    closed_loop: ClosedLoop,
    measure: StepMeasure<f64>,
    /// Samples until it departs, and from then on.
    longest: [u32; 2],
}

impl ByTime {
    /// Steps that are tried at most.
    const MAX_STEPS: u32 = 12;

    /// Relative tolerance of a rise time to the requested one.
    const CLOSE: f64 = 0.01;

    /// Begins with a bandwidth for a rise time, s.
    ///
    /// # Errors
    /// There are no such gains.
    pub(super) fn begin(
        scene: &PredictionInputs,
        judge: &GainCheck,
        bandwidth: f64,
        asked: f64,
    ) -> Result<Self, TuningError> {
        Ok(Self {
            asked,
            rise: Rise::begin(scene, &judge.design(bandwidth), asked)?,
            slow: None,
            fast: None,
            left: Self::MAX_STEPS,
        })
    }

    /// One sample; at the end the bandwidth, rad/s.
    pub(super) fn work(&mut self, scene: &PredictionInputs, judge: &GainCheck) -> Option<f64> {
        let time = self.rise.work()?;
        let ratio = time.map(|time| time / self.asked);
        let bandwidth = self.rise.bandwidth;
        let met = ratio.is_some_and(|ratio| libm::fabs(ratio - 1.0) < Self::CLOSE);
        if met || self.left == 0 || bandwidth > judge.highest() {
            return Some(bandwidth);
        }
        self.left -= 1;
        match ratio {
            Some(ratio) if ratio < 1.0 => self.fast = Some(bandwidth),
            _ => self.slow = Some(bandwidth),
        }
        let next = match (self.slow, self.fast) {
            (Some(slow), Some(fast)) => libm::sqrt(slow * fast),
            _ => bandwidth * ratio.map_or(2.0, |ratio| ratio.limited(0.5, 2.0)),
        };
        match Rise::begin(scene, &judge.design(next), self.asked) {
            Ok(rise) => {
                self.rise = rise;
                None
            }
            Err(_) => Some(next),
        }
    }
}

impl Rise {
    /// Time limit of a departure, 1/ω: eight times that without friction.
    const MAX_DEPARTURE: f64 = 8.0;

    /// Rise times that are asked for after which a rise is too slow to be timed.
    const SLOW: f64 = 2.0;

    fn begin(scene: &PredictionInputs, design: &Design, asked: f64) -> Result<Self, TuningError> {
        let closed_loop = scene.step(design)?;
        let slow = Self::SLOW * asked * design.bandwidth;
        Ok(Self {
            bandwidth: design.bandwidth,
            closed_loop,
            measure: scene.measure(),
            longest: [
                samples(Self::MAX_DEPARTURE, design, &closed_loop),
                samples(slow, design, &closed_loop),
            ],
        })
    }

    /// One sample. At the end it returns the rise time, s, or none if that is too long to be timed.
    fn work(&mut self) -> Option<Option<f64>> {
        let Some(seen) = self.closed_loop.advance() else {
            return Some(None);
        };
        self.measure.take(seen.position);
        if let Some(samples) = self.measure.rise() {
            return Some(Some(samples * self.closed_loop.sample_time()));
        }
        let [departing, rising] = self.longest;
        let [departed, _] = self.measure.since();
        let is_slow = departed.map_or(self.measure.samples() >= departing, |since| since > rising);
        is_slow.then_some(None)
    }
}
