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
    /// A place without a line.
    pub(crate) const NONE: Self = Self {
        frequency: 0.0,
        gain: Complex { re: 0.0, im: 0.0 },
        deviation: 0.0,
    };

    /// Standard deviations by which a loop must keep its distance from −1.
    const DEVIATIONS: f64 = 1.5;

    /// Relative deviation up to which a line is a measurement of the loop.
    const SURE: f64 = 0.4;

    /// The largest gain that an uncertain line may add to the loop, and the loop gain that stays away from −1 at any phase.
    const UNCERTAIN: f64 = 0.8;
    const FAR: f64 = 0.3;

    /// The part of the gain crossover up to which an uncertain line is left to the model: friction and rounding
    /// blur it, resonances show at higher ones.
    const BELOW: f64 = 1.2;

    /// True if a controller with a gain crossover (rad/s) keeps |1 + C G| from −1 on this line for a largest sensitivity, as far as the line is
    /// known.
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
