//! Scales of axes: places of ticks and their text.

use std::ops::RangeInclusive;

use crate::present::number::{fixed, power_of_ten};

/// Places of values along an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    low: f64,
    high: f64,
    is_logarithmic: bool,
    ticks: Vec<f64>,
    /// Digits behind the point of a linear axis, after division by ten to the `exponent`.
    digits: usize,
    exponent: i32,
    /// The names of places 1, 2 and so on, which then are the ticks.
    names: Vec<String>,
}

impl Scale {
    /// At least from `low` to `high`, which are moved outwards to ticks; about `steps` steps at most.
    pub(super) fn around(low: f64, high: f64, steps: u32) -> Self {
        let (low, high) = apart(low, high);
        let step = nice((high - low) / f64::from(steps));
        // A value beside a tick is on it.
        const BESIDE: f64 = 1e-6;
        let first = (low / step + BESIDE).floor();
        let last = (high / step - BESIDE).ceil();
        Self::linear(first * step, last * step, step)
    }

    /// From `low` to `high`, moved to a tick that is near.
    pub(super) fn between(low: f64, high: f64, steps: u32) -> Self {
        /// Part of a step by which an axis is lengthened to end in a tick.
        const NEAR: f64 = 0.12;
        let (low, high) = apart(low, high);
        let step = nice((high - low) / f64::from(steps));
        let last = (high / step).round() * step;
        let end = if (last - high).abs() <= 0.002 * (high - low)
            || (last > high && last - high < NEAR * step)
        {
            last
        } else {
            high
        };
        Self::linear(low, end, step)
    }

    /// Around positive values, from one of 1, 2 or 5 times a power of ten to another. Its ticks are all of these
    /// where they are few, else powers of ten.
    pub(super) fn logarithmic(low: f64, high: f64) -> Self {
        const MAX_TICKS: usize = 7;
        const PARTS: [f64; 3] = [1.0, 2.0, 5.0];
        /// A value beside a tick is on it.
        const BESIDE: f64 = 1e-9;
        let (low, high) = (low.log10() + BESIDE, high.log10() - BESIDE);
        let decades = low.floor() as i32 - 1..=high.ceil() as i32 + 1;
        let values = decades.flat_map(|power| PARTS.map(|part| f64::from(power) + part.log10()));
        let values: Vec<f64> = values.collect();
        // There is one before the first, and one behind the last.
        let first = values.partition_point(|value| *value <= low).max(1) - 1;
        let last = values.partition_point(|value| *value < high).max(first + 1);
        let within = &values[first..=last];
        let (low, high) = (within[0], within[within.len() - 1]);
        let every = |count: f64| {
            let powers = within.iter().copied();
            powers.filter(move |power| (power / count).fract() == 0.0)
        };
        let sparse = [1.0, 2.0, 3.0, 5.0].map(|count| every(count).collect::<Vec<f64>>());
        let mut choices = [within.to_vec()].into_iter().chain(sparse);
        let ticks = choices.find(|ticks| ticks.len() <= MAX_TICKS);
        Self {
            low,
            high,
            is_logarithmic: true,
            ticks: ticks.unwrap_or_else(|| vec![low.ceil(), high.floor()]),
            digits: 0,
            exponent: 0,
            names: Vec::new(),
        }
    }

    /// The part of a linear scale from a value to its end.
    pub(super) fn beginning_at(&self, low: f64) -> Self {
        let mut part = self.clone();
        part.low = low;
        part.ticks.retain(|tick| *tick >= low);
        part
    }

    pub(super) fn is_logarithmic(&self) -> bool {
        self.is_logarithmic
    }

    /// The value at a part of a linear scale.
    pub(super) fn value(&self, part: f64) -> f64 {
        self.low + part * (self.high - self.low)
    }

    fn linear(low: f64, high: f64, step: f64) -> Self {
        let first = (low / step - 1e-6).ceil() as i64;
        let last = (high / step + 1e-6).floor() as i64;
        let largest = low.abs().max(high.abs());
        // As engineers write them: powers of a thousand.
        let power = (largest.log10() + 1e-9).floor() as i32;
        let exponent = if (-2..=4).contains(&power) {
            0
        } else {
            3 * power.div_euclid(3)
        };
        let shown_step = step / 10_f64.powi(exponent);
        Self {
            low,
            high,
            is_logarithmic: false,
            ticks: (first..=last).map(|k| k as f64 * step).collect(),
            digits: (-(shown_step.log10() + 1e-9).floor()).max(0.0) as usize,
            exponent,
            names: Vec::new(),
        }
    }

    /// With names in place of figures.
    pub(super) fn named_by(mut self, names: &[String]) -> Self {
        self.ticks = (1..=names.len()).map(|place| place as f64).collect();
        self.names = names.to_vec();
        self
    }

    /// Place of a value: 0 at the beginning, 1 at the end.
    pub(super) fn part(&self, value: f64) -> f64 {
        let value = if self.is_logarithmic {
            value.log10()
        } else {
            value
        };
        (value - self.low) / (self.high - self.low)
    }

    /// The place of each tick, as [`part`](Self::part), and its text.
    pub(super) fn ticks(&self) -> impl Iterator<Item = (f64, String)> {
        self.ticks.iter().enumerate().map(|(place, &tick)| {
            let part = (tick - self.low) / (self.high - self.low);
            let text = if let Some(name) = self.names.get(place) {
                name.clone()
            } else if self.is_logarithmic {
                self.power_or_value(tick)
            } else {
                fixed(tick / 10_f64.powi(self.exponent), self.digits)
            };
            (part, text)
        })
    }

    /// A tick of a logarithmic scale: the value where all are short, else a power of ten.
    fn power_or_value(&self, tick: f64) -> String {
        /// Powers of ten that are short as values.
        const SHORT: RangeInclusive<f64> = -3.0..=4.0;
        let is_power = |tick: f64| tick.fract() == 0.0;
        let are_powers = self.ticks.iter().all(|tick| is_power(*tick));
        let value = 10_f64.powf(tick);
        if self.ticks.iter().all(|tick| SHORT.contains(tick)) {
            fixed(value, (-tick.floor()).max(0.0) as usize)
        } else if are_powers || is_power(tick) {
            power_of_ten(tick.round() as i32)
        } else {
            let times = 10_f64.powf(tick - tick.floor());
            format!("{times:.0}·{}", power_of_ten(tick.floor() as i32))
        }
    }

    /// The power of ten of its figures; none where they are the values.
    pub(super) fn power(&self) -> Option<String> {
        (self.exponent != 0).then(|| power_of_ten(self.exponent))
    }

    /// An axis's name, `ε [rad]`, with the power of ten of its figures: `ε [10⁻³ rad]`.
    pub(super) fn named(&self, axis: &str) -> String {
        match (self.power(), axis.rsplit_once('[')) {
            (None, _) => axis.to_owned(),
            (Some(power), Some((name, unit))) => format!("{name}[{power} {unit}"),
            (Some(power), None) => format!("{axis} [{power}]"),
        }
    }
}

/// Two ends that differ.
fn apart(low: f64, high: f64) -> (f64, f64) {
    /// Relative, and at zero.
    const ROOM: (f64, f64) = (0.05, 1e-3);
    if high - low > 1e-9 * low.abs().max(high.abs()) {
        (low, high)
    } else {
        let room = (ROOM.0 * low.abs()).max(ROOM.1);
        (low - room, high + room)
    }
}

/// The next of 1, 2, 5 or 10 times a power of ten.
fn nice(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let times = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|times| step <= times * power * (1.0 + 1e-9));
    times.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::Scale;

    fn texts(scale: &Scale) -> Vec<String> {
        scale.ticks().map(|(_, text)| text).collect()
    }

    #[test]
    fn an_axis_ends_in_ticks() {
        let scale = Scale::around(-0.72, 0.68, 4);
        assert_eq!(texts(&scale), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert!((scale.part(-1.0)).abs() < 1e-12 && (scale.part(1.0) - 1.0).abs() < 1e-12);
        let time = Scale::between(0.0, 59.999, 6);
        assert_eq!(texts(&time).last().map(String::as_str), Some("60"));
        let cut = Scale::between(0.0, 2.4, 5);
        assert_eq!(texts(&cut), ["0.0", "0.5", "1.0", "1.5", "2.0"]);
        assert!((cut.part(2.4) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn small_figures_are_taken_times_a_power_of_ten() {
        let scale = Scale::around(-5.3e-4, 7.6e-4, 4);
        assert_eq!(scale.named("ε [rad]"), "ε [10⁻³ rad]");
        assert_eq!(texts(&scale), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(Scale::around(0.0, 300.0, 4).named("b [1/s]"), "b [1/s]");
    }

    #[test]
    fn a_curve_without_extent_has_room() {
        for value in [0.0, 258.0, -1e-7] {
            let scale = Scale::around(value, value, 4);
            assert!((0.0..=1.0).contains(&scale.part(value)), "{value}");
            assert!(texts(&scale).len() >= 2);
        }
    }

    #[test]
    fn a_logarithmic_axis_ends_beside_its_values() {
        let written = |low, high| texts(&Scale::logarithmic(low, high));
        assert_eq!(written(1.3, 19.0), ["1", "2", "5", "10", "20"]);
        assert_eq!(written(0.4, 0.625), ["0.2", "0.5", "1"]);
        assert_eq!(written(0.7, 499.0), ["1", "10", "100"]);
        assert_eq!(
            written(1e-5, 0.58),
            ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "10⁰"]
        );
        assert_eq!(written(1.1e-5, 3e-5), ["10⁻⁵", "2·10⁻⁵", "5·10⁻⁵"]);
        assert_eq!(
            written(1e-12, 1e-2),
            ["10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴", "10⁻²"]
        );
        let scale = Scale::logarithmic(1.3, 19.0);
        assert!(scale.part(1.3) > 0.0 && scale.part(19.0) < 1.0);
        for (low, high) in [(1e-30, 1e30), (1.0, 1.0), (2.0, 2.0)] {
            let ticks = written(low, high).len();
            assert!((2..=7).contains(&ticks), "{low} to {high}: {ticks}");
        }
    }
}
