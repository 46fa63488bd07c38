use super::Tuning;
use super::placement::Design;
use super::sampled_response::{SampledController, nu_at};
use crate::number::Complex;

/// A line of a measured frequency response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredLine {
    /// ω, rad/s.
    pub frequency: f64,
    /// From the command to the position, rad per command unit, as the samples show it.
    pub gain: Complex,
    /// Standard deviation of its absolute value, rad per command unit.
    pub deviation: f64,
}

impl MeasuredLine {
    /// Standard deviations by which a loop must keep its distance from −1.
    const DEVIATIONS: f64 = 1.5;

    /// Relative deviation up to which a line is a measurement of the loop.
    const SURE: f64 = 0.4;

    /// The largest gain that an uncertain line may add to the loop. The second is the loop gain that stays away from −1
    /// at any phase.
    const UNCERTAIN: f64 = 0.8;
    const FAR: f64 = 0.3;

    /// The ratio to the gain crossover up to which the model replaces an uncertain line. Friction and rounding blur
    /// such a line; resonances show at higher ones.
    const BELOW: f64 = 1.2;

    /// |S| of gains on this line and its standard deviation, |S|² |C| times that of the gain; none from half of the sampling
    /// frequency on. The sample time is in s.
    #[must_use]
    pub fn sensitivity(&self, tuning: &Tuning, sample_time: f64) -> Option<[f64; 2]> {
        let nu = nu_at(self.frequency, sample_time)?;
        let controller = SampledController::of(&Design::from_tuning(tuning), sample_time, nu);
        let sensitivity = 1.0 / libm::sqrt((controller * self.gain + 1.0).power());
        let deviation = libm::sqrt(controller.power()) * self.deviation;
        Some([sensitivity, sensitivity * sensitivity * deviation])
    }

    /// True if C G keeps the distance from −1 on this line that the largest sensitivity demands. An uncertain line
    /// counts only where it could matter. `crossover` is the gain crossover (rad/s).
    pub(super) fn allows(&self, controller: Complex, crossover: f64, max_sensitivity: f64) -> bool {
        let size = libm::sqrt(self.gain.power());
        let gain = libm::sqrt(controller.power());
        let unsure = gain * self.deviation;
        if self.deviation < Self::SURE * size {
            let distance = libm::sqrt((controller * self.gain + 1.0).power());
            distance - Self::DEVIATIONS * unsure >= 1.0 / max_sensitivity
        } else {
            self.frequency < Self::BELOW * crossover
                || 2.0 * unsure < Self::UNCERTAIN
                || gain * size < Self::FAR
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{IdentifiedServo, ServoParameters};
    use crate::tuning::{Mode, Resonance, Tuner, TuningSettings};

    const SAMPLE_TIME: f64 = 1e-4;

    /// b (1/s² + β/(s² + 2ζω₂s + ω₂²)) e^(−1.5 sT) at s = jω. The hold delays by half of a sample, the reading by one.
    fn two_masses(b: f64, mode: &Mode, omega: f64) -> Complex {
        let number = |re, im| Complex { re, im };
        let square = mode.frequency * mode.frequency - omega * omega;
        let damped = number(square, 2.0 * mode.damping * mode.frequency * omega);
        let sum = number(mode.ratio, 0.0) / damped + number(-1.0 / (omega * omega), 0.0);
        sum * number(0.0, -1.5 * omega * SAMPLE_TIME)
            .exponential()
            .scaled(b)
    }

    #[test]
    fn a_line_of_two_masses_has_the_sensitivity_of_the_servo_that_was_identified() {
        let mode = Mode {
            frequency: 900.0,
            damping: 0.02,
            ratio: 0.8,
        };
        let resonance = Resonance {
            mode,
            errors: [0.001, 0.1],
            friction_on_motor: false,
        };
        let servo = IdentifiedServo::known(ServoParameters::new(0.0, 100.0, 0.0, 0.0), SAMPLE_TIME);
        let settings = TuningSettings::new(SAMPLE_TIME, 1e-5, 10.0, 0.1);
        let tuner = Tuner::for_response(&settings, &servo, Some(&resonance)).expect("a servo");
        let mut state = tuner.start();
        let tuning = core::iter::from_fn(|| Some(tuner.work(&mut state)));
        let tuning = tuning.flatten().next().expect("it ends").expect("gains");
        for omega in [20.0, 100.0, 500.0, 850.0, 900.0, 950.0] {
            let gain = two_masses(100.0, &mode, omega);
            let of = |frequency, gain, deviation| {
                let line = MeasuredLine {
                    frequency,
                    gain,
                    deviation,
                };
                line.sensitivity(&tuning, SAMPLE_TIME)
            };
            let beyond = 1.01 * core::f64::consts::PI / SAMPLE_TIME;
            assert_eq!(of(beyond, Complex::ONE, 0.0), None);
            let line = |gain, deviation| of(omega, gain, deviation).expect("below half");
            let [here, none] = line(gain, 0.0);
            let [identified, worst] = tuner.sensitivity(&tuning, omega).expect("likewise");
            let off = here / identified - 1.0;
            assert!(off.abs() < 0.01, "{omega}: {here} {identified}");
            assert!(none.abs() < f64::EPSILON && worst >= identified, "{omega}");
            // The gain moved by a deviation in any direction: the largest change.
            let size = 1e-4 * libm::sqrt(gain.power());
            let moved = |k: i32| {
                let im = 0.02 * f64::from(k) * core::f64::consts::PI;
                let by = Complex { re: 0.0, im }.exponential().scaled(size);
                (line(gain + by, 0.0)[0] - here).abs()
            };
            let largest = (0..100).map(moved).fold(0.0, f64::max);
            let [_, deviation] = line(gain, size);
            let off = deviation / largest - 1.0;
            assert!(off.abs() < 0.01, "{omega}: {deviation} {largest}");
        }
    }
}
