use crate::number::Number;

/// Measures a step of the reference sample by sample, alike for a prediction and on the machine.
///
/// Positions count from the servo's first position, positive towards the step, in any unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepMeasure<N> {
    begin: N,
    end: N,
    step: N,
    band: N,
    /// Between which samples the two levels of the rise were passed.
    passed: [Option<Passing<N>>; 2],
    peak: N,
    last: N,
    samples: u32,
    /// The sample since which the position has been in the band.
    settled: Option<u32>,
}

/// Two successive positions, the second at or beyond a level.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Passing<N> {
    sample: u32,
    before: N,
    at: N,
}

impl<N: Number> StepMeasure<N> {
    /// The part of the step within which it has settled.
    pub const BAND: f64 = 0.02;

    /// The least that the band is to each side, counts.
    pub const MIN_BAND_COUNTS: f64 = 2.0;

    /// The levels between which the rise is timed, parts of the step.
    pub const LEVELS: [f64; 2] = [0.1, 0.9];

    /// A step, above zero, for a sensor of this resolution, in the same unit. Zero means an ideal sensor.
    #[must_use]
    pub fn new(step: f64, count: f64) -> Self {
        let [begin, end] = Self::LEVELS.map(|level| N::from_f64(level * step));
        Self {
            begin,
            end,
            step: N::from_f64(step),
            band: N::from_f64((Self::BAND * step).max(Self::MIN_BAND_COUNTS * count)),
            passed: [None; 2],
            peak: N::ZERO,
            last: N::ZERO,
            samples: 0,
            settled: None,
        }
    }

    /// Takes the position of a sample; the first is that at which the reference steps.
    #[inline]
    pub fn take(&mut self, position: N) {
        for (level, passed) in [self.begin, self.end].into_iter().zip(&mut self.passed) {
            if passed.is_none() && position >= level {
                *passed = Some(Passing {
                    sample: self.samples,
                    before: self.last,
                    at: position,
                });
            }
        }
        if position > self.peak {
            self.peak = position;
        }
        let away = position - self.step;
        if away.magnitude() > self.band {
            self.settled = None;
        } else if self.settled.is_none() {
            self.settled = Some(self.samples);
        }
        self.last = position;
        self.samples = self.samples.saturating_add(1);
    }

    /// The rise time from 10 to 90 % of the step, samples, interpolated; none before it is reached.
    #[must_use]
    pub fn rise(&self) -> Option<N> {
        let [begin, end] = self.passed;
        let (begin, end) = (begin?, end?);
        let samples = end.sample.saturating_sub(begin.sample).min(i32::MAX as u32);
        Some(N::from_count(samples as i32) + begin.early(self.begin) - end.early(self.end))
    }

    /// The samples since it reached each of the levels; none before that.
    #[must_use]
    pub fn since(&self) -> [Option<u32>; 2] {
        let taken = |passing: Passing<N>| self.samples.saturating_sub(passing.sample);
        self.passed.map(|passed| passed.map(taken))
    }

    /// Beyond the step, a part of it.
    #[must_use]
    pub fn overshoot(&self) -> f64 {
        (self.peak.to_f64() / self.step.to_f64() - 1.0).max(0.0)
    }

    /// True if it was ever beyond a position.
    #[must_use]
    pub fn is_beyond(&self, position: N) -> bool {
        self.peak > position
    }

    /// The settling time to within [`StepMeasure::BAND`] of the step, samples; none if the position is outside.
    #[must_use]
    pub fn settled(&self) -> Option<u32> {
        self.settled
    }

    /// The samples taken.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.samples
    }
}

impl<N: Number> Passing<N> {
    /// The part of a sample by which a level was passed before the second position.
    fn early(&self, level: N) -> N {
        let displacement = self.at - self.before;
        if displacement > N::ZERO {
            (self.at - level) * displacement.reciprocal()
        } else {
            N::ZERO
        }
    }
}

#[cfg(test)]
mod tests {
    use super::StepMeasure;

    #[test]
    fn a_first_order_step_has_its_closed_form() {
        let mut measure = StepMeasure::<f64>::new(2.0, 0.0);
        for k in 0..1000 {
            measure.take(2.0 * (1.0 - (-f64::from(k) / 50.0).exp()));
        }
        let rise = measure.rise().expect("it rose");
        assert!((rise - 50.0 * 9.0_f64.ln()).abs() < 0.05, "{rise}");
        assert_eq!(
            measure.settled(),
            Some((50.0 * 50.0_f64.ln()).ceil() as u32)
        );
        assert!(measure.overshoot().abs() < 1e-12);
    }

    #[test]
    fn overshoot_and_a_late_departure_are_seen() {
        let mut measure = StepMeasure::<f32>::new(100.0, 1.0);
        assert_eq!((measure.rise(), measure.settled()), (None, None));
        for position in [0.0, 50.0, 112.0, 101.0, 100.0, 97.0, 99.0, 98.0] {
            measure.take(position);
        }
        assert!((measure.overshoot() - 0.12).abs() < 1e-6);
        // From 0.2 samples to 1 + 40/62.
        let rise = measure.rise().expect("it rose");
        assert!((rise - (1.0 + 40.0 / 62.0 - 0.2)).abs() < 1e-6, "{rise}");
        assert_eq!(measure.settled(), Some(6));
        assert_eq!(measure.samples(), 8);
    }
}
