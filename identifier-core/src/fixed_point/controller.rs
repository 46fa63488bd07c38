use fixed::types::I16F16;

use super::arithmetic::{Raise, Sum, WORD_BITS, Word, between, limit, value};
use super::pid::FixedPid;
use super::ranges::FullScales;
use super::reference_filter::FixedReferenceFilter;
use crate::constants::{Encode, encode};
use crate::control::{ControlSample, Pid, Setpoint};
use crate::error::{Allowed, StepError};
use crate::measurement::velocity::VelocityEstimate;
use crate::settings::{FromSettings, Settings, SettingsError};

/// The sampled controller on words: filter of the reference, velocity estimate and PID, as
/// [`Controller`](crate::control::Controller) on numbers.
///
/// Its words are of the same full scales as those of an identifier built from the same settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedController<V> {
    pid: FixedPid,
    reference: FixedReferenceFilter,
    velocity: V,
    error: ErrorWord,
    increment: IncrementWord,
    /// The largest increment that is taken.
    most: Word,
    scales: FullScales,
    /// The same PID on numbers, and last bits of the integral and of an error per count: for a transfer.
    on_numbers: Pid<f32>,
    integral_bits: f32,
    error_bits: f32,
}

encode! {
    [V: Encode] FixedController<V> as "FixedController" {
        pid, reference, velocity, error, increment, most, scales, on_numbers, integral_bits, error_bits,
    }
}

/// State of the controller between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedControlState<F> {
    integral: Sum,
    /// The error of the filtered reference in the last sample.
    filtered: Word,
    filter: F,
}

impl Setpoint<I16F16> {
    /// Converts a setpoint in counts to fixed point, to the nearest 2⁻¹⁶. It consists of whole counts, which wrap at 32
    /// bits, and a fraction of a count from 0 to 1. Zero for a value that is no number, or infinite.
    #[must_use]
    pub fn from_counts(counts: f64) -> Self {
        const FRACTION: i32 = I16F16::FRAC_NBITS as i32;
        let bits = libm::rint(libm::ldexp(counts, FRACTION));
        if !bits.is_finite() {
            return Self {
                count: 0,
                offset: I16F16::ZERO,
            };
        }
        // All of it is exact: the wrap is a power of two.
        let wrap = libm::ldexp(1.0, FRACTION + 32);
        let wrapped = (bits - wrap * libm::floor(bits / wrap)) as i64;
        let part = wrapped & ((1 << FRACTION) - 1);
        Self {
            count: (wrapped >> FRACTION) as i32,
            offset: I16F16::from_bits(part as i32),
        }
    }
}

impl<V: VelocityEstimate<Word>> FromSettings for FixedController<V> {
    /// # Errors
    /// As for [`Controller`](crate::control::Controller). Also a range, bound or sample time that does not fit the
    /// fixed-point format, with the value that would. Also a notch or a feed-forward: there are none in fixed point.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let given = settings.own_controller()?;
        let (gains, limit) = (given.gains()?, given.command_limit()?);
        if let Some(feed_forward) = &given.feed_forward {
            Allowed::Within(0.0, 0.0).check("feed_forward_bandwidth", feed_forward.bandwidth)?;
        }
        Allowed::Within(0.0, 0.0).check("notch", given.notch)?;
        let (scales, units) = (FullScales::from_settings(settings)?, settings.units()?);
        Ok(Self {
            pid: FixedPid::new(&units, &gains, &limit, &scales),
            on_numbers: Pid::new(&units, &gains, &limit),
            integral_bits: Sum::bits_of_one(scales.sum(&units, &gains)),
            error_bits: libm::ldexpf(1.0, WORD_BITS - scales.position),
            reference: FixedReferenceFilter::new(&units, given.reference_filter, &scales)?,
            velocity: V::with_cutoff(&units, settings.cutoff)?,
            error: ErrorWord::new(&scales),
            increment: IncrementWord::new(&scales),
            most: scales.most_increment(settings)?,
            scales,
        })
    }
}

impl<V: VelocityEstimate<Word>> FixedController<V> {
    /// At rest, integral empty, the filtered reference at the servo's position.
    #[must_use]
    pub fn start(&self) -> FixedControlState<V::State> {
        FixedControlState {
            integral: Sum::ZERO,
            filtered: Word::ZERO,
            filter: V::State::default(),
        }
    }

    /// The state for a bumpless transfer from another controller, whose last sample is `last`, in counts. Its command
    /// and its filtered reference continue. The velocity estimate begins at zero.
    #[must_use]
    pub fn take_over(&self, last: &ControlSample<f32>) -> FixedControlState<V::State> {
        let integral = self.on_numbers.integral_for(last.command, last.error, 0.0);
        FixedControlState {
            integral: Sum::from_bits(integral * self.integral_bits),
            // A cast saturates.
            filtered: limit(Word::from_bits((last.error * self.error_bits) as i32)),
            filter: V::State::default(),
        }
    }

    /// The position error of a setpoint, whole counts and an offset on top, at a count; saturated.
    ///
    /// Counts may wrap at 32 bits: setpoint and position are never further apart than half of that.
    #[inline]
    #[must_use]
    pub fn error(&self, setpoint: i32, offset: I16F16, count: i32) -> Word {
        self.error.word(setpoint, offset, count)
    }

    /// Counts moved since the last sample as an increment; saturated.
    #[inline]
    #[must_use]
    pub fn increment(&self, moved: i32) -> Word {
        self.increment.word(moved)
    }

    /// One sample: position error and increment of the measured position to command. An error beyond
    /// its range saturates.
    ///
    /// # Errors
    /// [`StepError::CountJumped`] when the position moved faster than `max_speed`; the state is then
    /// untouched.
    #[inline]
    pub fn process(
        &self,
        state: &mut FixedControlState<V::State>,
        error: Word,
        increment: Word,
    ) -> Result<ControlSample<Word>, StepError> {
        if increment > self.most || increment < -self.most {
            return Err(StepError::CountJumped);
        }
        let error = limit(error);
        let error = self
            .reference
            .process(&mut state.filtered, error, increment);
        let velocity = self.velocity.process(&mut state.filter, increment);
        let command = self.pid.process(&mut state.integral, error, velocity);
        Ok(ControlSample {
            error,
            increment,
            velocity,
            command,
        })
    }

    /// A command as a number, command units.
    #[must_use]
    pub fn command(&self, command: Word) -> f64 {
        value(command, self.scales.command)
    }

    /// A velocity estimate as a number, counts per sample.
    #[must_use]
    pub fn velocity(&self, velocity: Word) -> f64 {
        value(velocity, self.scales.velocity)
    }
}

/// Setpoint less position as a word.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ErrorWord {
    /// Counts of the full scale.
    full: i32,
    up: Raise,
    down: u32,
}

encode! {
    [] ErrorWord as "ErrorWord" { full, up, down }
}

impl ErrorWord {
    fn new(scales: &FullScales) -> Self {
        let exponent = scales.position.clamp(0, WORD_BITS);
        Self {
            full: 1 << exponent,
            up: Raise::by(WORD_BITS - exponent),
            down: exponent.unsigned_abs(),
        }
    }

    /// Saturated.
    #[inline]
    fn word(self, setpoint: i32, offset: I16F16, count: i32) -> Word {
        const FRACTION: u32 = I16F16::FRAC_NBITS;
        let offset = offset.to_bits();
        let whole = setpoint
            .wrapping_sub(count)
            .saturating_add(offset >> FRACTION);
        let (whole, part) = if whole >= self.full {
            (self.full - 1, u32::MAX)
        } else if whole < -self.full {
            (-self.full, 0)
        } else {
            (whole, offset.cast_unsigned())
        };
        // Less than a count, so less than the bits shifted out of the whole ones.
        let part = (part & ((1 << FRACTION) - 1)) << (WORD_BITS.unsigned_abs() - FRACTION);
        self.up.whole(whole) + Word::from_bits((part >> self.down).cast_signed())
    }
}

/// Counts as a word of the velocity's full scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct IncrementWord {
    most: i32,
    up: Raise,
}

encode! {
    [] IncrementWord as "IncrementWord" { most, up }
}

impl IncrementWord {
    pub(super) fn new(scales: &FullScales) -> Self {
        let exponent = scales.velocity.clamp(1, WORD_BITS);
        Self {
            most: (1 << exponent) - 1,
            up: Raise::by(WORD_BITS - exponent),
        }
    }

    /// Saturated.
    #[inline]
    pub(super) fn word(self, counts: i32) -> Word {
        self.up.whole(between(counts, -self.most, self.most))
    }
}
