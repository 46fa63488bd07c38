//! Noise of the position sensor in a record, without a model.

use crate::result::SensorNoise;

/// Samples of a window in which the servo moves or is at standstill.
const WINDOW: usize = 64;

/// Fifth differences, which remove almost all of a motion, and their variance for white noise of variance one.
const DIFFERENCE: [f64; 6] = [-1.0, 5.0, -10.0, 10.0, -5.0, 1.0];
const DIFFERENCE_VARIANCE: f64 = 252.0;

/// Windows without which a deviation is not known.
const MIN_WINDOWS: usize = 4;

/// Squares of the differences in windows of a kind.
#[derive(Debug, Clone, Copy, Default)]
struct Windows {
    count: usize,
    squares: f64,
}

impl Windows {
    fn add(&mut self, squares: f64) {
        self.count += 1;
        self.squares += squares;
    }

    /// Counts; none if there are too few windows.
    fn deviation(self) -> Option<f64> {
        let values = (self.count * (WINDOW - DIFFERENCE.len() + 1)) as f64;
        (self.count >= MIN_WINDOWS).then(|| (self.squares / values / DIFFERENCE_VARIANCE).sqrt())
    }
}

/// Gathers the noise of the position sensor, sample by sample.
#[derive(Debug, Clone)]
pub(crate) struct NoiseMeter {
    /// Rad to a count.
    count: f64,
    /// Positions, counts.
    window: Vec<f64>,
    moving: Windows,
    standing: Windows,
}

impl NoiseMeter {
    /// For an encoder with a count of this size, rad.
    pub(crate) fn new(count: f64) -> Self {
        Self {
            count,
            window: Vec::with_capacity(WINDOW),
            moving: Windows::default(),
            standing: Windows::default(),
        }
    }

    /// Takes in a position, rad; where a motion begins, those before are of another.
    pub(crate) fn add(&mut self, position: f64, begins: bool) {
        if begins {
            self.window.clear();
        }
        self.window.push(position / self.count);
        if self.window.len() < WINDOW {
            return;
        }
        let differences = self.window.windows(DIFFERENCE.len()).map(|values| {
            let products = values.iter().zip(DIFFERENCE);
            let difference: f64 = products.map(|(value, weight)| value * weight).sum();
            difference * difference
        });
        let squares = differences.sum();
        if stands(&self.window, squares) {
            self.standing.add(squares);
        } else {
            self.moving.add(squares);
        }
        self.window.clear();
    }

    /// The noise of all that was taken in.
    pub(crate) fn noise(&self) -> SensorNoise {
        let [moving, standing] = [self.moving, self.standing].map(Windows::deviation);
        SensorNoise {
            moving_counts: moving,
            standstill_counts: standing,
            moving: moving.map(|counts| counts * self.count),
            standstill: standing.map(|counts| counts * self.count),
        }
    }
}

/// True if noise alone explains the difference between the halves of a window. The bound is three deviations of that
/// difference plus a part of a count. Below that part, rounding does not keep the mean at standstill.
fn stands(window: &[f64], squares: f64) -> bool {
    const DEVIATIONS: f64 = 3.0;
    const STANDSTILL_TOLERANCE: f64 = 0.5;
    let values = (window.len() - DIFFERENCE.len() + 1) as f64;
    let noise = (squares / values / DIFFERENCE_VARIANCE).sqrt();
    let (first, second) = window.split_at(window.len() / 2);
    let mean = |half: &[f64]| half.iter().sum::<f64>() / half.len() as f64;
    let of_difference = noise * (4.0 / window.len() as f64).sqrt();
    (mean(second) - mean(first)).abs() <= STANDSTILL_TOLERANCE + DEVIATIONS * of_difference
}

#[cfg(test)]
mod tests {
    use virtual_servo::excitation::NormalSource;

    use super::*;

    /// A motion of some amplitude, counts, with noise, rounded to counts of a hundredth of a rad.
    fn recorded(amplitude: f64, noise: f64) -> SensorNoise {
        let mut source = NormalSource::new(1);
        let mut meter = NoiseMeter::new(0.01);
        for k in 0..20_000 {
            let phase = 0.05 * f64::from(k);
            let place = amplitude * (phase.sin() + 0.3 * (0.37 * phase).cos());
            let count = (place + noise * source.next_normal()).round();
            meter.add(0.01 * count, k == 0);
        }
        meter.noise()
    }

    #[test]
    fn noise_of_a_motion_is_found_within_five_per_cent_beside_rounding() {
        for noise in [0.0, 0.5, 1.0, 3.0, 10.0_f64] {
            let found = recorded(3000.0, noise).moving_counts.expect("it moves");
            let off = found / noise.hypot(12.0_f64.sqrt().recip()) - 1.0;
            assert!(off.abs() < 0.05, "{noise}: {found}");
        }
    }

    #[test]
    fn what_stands_has_the_noise_of_standstill_and_none_of_motion() {
        let still = recorded(0.0, 0.0);
        let found = (still.standstill_counts, still.moving_counts);
        assert_eq!(found, (Some(0.0), None));
        let noisy = recorded(0.0, 2.0).standstill_counts.expect("it stands");
        assert!((noisy - 2.0).abs() < 0.1, "{noisy}");
    }
}
