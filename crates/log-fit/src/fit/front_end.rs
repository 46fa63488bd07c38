//! The way of the command to the acceleration: dead band, limit, gain by direction, delay and current loop.

use super::{Column, Effect, Record, Values};

/// The front end of an amplifier, ready for a pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrontEnd {
    dead_band: f64,
    limit: f64,
    slope: f64,
    asymmetry: f64,
    /// Whole samples of the delay.
    whole: i64,
    /// Lengths of the two parts of a sample: the earlier command acts first.
    pub(super) lengths: [f64; 2],
    lag: Option<[Lag; 2]>,
    /// True if friction depends on the size of the command.
    has_load_friction: bool,
}

/// A current loop over a part of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Lag {
    /// The part of an error that is left at the end.
    left: f64,
    /// Its mean over the part.
    mean: f64,
    left_per_lag: f64,
    mean_per_lag: f64,
    per_length: f64,
}

/// The command that acts over a part of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Part {
    /// Its mean.
    pub(super) command: f64,
    /// Its derivative by the current loop's time constant.
    pub(super) per_lag: f64,
    /// Its slope, per sample; zero without a current loop.
    pub(super) slope: f64,
    /// The mean of its size.
    pub(super) size: f64,
    /// The sample of the record whose command it is.
    sample: usize,
    /// The part of the sample, 0 or 1.
    pub(super) last: usize,
}

/// The current in the loop, and its derivative by the time constant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Current {
    value: f64,
    per_lag: f64,
    is_known: bool,
}

/// Time constants below this are none, samples.
const MIN_LAG: f64 = 1e-4;

impl FrontEnd {
    /// The shortest part of a sample that is a part of its own.
    const MIN_PART: f64 = 1e-9;

    pub(super) fn new(values: &Values, columns: &[Column]) -> Self {
        let delay = values.get(Effect::Delay);
        let mut whole = libm::floor(delay);
        let mut part = delay - whole;
        if part > 1.0 - Self::MIN_PART {
            whole += 1.0;
            part = 0.0;
        } else if part < Self::MIN_PART {
            part = 0.0;
        }
        let lengths = [part, 1.0 - part];
        let lag = values.get(Effect::CurrentLoop);
        Self {
            dead_band: values.get(Effect::DeadBand),
            limit: values.get(Effect::HiddenLimit),
            slope: values.get(Effect::LimitSlope),
            asymmetry: values.get(Effect::GainAsymmetry),
            whole: whole as i64,
            lengths,
            lag: (lag > MIN_LAG).then(|| lengths.map(|length| Lag::new(lag, length))),
            has_load_friction: values.get(Effect::LoadFriction) != 0.0
                || columns
                    .iter()
                    .any(|column| column.effect == Effect::LoadFriction),
        }
    }

    /// The recorded commands over the two parts of a sample of a motion, given by its first sample and its end.
    #[inline]
    pub(super) fn recorded(
        &self,
        record: &Record<'_>,
        motion: (usize, usize),
        sample: usize,
    ) -> [Part; 2] {
        let mut parts = [Part::default(); 2];
        for (i, part) in parts.iter_mut().enumerate() {
            let wanted = sample as i64 - self.whole - i64::from(i == 0);
            let place = wanted.clamp(motion.0 as i64, motion.1 as i64 - 1) as usize;
            part.command = record.commands[place];
            part.sample = place;
            part.last = i;
        }
        parts
    }

    /// Applies the amplifier to the commands over the two parts of a sample.
    #[inline]
    pub(super) fn process(
        &self,
        record: &Record<'_>,
        parts: &mut [Part; 2],
        current: &mut Current,
    ) {
        for part in &mut *parts {
            if !self.is_linear() {
                part.command = record.over(part.sample, |command| self.shape(command));
            }
            part.size = if self.has_load_friction && record.has_blocks() {
                record.over(part.sample, |command| self.shape(command).abs())
            } else {
                part.command.abs()
            };
        }
        let Some(lags) = &self.lag else {
            // The first derivative of a current loop that is none: what a step loses.
            let [earlier, later] = parts;
            later.per_lag = (earlier.command - later.command) / self.lengths[1];
            return;
        };
        if !current.is_known {
            *current = Current {
                value: parts[0].command,
                per_lag: 0.0,
                is_known: true,
            };
        }
        for (part, lag) in parts.iter_mut().zip(lags) {
            let target = part.command;
            let off = current.value - target;
            part.command = target + off * lag.mean;
            part.size = part.command.abs();
            part.per_lag = current.per_lag * lag.mean + off * lag.mean_per_lag;
            part.slope = off * (lag.left - 1.0) * lag.per_length;
            current.per_lag = current.per_lag * lag.left + off * lag.left_per_lag;
            current.value = target + off * lag.left;
        }
    }

    /// True if the command acts unchanged.
    const fn is_linear(&self) -> bool {
        self.slope == 0.0 && self.dead_band == 0.0 && self.asymmetry == 0.0
    }

    /// True if there is a current loop.
    pub(super) const fn has_lag(&self) -> bool {
        self.lag.is_some()
    }

    #[inline]
    fn shape(&self, command: f64) -> f64 {
        let even = self.without_asymmetry(command);
        even + self.asymmetry * even.abs()
    }

    #[inline]
    fn without_asymmetry(&self, command: f64) -> f64 {
        let mut shaped = command;
        if self.slope != 0.0 {
            if shaped > self.limit {
                shaped -= self.slope * (shaped - self.limit);
            } else if shaped < -self.limit {
                shaped -= self.slope * (shaped + self.limit);
            }
        }
        if self.dead_band != 0.0 {
            shaped = if shaped > self.dead_band {
                shaped - self.dead_band
            } else if shaped < -self.dead_band {
                shaped + self.dead_band
            } else {
                0.0
            };
        }
        shaped
    }

    /// True if an effect is a shape of the command.
    pub(super) const fn is_shape(effect: Effect) -> bool {
        use Effect::{DeadBand, GainAsymmetry, HiddenLimit, LimitSlope};
        matches!(effect, DeadBand | GainAsymmetry | HiddenLimit | LimitSlope)
    }

    /// The derivative of the command over a part by an effect of its shape. `lagged` is the derivative of the current.
    #[inline]
    pub(super) fn derivative(
        &self,
        record: &Record<'_>,
        part: &Part,
        column: &Column,
        lagged: &mut f64,
    ) -> f64 {
        let target = record.over(part.sample, |command| self.shape_per(column, command));
        match &self.lag {
            Some(lags) => {
                let lag = &lags[part.last];
                let off = *lagged - target;
                *lagged = target + off * lag.left;
                target + off * lag.mean
            }
            None => target,
        }
    }

    /// The derivative of the shape of a command by a column.
    #[inline]
    fn shape_per(&self, column: &Column, recorded: f64) -> f64 {
        let limit = if column.setting > 0.0 {
            column.setting
        } else {
            self.limit
        };
        let beyond = recorded.abs() > limit;
        let target = match column.effect {
            Effect::DeadBand if recorded.abs() > self.dead_band => -recorded.signum(),
            Effect::GainAsymmetry => self.without_asymmetry(recorded).abs(),
            Effect::LimitSlope if beyond => limit * recorded.signum() - recorded,
            Effect::HiddenLimit if beyond => self.slope * recorded.signum(),
            _ => 0.0,
        };
        match column.effect {
            Effect::GainAsymmetry => target,
            _ => target * (1.0 + self.asymmetry * recorded.signum()),
        }
    }
}

/// The mean command over each sample of a record that accelerates the servo of some values as it does, if nothing else but
/// friction and load acts on it.
pub(crate) fn acting_commands(record: &Record<'_>, values: &Values) -> Vec<f64> {
    let front_end = FrontEnd::new(values, &[]);
    let of = |one: Effect| values.get(one);
    let sizes = Effect::FORCES.map(|force| force.map(of));
    let waves = values.orders.into_iter().zip(sizes);
    let waves: Vec<_> = waves.filter(|(_, sizes)| *sizes != [0.0; 2]).collect();
    let gain_wave = [of(Effect::TorqueRippleSine), of(Effect::TorqueRippleCosine)];
    let along = |[sine, cosine]: [f64; 2], wave: [f64; 2]| sine * wave[0] + cosine * wave[1];
    let mut acting = Vec::with_capacity(record.len());
    for motion in record.motions() {
        let mut current = Current::default();
        for sample in motion.0..motion.1 {
            let mut parts = front_end.recorded(record, motion, sample);
            front_end.process(record, &mut parts, &mut current);
            let means = parts.iter().zip(front_end.lengths);
            let command: f64 = means.map(|(part, length)| length * part.command).sum();
            let passed = sample as f64 / record.len() as f64 - 0.5;
            let gain = (1.0 + along(gain_wave, record.wave(sample, values.gain_order)))
                * (1.0 + of(Effect::GainDrift) * passed);
            let forces: f64 = waves
                .iter()
                .map(|(order, sizes)| along(*sizes, record.wave(sample, *order)))
                .sum();
            acting.push(gain * command + forces / of(Effect::B));
        }
    }
    acting
}

impl Lag {
    fn new(lag: f64, length: f64) -> Self {
        if length <= 0.0 {
            return Self {
                left: 1.0,
                mean: 1.0,
                left_per_lag: 0.0,
                mean_per_lag: 0.0,
                per_length: 0.0,
            };
        }
        let left = libm::exp(-length / lag);
        let per_length = 1.0 / length;
        Self {
            left,
            mean: lag * per_length * (1.0 - left),
            left_per_lag: left * length / (lag * lag),
            mean_per_lag: per_length * (1.0 - left) - left / lag,
            per_length,
        }
    }
}
