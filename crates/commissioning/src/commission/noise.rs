//! Encoder noise above a count.
//!
//! A commissioning judges motion and rest by counts, whose rounding it knows. Noise of several counts would look like
//! motion. So the position is held until it has moved by more than the noise explains. It is given in units of the
//! noise, not counts. The axis then has a coarser encoder without noise.

use identifier_core::number::Number;
use identifier_core::reason::Reason;

/// Hysteresis in half widths, and the unit of a position, both in standard deviations of the noise. Over 10⁴ samples
/// noise reaches four: a few of them pass, as edges of a count do.
const HALF_WIDTH: f64 = 3.0;
const UNIT: f64 = 2.0;

/// The farthest that noise takes a position, counts.
const APPARENT: f64 = 24.0;

/// Noise that rounding hides, counts.
const HIDDEN: f64 = 0.1;

/// Standard deviation of a count's rounding, counts: the root of a twelfth.
pub(super) const QUANTISATION_SIGMA: f64 = 0.3;

/// True if a servo at this speed would have passed counts in so many samples without any: it stands.
pub(super) fn has_missed<N: Number>(speed: N, still: u32) -> bool {
    /// Counts that a servo that moves cannot have missed.
    const MISSED: f64 = 2.5;
    let still = N::from_count(still.min(1 << 20) as i32);
    still * speed.magnitude() > N::from_f64(MISSED)
}

/// Counts that are no motion yet: at an edge of the encoder a servo at rest shows one, a servo that moves shows two.
pub(super) const EDGE_COUNTS: f64 = 1.5;

/// The position of an encoder with noise, in units of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hysteresis<N> {
    /// Counts that the encoder may be away from the position.
    half_width: i32,
    /// Units per count, in 2⁻³².
    per_count: i64,
    /// Counts, and its inverse.
    unit: [N; 2],
}

/// The position that is held, counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Held {
    count: i32,
    /// From where it began.
    moved: i32,
    /// The last count of the encoder and its increment, and how often the next increment took one back.
    last: i32,
    increment: i32,
    taken_back: u8,
}

/// The unit of positions for this noise, counts.
pub(super) fn unit(noise: f64) -> f64 {
    if noise > HIDDEN {
        libm::round(UNIT * noise).max(1.0)
    } else {
        1.0
    }
}

impl<N: Number> Hysteresis<N> {
    /// For noise with this standard deviation, counts.
    pub(super) fn new(noise: f64) -> Self {
        let unit = unit(noise);
        let width = if noise > HIDDEN {
            libm::ceil(HALF_WIDTH * noise)
        } else {
            0.0
        };
        Self {
            half_width: width as i32,
            per_count: libm::round(f64::from(u32::MAX) / unit) as i64 + 1,
            unit: [unit, 1.0 / unit].map(N::from_f64),
        }
    }

    /// Takes a count in: the position from where it began and its increment, units.
    pub(super) fn follow(&self, held: &mut Held, count: i32, is_open: bool) -> [N; 2] {
        let before = self.units(held.moved);
        let half_width = self.half_width.max(held.chatter(count, is_open));
        let away = count.wrapping_sub(held.count);
        let explained = away.min(half_width).max(-half_width);
        let moved = away.wrapping_sub(explained);
        held.count = held.count.wrapping_add(moved);
        held.moved = held.moved.wrapping_add(moved);
        let now = self.units(held.moved);
        [now, now.wrapping_sub(before)].map(N::from_count)
    }

    /// Whole units.
    fn units(&self, counts: i32) -> i32 {
        ((i64::from(counts) * self.per_count) >> 32) as i32
    }

    /// True if a unit is more than a count.
    pub(super) fn is_coarse(&self) -> bool {
        self.unit[0] > N::ONE
    }

    /// In units of the noise, of counts.
    pub(super) fn in_units(&self, counts: N) -> N {
        counts * self.unit[1]
    }

    /// In counts, of units of the noise.
    pub(super) fn in_counts(&self, units: N) -> N {
        units * self.unit[0]
    }
}

impl Held {
    pub(super) fn at(count: i32) -> Self {
        Self {
            count,
            last: count,
            ..Self::default()
        }
    }

    /// From where it began.
    pub(super) fn moved(&self) -> i32 {
        self.moved
    }

    /// The half width for noise that shows only at the edges of counts, if there is some. A motion that turns rarely
    /// reverses an increment in the next sample. An edge does so in every second one.
    fn chatter(&mut self, count: i32, is_open: bool) -> i32 {
        const CHATTERS: u8 = 8;
        let increment = count.wrapping_sub(self.last);
        let takes_back = increment.signum() * self.increment.signum() < 0;
        self.taken_back = self
            .taken_back
            .saturating_add(u8::from(takes_back && is_open));
        (self.last, self.increment) = (count, increment);
        i32::from(self.taken_back >= CHATTERS)
    }
}

/// The noise of an encoder at rest, from its counts y. White noise with variance σ² has E[Δ²y(k) Δ²y(k − 1)] = −4 σ². A
/// smooth motion has a positive one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct RestNoise<N> {
    last: Option<i32>,
    increment: N,
    change: N,
    taken_back: N,
    samples: u32,
    takes_back: bool,
}

impl<N: Number> RestNoise<N> {
    /// Samples after which the deviation has an error of a fifth.
    const KNOWN: u32 = 48;
    /// Samples of noise among which a monotonic run is improbable, 2/7!. The samples of a fall are monotonic.
    const ABOVE_FREE_MOTION: u32 = 8;

    pub(super) fn take(&mut self, count: i32) {
        let increment = N::from_count(count.wrapping_sub(self.last.unwrap_or(count)));
        self.last = Some(count);
        self.takes_back |= increment * self.increment < N::ZERO;
        let change = increment - self.increment;
        self.taken_back = self.taken_back - self.change * change;
        self.increment = increment;
        self.change = change;
        self.samples = self.samples.saturating_add(1);
    }

    /// Judges a rest with this many tolerated counts of noise, beyond which it would be mistaken for motion; none before
    /// the result is clear. The position is from
    /// where it began, units; `is_declared` if the hysteresis keeps noise out of it.
    pub(super) fn judge(
        &self,
        position: N,
        tolerated: N,
        is_declared: bool,
    ) -> Option<Result<(), Reason>> {
        /// Factor by which chance increases the deviation of few samples, over their inverse.
        const CHANCE: f64 = 8.0;
        let chance = N::from_f64(CHANCE) * self.inverse_of_samples();
        let rest = if self.deviation() > tolerated * (N::ONE + chance) {
            Err(Reason::EncoderNoise)
        } else {
            Ok(())
        };
        let falls = position.magnitude() > N::from_f64(APPARENT)
            || self.samples >= Self::ABOVE_FREE_MOTION && !self.takes_back;
        let is_clear = self.samples >= Self::KNOWN
            || rest.is_ok() && (falls || is_declared)
            || rest.is_err() && falls;
        is_clear.then_some(rest)
    }

    /// The standard deviation so far, counts.
    pub(super) fn deviation(&self) -> N {
        let variance = N::from_f64(0.25) * self.taken_back * self.inverse_of_samples();
        if variance > N::ZERO {
            variance * variance.reciprocal_root()
        } else {
            N::ZERO
        }
    }

    fn inverse_of_samples(&self) -> N {
        let samples = self.samples.clamp(1, 1 << 20);
        N::from_count(samples as i32).reciprocal()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve uniform numbers of a congruential generator.
    fn gaussian(state: &mut u32) -> f64 {
        let sum: f64 = (0..12)
            .map(|_| {
                *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(*state >> 8) / f64::from(1 << 24)
            })
            .sum();
        sum - 6.0
    }

    #[test]
    fn without_noise_every_count_is_told_as_it_is() {
        let hysteresis = Hysteresis::<f32>::new(0.0);
        let mut held = Held::at(i32::MAX - 2);
        let mut position = 0.0;
        for moved in [1, 5, -3, 7, -2, 100, -250] {
            position += moved as f32;
            let count = (i32::MAX - 2).wrapping_add(position as i32);
            let told = hysteresis.follow(&mut held, count, true);
            assert_eq!(
                told.map(f32::to_bits),
                [position, moved as f32].map(f32::to_bits)
            );
        }
        assert!(!hysteresis.is_coarse());
    }

    #[test]
    fn noise_at_rest_is_no_motion_and_motion_is_told_to_a_half_width() {
        const NOISE: f64 = 4.0;
        let hysteresis = Hysteresis::<f64>::new(NOISE);
        let (mut held, mut random) = (Held::at(0), 7);
        let mut moves = 0;
        for k in 0..3000 {
            let count = libm::floor(NOISE * gaussian(&mut random)) as i32;
            let [_, increment] = hysteresis.follow(&mut held, count, true);
            moves += u32::from(k > 1000 && increment.abs() > 0.0);
        }
        assert!(moves <= 3, "{moves}");
        for k in 0..3000 {
            let truth = 2.0 * f64::from(k);
            let count = libm::floor(truth + NOISE * gaussian(&mut random)) as i32;
            let [position, _] = hysteresis.follow(&mut held, count, true);
            let off = hysteresis.in_counts(position) - truth;
            assert!(off.abs() < (HALF_WIDTH + UNIT + 4.0) * NOISE, "{k} {off}");
        }
    }

    #[test]
    fn the_noise_of_a_rest_and_of_a_fall_is_found_and_a_fall_is_none() {
        for (noise, acceleration) in [(0.0, 0.0), (0.0, 0.6), (2.0, 0.0), (5.0, 0.6)] {
            let (mut rest, mut random) = (RestNoise::<f32>::default(), 3);
            let mut mean = 0.0;
            for k in 0..400 {
                if k % 50 == 0 {
                    rest = RestNoise::default();
                }
                let time = f64::from(k % 50);
                let fallen = 0.5 * acceleration * time * time;
                rest.take(libm::floor(fallen + noise * gaussian(&mut random)) as i32);
                if k % 50 == 49 {
                    mean += f64::from(rest.deviation()) / 8.0;
                }
            }
            // Rounding is noise too where the servo moves.
            assert!((mean - noise).abs() < 0.15 * noise + 0.35, "{noise} {mean}");
        }
    }
}
