use super::parameter_range::{LARGEST, SMALLEST_GAIN, allowed};
use super::terms::TermConfig;
use super::{Settings, SettingsError};
use crate::error::Allowed;
use crate::fit::FitterConfig;
use crate::model::ZeroOrderHoldStep;
use crate::number::Number;
use crate::parameters::{Parameter, Terms, Unknown};
use crate::recursive::PATIENCE;
use crate::units::Units;

/// The settings that identifiers which fit are built from, with their units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Listening<'a> {
    settings: &'a Settings,
    pub(super) units: Units,
}

impl<'a> Listening<'a> {
    pub(super) fn new(settings: &'a Settings) -> Result<Self, SettingsError> {
        Ok(Self {
            settings,
            units: settings.units()?,
        })
    }

    /// The memory that was asked for, s.
    pub(super) fn memory(&self) -> Option<f64> {
        self.settings.identifier.memory
    }

    /// The optional terms of a model that has these, with delays of at most so many samples.
    pub(super) fn terms(
        &self,
        own: Terms,
        longest_delay: f64,
    ) -> Result<TermConfig, SettingsError> {
        TermConfig::new(
            own,
            longest_delay,
            &self.settings.identifier.terms,
            &self.units,
        )
    }

    /// The longest increment that is accepted, counts.
    pub(super) fn longest_increment<N: Number>(&self) -> Result<N, SettingsError> {
        let longest = self
            .settings
            .most_increment(&self.units, N::REACH.to_f64())?;
        Ok(N::from_f64(longest))
    }

    /// The fitter's configuration for the parameters among a model's `unknowns`, in machine units. A record has at most
    /// `places` blocks; `time` is the default time span of a fit, s. One copy serves every model.
    #[inline(never)]
    pub(super) fn fitter(
        &self,
        unknowns: &[Unknown],
        places: usize,
        time: f64,
    ) -> Result<FitterConfig, SettingsError> {
        let given = &self.settings.identifier;
        let block = self.block(places, time)?;
        let mut config = FitterConfig {
            block,
            noise: self.settings.noise_variance(&self.units)?,
            low: [0.0; 4],
            high: [0.0; 4],
            initial: [None; 4],
            deviation: [None; 4],
            free: [false; 4],
            bandwidth: self.bandwidth_per_sample()?,
            at_first: None,
        };
        for i in 0..Parameter::ALL.len() {
            let parameter = Parameter::ALL[i];
            if !unknowns.contains(&parameter.into()) {
                continue;
            }
            let scale = parameter.scale(&self.units);
            let [low, high] = self.bounds(parameter)?;
            config.low[i] = low * scale;
            config.high[i] = high * scale;
            if let Some(initial) = given.initial.get(parameter) {
                let (_, _, name) = allowed(parameter, &self.units);
                let initial = Allowed::Within(low, high).check(name, initial)?;
                config.initial[i] = Some(initial * scale);
            }
            if let Some(deviation) = given.uncertainty.get(parameter) {
                let deviation = Allowed::PositiveUpTo(LARGEST).check("uncertainty", deviation)?;
                config.deviation[i] = Some(deviation * scale);
            }
            config.free[i] = !given.known.get(parameter);
        }
        Ok(config)
    }

    /// The bounds of a parameter, SI. They are those given, or those of arithmetic and physics (a, b and c are not
    /// negative). They are never a multiple of an initial value.
    fn bounds(&self, parameter: Parameter) -> Result<[f64; 2], SettingsError> {
        let (allowed, name, _) = allowed(parameter, &self.units);
        let fastest = ZeroOrderHoldStep::<f64>::LARGEST_RATE / self.units.rate();
        let widest = match parameter {
            Parameter::A => [0.0, fastest],
            Parameter::B => [SMALLEST_GAIN, LARGEST],
            Parameter::Coulomb => [0.0, LARGEST],
            Parameter::Load => [-LARGEST, LARGEST],
        };
        let [low, high] = self
            .settings
            .identifier
            .bounds
            .get(parameter)
            .unwrap_or(widest);
        let low = allowed.check(name, low)?;
        allowed.check(name, high)?;
        Ok([low, Allowed::AtLeast(low).check(name, high)?])
    }

    /// ω T of the correction, if its bandwidth was given.
    fn bandwidth_per_sample(&self) -> Result<Option<f64>, SettingsError> {
        let Some(omega) = self.settings.identifier.bandwidth else {
            return Ok(None);
        };
        let most = MAX_BANDWIDTH_PER_SAMPLE / self.units.rate();
        let omega = Allowed::PositiveUpTo(most).check("bandwidth", omega)?;
        Ok(Some(omega * self.units.rate()))
    }

    /// Samples per block, so that `places` blocks span the time over which a fit looks.
    fn block(&self, places: usize, time: f64) -> Result<u32, SettingsError> {
        /// Beyond a thousand samples a mean command carries no information.
        const MAX_BLOCK_SAMPLES: f64 = 1000.0;
        let time = self.settings.identifier.start_time.unwrap_or(time);
        let time = Allowed::Within(1e-4, 1e4).check("start_time", time)?;
        let samples = time / self.units.rate();
        Ok(libm::ceil(samples / places.max(1) as f64).clamp(1.0, MAX_BLOCK_SAMPLES) as u32)
    }

    /// Blocks in motion after which a first fit to a record of `places` is overdue.
    pub(super) fn patience(&self, block: u32, places: usize) -> u32 {
        let blocks = PATIENCE / (f64::from(block) * self.units.rate());
        (libm::ceil(blocks) as u32).max(places as u32)
    }
}

/// The largest ω T of the correction.
pub(super) const MAX_BANDWIDTH_PER_SAMPLE: f64 = 0.3;
