use core::f64::consts::TAU;

use identifier_core::number::Complex;

/// The frequencies of a multisine: bins of its measuring window. They are two or more bins apart, so that with a Hann
/// window no line leaks into another.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Lines {
    sample_time: f64,
    /// Samples of the window.
    window: u32,
    bins: [u16; Self::MAX],
    count: usize,
}

impl Lines {
    /// The most lines of a multisine: more would take too much of a sample.
    pub(crate) const MAX: usize = 32;

    /// The window, s.
    const WINDOW: f64 = 0.5;

    /// The lowest frequency of a survey, Hz: below it the loop that holds the servo leaves little of the injection.
    const LOWEST: f64 = 6.0;

    /// The lowest bin of any window: into those below it the mean motion leaks.
    const FIRST_BIN: f64 = Self::LOWEST * Self::WINDOW;

    /// The window of low lines, s, and their lowest and highest frequency, Hz.
    const LONG_WINDOW: f64 = 1.0;
    const LOW: [f64; 2] = [3.0, 60.0];

    /// The least ratio of their frequencies, beside two bins: many lines at even distances add up to pulses.
    const RATIO: f64 = 1.12;

    /// The highest frequency per sample: gains act up to half of the sampling frequency, and a resonance beyond it has its image
    /// below.
    const HIGHEST: f64 = 0.495;

    /// The highest bin.
    fn highest(&self) -> f64 {
        libm::floor(Self::HIGHEST * f64::from(self.window))
    }

    fn within(sample_time: f64, window: f64) -> Self {
        Self {
            sample_time,
            // A cast saturates; a window of a few samples has no line.
            window: libm::round(window / sample_time) as u32,
            ..Self::default()
        }
    }

    /// Midway between these above a frequency, rad/s.
    fn between(&self, lowest: f64) -> Self {
        let mut lines = Self { count: 0, ..*self };
        let lowest = lowest * self.window_time();
        let bins = self.bins.get(..self.count).unwrap_or_default();
        for pair in bins.windows(2) {
            let bin = pair.iter().map(|&bin| 0.5 * f64::from(bin)).sum();
            if bin * TAU > lowest {
                let _ = lines.push(libm::floor(bin));
            }
        }
        lines
    }

    /// Adds a bin above the others; false if it is too high or there is no room.
    fn push(&mut self, bin: f64) -> bool {
        let highest = self.highest();
        let place = self.bins.get_mut(self.count).filter(|_| bin <= highest);
        if let Some(place) = place {
            *place = bin as u16;
            self.count += 1;
            return true;
        }
        false
    }

    /// True if they reach below a survey.
    #[must_use]
    pub(crate) fn are_low(&self) -> bool {
        self.window_time() > 0.5 * (Self::WINDOW + Self::LONG_WINDOW)
    }

    /// Their number.
    #[must_use]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The part of a survey's window that theirs is, at most all of it.
    #[must_use]
    pub(crate) fn part(&self) -> f64 {
        (self.window_time() / Self::WINDOW).min(1.0)
    }

    /// Samples of the window.
    #[must_use]
    pub(crate) fn window(&self) -> u32 {
        self.window
    }

    /// The time of the window, s.
    #[must_use]
    pub(crate) fn window_time(&self) -> f64 {
        f64::from(self.window) * self.sample_time
    }

    /// The window's e^(j2π/n).
    fn window_rotation(&self) -> Complex {
        let (im, re) = libm::sincos(TAU / f64::from(self.window));
        Complex { re, im }
    }

    /// e^(jωT) of every line: powers of the window's, which take a chip less than a sine each.
    pub(crate) fn rotations(&self) -> LineRotations {
        LineRotations {
            lines: *self,
            place: 0,
            bin: 0,
            spacing: self.window_rotation(),
            rotation: Complex::ONE,
        }
    }

    /// The frequencies, rad/s, rising.
    pub(crate) fn frequencies(&self) -> impl Iterator<Item = f64> + '_ {
        let bins = self.bins.get(..self.count).unwrap_or_default();
        let spacing = TAU / self.window_time();
        bins.iter().map(move |&bin| spacing * f64::from(bin))
    }

    /// The frequency of a line, rad/s.
    pub(crate) fn frequency(&self, place: usize) -> Option<f64> {
        let bins = self.bins.get(..self.count)?;
        let spacing = TAU / self.window_time();
        bins.get(place).map(|&bin| spacing * f64::from(bin))
    }
}

/// The choice of lines, one a slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineSearch {
    lines: Lines,
    /// The next bin, and the highest.
    bin: f64,
    highest: f64,
    /// The lines are those between the chosen ones above this frequency, rad/s.
    between: Option<f64>,
}

impl LineSearch {
    /// Logarithmic, from the lowest frequency to the highest, in a part of the usual window.
    #[must_use]
    pub(crate) fn first_pass(sample_time: f64, part: f64) -> Self {
        Self::over(
            Lines::within(sample_time, part * Lines::WINDOW),
            [Lines::LOWEST, f64::INFINITY],
            None,
        )
    }

    /// Midway between the lines of a survey above a frequency, rad/s.
    #[must_use]
    pub(crate) fn between(sample_time: f64, part: f64, lowest: f64) -> Self {
        Self {
            between: Some(lowest),
            ..Self::first_pass(sample_time, part)
        }
    }

    /// For the antiresonance of a heavy load on a soft spring, below the lines of a survey or between two of them.
    #[must_use]
    pub(crate) fn low(sample_time: f64) -> Self {
        let lines = Lines::within(sample_time, Lines::LONG_WINDOW);
        Self::over(lines, Lines::LOW, None)
    }

    /// Logarithmic between two frequencies, Hz.
    fn over(lines: Lines, [lowest, highest]: [f64; 2], between: Option<f64>) -> Self {
        Self {
            lines,
            bin: libm::ceil(lowest * lines.window_time()).max(Lines::FIRST_BIN),
            highest: libm::floor(highest * lines.window_time()).min(lines.highest()),
            between,
        }
    }

    /// Chooses the next line; all of them once there are no more.
    pub(crate) fn work(&mut self) -> Option<Lines> {
        let Self {
            lines,
            bin,
            highest,
            ..
        } = self;
        if *bin <= *highest && lines.push(*bin) {
            let left = (Lines::MAX - lines.count) as f64;
            let range = libm::log(*highest / *bin);
            let steps = libm::floor(range / libm::log(Lines::RATIO)).min(left);
            let ratio = libm::exp(range / steps.max(1.0));
            *bin = libm::round(*bin * ratio).max(*bin + 2.0);
            return None;
        }
        Some(
            self.between
                .map_or(self.lines, |lowest| self.lines.between(lowest)),
        )
    }

    /// All of them at once.
    #[cfg(test)]
    pub(crate) fn all(mut self) -> Lines {
        loop {
            if let Some(lines) = self.work() {
                return lines;
            }
        }
    }
}

/// The rotations of lines, one after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineRotations {
    lines: Lines,
    /// The next line, the bin of the last and its rotation.
    place: usize,
    bin: u16,
    spacing: Complex,
    rotation: Complex,
}

impl LineRotations {
    /// The window's e^(j2π/n).
    pub(crate) fn spacing(&self) -> [f64; 2] {
        [self.spacing.re, self.spacing.im]
    }
}

impl Iterator for LineRotations {
    type Item = Complex;

    fn next(&mut self) -> Option<Complex> {
        let bins = self.lines.bins.get(..self.lines.count)?;
        let bin = *bins.get(self.place)?;
        self.rotation = self.rotation * self.spacing.raised(u32::from(bin - self.bin));
        (self.place, self.bin) = (self.place + 1, bin);
        Some(self.rotation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn lines_reach_from_6_hz_to_half_of_the_sampling_frequency_and_are_two_bins_apart() {
        for sample_time in [4e-3, 1e-3, 2.5e-4, 1e-4, 5e-5] {
            let lines = LineSearch::first_pass(sample_time, 1.0).all();
            let hertz: Vec<f64> = lines.frequencies().map(|omega| omega / TAU).collect();
            let bin = 1.0 / lines.window_time();
            assert!(
                hertz.len() > 18 && hertz.len() <= Lines::MAX,
                "{}",
                hertz.len()
            );
            assert!(hertz.windows(2).all(|pair| pair[1] - pair[0] > 1.9 * bin));
            assert!((5.9..7.0).contains(&hertz[0]), "{hertz:?}");
            let last = sample_time * hertz[hertz.len() - 1];
            assert!((0.48..0.4951).contains(&last), "{last}");
            assert_eq!(hertz.len(), lines.count());
        }
        assert_eq!(LineSearch::first_pass(0.1, 1.0).all().count(), 0);
        assert_eq!(LineSearch::first_pass(10.0, 1.0).all().count(), 0);
    }

    #[test]
    fn further_lines_stand_between_those_of_a_survey_above_a_frequency() {
        for sample_time in [4e-3, 1e-3, 1e-4, 5e-5] {
            let first_pass: Vec<f64> = LineSearch::first_pass(sample_time, 1.0)
                .all()
                .frequencies()
                .collect();
            let lowest = first_pass[9] + 1.0;
            let between: Vec<f64> = LineSearch::between(sample_time, 1.0, lowest)
                .all()
                .frequencies()
                .collect();
            let gaps: Vec<_> = first_pass.windows(2).skip(9).collect();
            assert_eq!(between.len(), gaps.len());
            for (line, gap) in between.iter().zip(gaps) {
                let part = (line - gap[0]) / (gap[1] - gap[0]);
                assert!((0.3..0.501).contains(&part), "{sample_time}: {part}");
            }
        }
    }

    #[test]
    fn rotations_are_those_of_the_frequencies() {
        for sample_time in [4e-3, 1e-3, 2.5e-4, 1e-4, 5e-5] {
            let lines = LineSearch::first_pass(sample_time, 1.0).all();
            let both = lines.rotations().zip(lines.frequencies());
            let mut compared = 0;
            for (rotation, omega) in both {
                let (sine, cosine) = (omega * sample_time).sin_cos();
                // A power of the window's turn, whose rounding it has as often.
                let rounding = f64::EPSILON * omega * lines.window_time() / TAU + 1e-15;
                assert!((rotation.re - cosine).abs() < rounding, "{omega}");
                assert!((rotation.im - sine).abs() < rounding, "{omega}");
                compared += 1;
            }
            assert_eq!(compared, lines.count());
        }
    }
}
