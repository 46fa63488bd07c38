//! A record with the range in which its servo may lie.

use std::fmt;

use super::gain::Diffuse;
use super::{Effect, Horizon, ModelPass, Record, RecordStatistics, Values};

/// Whether to continue: asked before every step of a search, from any thread. Once it is false it stays so.
pub type GoesOn<'a> = &'a (dyn Fn() -> bool + Sync);

/// A record and the range in which its servo may lie.
#[derive(Clone, Copy)]
pub struct RecordFitter<'a> {
    /// The record.
    pub record: &'a Record<'a>,
    /// Its figures.
    pub statistics: RecordStatistics,
    /// The earliest that the command acts, samples: negative where it was recorded late.
    pub earliest: f64,
    /// Samples of the record to one of the blocks in which the effects of the log were looked for; one where there are none.
    pub block: f64,
    /// A search that may not go on ends where it is.
    pub goes_on: GoesOn<'a>,
}

impl fmt::Debug for RecordFitter<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Fitter")
            .field("survey", &self.statistics)
            .field("earliest", &self.earliest)
            .finish_non_exhaustive()
    }
}

impl<'a> RecordFitter<'a> {
    /// The longest delay beyond the earliest: samples, and radians at the bandwidth of the motion.
    const MAX_DELAY: [f64; 2] = [6.0, 0.3];
    /// The earliest command that a start may have, samples.
    const EARLIEST: f64 = -3.5;
    /// The resonances that a record may show, rad/sample.
    pub const RESONANCES: [f64; 2] = [0.005, 2.5];
    /// The largest error of an eccentric encoder, rad.
    const MAX_ECCENTRICITY: f64 = 0.05;
    /// The largest a, 1/sample.
    pub(crate) const MAX_RATE: f64 = 0.5;

    /// None where there is no motion.
    #[must_use]
    pub fn new(record: &'a Record<'a>) -> Option<Self> {
        Some(Self {
            record,
            statistics: RecordStatistics::new(record)?,
            earliest: Self::EARLIEST,
            block: 1.0,
            goes_on: &|| true,
        })
    }

    /// The model at a horizon.
    #[must_use]
    pub fn pass(&self, values: &Values, horizon: Horizon) -> ModelPass<'a> {
        let velocity = self.statistics.velocity;
        let usual = values.get(Effect::B).abs() * self.statistics.command;
        let noise = super::QUANTISATION_SIGMA;
        let [velocity_variance, load] = [velocity / noise, 0.3 * usual / noise].map(|x| x * x);
        ModelPass {
            record: self.record,
            horizon,
            damping: values.get(Effect::A),
            diffuse: Diffuse {
                velocity: velocity_variance,
                load,
            },
            starts: None,
        }
    }

    pub(super) fn longest_delay(&self) -> f64 {
        let [samples, angle] = Self::MAX_DELAY;
        (samples * self.block).max(angle / self.statistics.bandwidth)
    }

    /// The least and the largest value of an effect.
    #[must_use]
    pub fn bounds(&self, values: &Values, effect: Effect) -> [f64; 2] {
        let ends = f64::INFINITY;
        let limit = self.statistics.command;
        match effect {
            Effect::A => [-2.0 / self.record.len() as f64, Self::MAX_RATE],
            Effect::B => [1e-9, ends],
            Effect::Coulomb | Effect::DeadBand => [0.0, ends],
            Effect::Delay => [self.earliest, self.earliest.max(0.0) + self.longest_delay()],
            Effect::CurrentLoop => [0.0, 50.0 * self.block],
            Effect::LowSpeed => [-values.get(Effect::Coulomb), ends],
            Effect::LowSpeedVelocity => [1e-9, 2.0 * self.statistics.velocity],
            Effect::LoadFriction => [0.0, 0.6],
            Effect::HiddenLimit => [0.0, 1.3 * limit],
            Effect::GainAsymmetry
            | Effect::TorqueRippleSine
            | Effect::TorqueRippleCosine
            | Effect::InertiaSine
            | Effect::InertiaCosine => [-0.9, 0.9],
            Effect::GainDrift | Effect::FrictionDrift => [-1.9, 1.9],
            Effect::Compliance | Effect::Backlash => [0.0, ends],
            Effect::ResonanceFrequency => {
                let [low, high] = Self::RESONANCES;
                [low / self.block, high]
            }
            Effect::ResonanceDamping => [1e-3, 0.9],
            Effect::LoadShare => [0.0, 0.95],
            Effect::EccentricitySine | Effect::EccentricityCosine => {
                let most = Self::MAX_ECCENTRICITY * self.record.radian;
                [-most, most]
            }
            _ => [-ends, ends],
        }
    }

    /// The size against which an error of one of the four parameters is small or large. For b it is b itself. For
    /// friction and load it is the acceleration by the largest command, for a that over the velocity. It is zero for
    /// other effects.
    #[must_use]
    pub fn usual_size(&self, values: &Values, effect: Effect) -> f64 {
        let gain = values.get(Effect::B).abs();
        let acceleration = gain * self.statistics.command;
        match effect {
            Effect::A => acceleration / self.statistics.velocity,
            Effect::B => gain,
            Effect::Coulomb | Effect::Load => acceleration,
            _ => 0.0,
        }
    }
}
