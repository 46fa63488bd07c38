use super::IdentifierError;
use super::fit::FitterConfig;
use crate::error::Allowed;
use crate::interval::Interval;
use crate::model::HeldStep;
use crate::number::Number;
use crate::parameters::{Parameter, ParameterSet};
use crate::units::Units;

/// The largest b̂, ĉ and |d̂|, SI: far beyond any servo, and small enough that the model stays in
/// the range of single precision.
const LARGEST: f64 = 1e9;

/// The smallest b̂ that counts as one, SI.
const SMALLEST: f64 = 1e-9;

/// What is known of a parameter before the first sample, SI. Nothing has to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knowledge {
    /// A guess: one more place to start from. It binds nothing, however wrong it is.
    pub initial: Option<f64>,
    /// Standard deviation of the guess, above zero: how much it is to be held against the data.
    pub deviation: Option<f64>,
    /// Where the estimate is kept. Where nobody says, the bounds are those of arithmetic and of
    /// physics (a, b, c are not negative), never a multiple of a guess.
    pub bounds: Option<Interval>,
    /// Whether the parameter is known and stays at `initial` (or zero).
    pub fixed: bool,
}

impl Knowledge {
    /// Nothing is known.
    pub const NONE: Self = Self {
        initial: None,
        deviation: None,
        bounds: None,
        fixed: false,
    };

    /// A guess.
    #[must_use]
    pub fn guess(value: f64) -> Self {
        Self {
            initial: Some(value),
            ..Self::NONE
        }
    }

    /// A known value that is not to be identified.
    #[must_use]
    pub fn fixed(value: f64) -> Self {
        Self {
            fixed: true,
            ..Self::guess(value)
        }
    }
}

/// What an identifier that listens is built from, SI. Only the units have to be given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListeningSettings {
    /// Sample time and counts.
    pub units: Units,
    /// The bandwidth of the correction ω, rad/s; for instance that of the position loop, kp/kd of
    /// its PID. Within a factor of four is near enough. None: it is measured as the root mean
    /// square of acceleration over that of velocity.
    pub bandwidth: Option<f64>,
    /// Standard deviation of the position noise, rad; none for an encoder's, a count over √12.
    pub noise: Option<f64>,
    /// The highest speed the servo can have, rad/s: a count that jumps further is refused. None:
    /// only what the number format cannot count is.
    pub max_speed: Option<f64>,
    /// The time over which the first fit looks, s; 1 by default. The record keeps as many samples
    /// to a block as are needed for it. It is tried at half of it, and goes on until it succeeds.
    pub start_time: f64,
    /// The memory of the recursion, s; none for all that ever was.
    pub memory: Option<f64>,
    /// What is known of a, 1/s.
    pub a: Knowledge,
    /// What is known of b, rad/s² per command unit.
    pub b: Knowledge,
    /// What is known of the Coulomb friction c, rad/s².
    pub coulomb: Knowledge,
    /// What is known of the load d, rad/s².
    pub load: Knowledge,
}

impl ListeningSettings {
    /// Nothing but the units is known.
    #[must_use]
    pub fn new(units: Units) -> Self {
        Self {
            units,
            bandwidth: None,
            noise: None,
            max_speed: None,
            start_time: 1.0,
            memory: None,
            a: Knowledge::NONE,
            b: Knowledge::NONE,
            coulomb: Knowledge::NONE,
            load: Knowledge::NONE,
        }
    }

    /// What is known of a parameter.
    #[must_use]
    pub fn of(&self, parameter: Parameter) -> &Knowledge {
        match parameter {
            Parameter::A => &self.a,
            Parameter::B => &self.b,
            Parameter::Coulomb => &self.coulomb,
            Parameter::Load => &self.load,
        }
    }

    /// The variance of the position noise, counts².
    pub(super) fn noise_variance(&self) -> Result<f64, IdentifierError> {
        Ok(match self.noise {
            Some(noise) => {
                let counts =
                    Allowed::PositiveUpTo(1e3).check("noise", noise)? * self.units.position();
                counts * counts
            }
            None => super::fit::ROUNDING,
        })
    }

    /// The longest increment that is believed, counts.
    pub(super) fn longest_increment<N: Number>(&self) -> Result<N, IdentifierError> {
        Ok(match self.max_speed {
            Some(speed) => {
                let speed = Allowed::PositiveUpTo(1e9).check("max_speed", speed)?;
                // One more for the rounding of the count.
                let counts = speed * self.units.velocity() + 1.0;
                N::from_f64(counts.min(N::REACH.to_f64()))
            }
            None => N::REACH,
        })
    }

    /// The bandwidth per sample, if it was given.
    pub(super) fn bandwidth_per_sample(&self) -> Result<Option<f64>, IdentifierError> {
        self.bandwidth
            .map(|omega| {
                let most = MOST_PER_SAMPLE / self.units.sample_time();
                let omega = Allowed::PositiveUpTo(most).check("bandwidth", omega)?;
                Ok(omega * self.units.sample_time())
            })
            .transpose()
    }

    /// The bounds of a parameter, SI.
    fn bounds(&self, parameter: Parameter) -> Result<(f64, f64), IdentifierError> {
        let fastest = HeldStep::<f64>::LARGEST_RATE / self.units.sample_time();
        let (name, widest, unknown) = match parameter {
            Parameter::A => ("bounds.a", (-fastest, fastest), (0.0, fastest)),
            Parameter::B => ("bounds.b", (SMALLEST, LARGEST), (SMALLEST, LARGEST)),
            Parameter::Coulomb => ("bounds.coulomb", (0.0, LARGEST), (0.0, LARGEST)),
            Parameter::Load => ("bounds.load", (-LARGEST, LARGEST), (-LARGEST, LARGEST)),
        };
        Ok(match self.of(parameter).bounds {
            None => unknown,
            Some(given) => {
                let allowed = Allowed::Within(widest.0, widest.1);
                (
                    allowed.check(name, given.min())?,
                    allowed.check(name, given.max())?,
                )
            }
        })
    }

    /// The fitter's configuration for a parameter set: machine units, blocks for W of them in
    /// `time`.
    pub(super) fn fitter<S: ParameterSet<P>, const P: usize>(
        &self,
        time: f64,
        places: usize,
    ) -> Result<FitterConfig, IdentifierError> {
        let mut config = FitterConfig {
            block: self.block(time, places)?,
            noise: self.noise_variance()?,
            low: [0.0; 4],
            high: [0.0; 4],
            initial: [None; 4],
            deviation: [None; 4],
            free: [false; 4],
            bandwidth: self.bandwidth_per_sample()?,
        };
        for (i, parameter) in ALL.into_iter().enumerate() {
            let knowledge = self.of(parameter);
            let scale = parameter.scale(&self.units);
            let (low, high) = self.bounds(parameter)?;
            config.low[i] = low * scale;
            config.high[i] = high * scale;
            if let Some(initial) = knowledge.initial {
                let allowed = Allowed::Within(low, high);
                config.initial[i] = Some(allowed.check(initial_name(parameter), initial)? * scale);
            }
            if let Some(deviation) = knowledge.deviation {
                let deviation =
                    Allowed::PositiveUpTo(LARGEST).check(deviation_name(parameter), deviation)?;
                config.deviation[i] = Some(deviation * scale);
            }
            config.free[i] = !knowledge.fixed && S::PARAMETERS.contains(&parameter);
            if !S::PARAMETERS.contains(&parameter) {
                config.initial[i] = None;
            }
        }
        Ok(config)
    }

    fn block(&self, time: f64, places: usize) -> Result<u32, IdentifierError> {
        let time = Allowed::Within(1e-4, 1e4).check("start_time", time)?;
        let samples = time / self.units.sample_time();
        let block = libm::ceil(samples / places.max(1) as f64);
        // With a T ≤ ½ over a block; beyond a thousand samples a mean command says nothing.
        Ok(block.clamp(1.0, 1000.0) as u32)
    }
}

/// The largest ω T of the correction.
pub(super) const MOST_PER_SAMPLE: f64 = 0.3;

/// The parameters in the order of a fit.
pub(super) const ALL: [Parameter; 4] = [
    Parameter::A,
    Parameter::B,
    Parameter::Coulomb,
    Parameter::Load,
];

fn initial_name(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::A => "initial.a",
        Parameter::B => "initial.b",
        Parameter::Coulomb => "initial.coulomb",
        Parameter::Load => "initial.load",
    }
}

fn deviation_name(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::A => "deviation.a",
        Parameter::B => "deviation.b",
        Parameter::Coulomb => "deviation.coulomb",
        Parameter::Load => "deviation.load",
    }
}
