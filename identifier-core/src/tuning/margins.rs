//! Margins and stability of a loop, from one sweep of its frequency response.
//!
//! The open loop has no pole outside the unit circle. At z = 1 it has two, or three if a = 0. D = open + forward is its
//! characteristic function, of degree N. D has no root outside if and only if its argument grows by N π from z = 1 to
//! z = −1. This is the principle of the argument, or Mikhailov's criterion in discrete time. The argument of `open` is
//! known, so this is a condition on 1 + L. Count the crossings of L over the real axis left of −1: those upwards in
//! phase, less those downwards. Begin where D is still real and positive. The count must be one if L begins with Im L >
//! 0, and zero otherwise.
//!
//! No root is missed between two points: L moves by less than three quarters of its distance from −1. The sweep
//! begins at a frequency at which D has not moved by half of its value at z = 1. It ends where |L| is so small that
//! it can encircle nothing. At a resonance the points are as close as the resonance is narrow. L then moves by less
//! than a third of its distance, and the sweep ends beyond the resonance.

use super::sampled_response::SampledResponse;
use crate::number::Complex;

/// Margins of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Margins {
    /// Mₛ, the largest |1/(1 + L)|.
    pub(super) sensitivity: f64,
    /// The factors by which the gain may fall, zero for any, and rise.
    pub(super) gain: [f64; 2],
}

impl Margins {
    /// The largest gain margin that is looked for; one that is larger counts as this.
    pub(super) const MAX_GAIN: f64 = 50.0;

    /// The margins of a loop that tolerates everything.
    pub(super) const AMPLE: Self = Self {
        sensitivity: 1.0,
        gain: [0.0, Self::MAX_GAIN],
    };

    /// The margins that two loops both have.
    pub(super) fn both(self, other: Self) -> Self {
        Self {
            sensitivity: self.sensitivity.max(other.sensitivity),
            gain: [
                self.gain[0].max(other.gain[0]),
                self.gain[1].min(other.gain[1]),
            ],
        }
    }
}

/// A sweep of the frequency response of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrequencySweep {
    response: SampledResponse,
    /// The least |1 + L|² that is allowed.
    least: f64,
    /// The resonance and its width.
    resonance: Option<(f64, f64)>,
    nu: f64,
    /// ν of the point before, and the step from there to the next that is tried.
    from: f64,
    step: f64,
    left: u32,
    last: Option<Last>,
    margins: Margins,
    /// Upward crossings left of −1 that are still to come.
    awaited: i32,
    falling: bool,
}

/// The two previous points.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Last {
    gain: Complex,
    /// |1 + L|² at the last two points.
    distances: [f64; 2],
}

/// Continuation of a sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Progress {
    /// There are more points.
    Continues,
    /// The loop is stable, and within the largest sensitivity.
    Passes(Margins),
    /// It is not.
    Fails,
}

impl FrequencySweep {
    /// The ratio of successive frequencies, 2^(1/8). A peak of the sensitivity is put through three
    /// points.
    const RATIO: f64 = 1.090_507_732_665_257_7;

    /// The largest ν of a sweep; z is then −1 to within 2 %.
    const LAST: f64 = 100.0;

    /// The part of its distance from −1 by which L may move between two points at a resonance. The distance between
    /// them then has an error of 2 %.
    const RESONANT_MOVE: f64 = 0.3;

    /// The next point near a resonance, as a part of the distance to it and of its width.
    const APPROACH: f64 = 0.4;

    /// The largest number of points of a sweep past a resonance. A design that needs more is rejected.
    const MAX_POINTS: u32 = 800;

    /// Begins at a frequency far below the loop's poles, rad per sample.
    pub(super) fn begin(response: SampledResponse, first: f64, max_sensitivity: f64) -> Self {
        Self {
            response,
            resonance: response.resonance(),
            least: 1.0 / (max_sensitivity * max_sensitivity),
            nu: 0.5 * first,
            from: 0.0,
            step: 0.0,
            left: Self::MAX_POINTS,
            last: None,
            margins: Margins::AMPLE,
            awaited: 0,
            falling: false,
        }
    }

    /// One frequency.
    pub(super) fn work(&mut self) -> Progress {
        let point = self.response.at(self.nu);
        let gain = point.gain();
        let distance = (gain + 1.0).power();
        self.left = self.left.saturating_sub(1);
        let far_enough = distance >= self.least;
        if !far_enough || self.left == 0 {
            return Progress::Fails;
        }
        let distances = match self.last {
            None => {
                let moved = (point.open + point.forward).scaled(1.0 / self.response.at_rest())
                    - Complex::ONE;
                if moved.power() > 0.25 {
                    return Progress::Fails;
                }
                self.awaited = i32::from(gain.im > 0.0);
                [distance, distance]
            }
            Some(last) => {
                let step = gain - last.gain;
                let [before, here] = last.distances;
                let nearer = here.min(distance);
                if self.resonance.is_some() {
                    if step.power() > Self::RESONANT_MOVE * Self::RESONANT_MOVE * nearer {
                        return self.retry();
                    }
                    self.margins.sensitivity =
                        (1.0 / libm::sqrt(distance)).max(self.margins.sensitivity);
                } else if step.power() > 0.5625 * nearer {
                    return Progress::Fails;
                }
                self.cross(last.gain, gain);
                if self.resonance.is_none() && here <= before && here < distance {
                    let nearest = lowest([before, here, distance]);
                    if nearest < self.least {
                        return Progress::Fails;
                    }
                    self.margins.sensitivity =
                        (1.0 / libm::sqrt(nearest)).max(self.margins.sensitivity);
                }
                [here, distance]
            }
        };
        self.last = Some(Last { gain, distances });
        let end = self.ends(gain);
        self.proceed();
        end
    }

    /// Goes on to the next point.
    fn proceed(&mut self) {
        let Some((resonance, width)) = self.resonance else {
            self.nu *= Self::RATIO;
            return;
        };
        let near = libm::fabs(self.nu - resonance).max(width);
        self.from = self.nu;
        self.step = ((Self::RATIO - 1.0) * self.nu).min(Self::APPROACH * near);
        self.nu = self.from + self.step;
    }

    /// A point that is nearer to the last one.
    fn retry(&mut self) -> Progress {
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            return Progress::Fails;
        }
        self.step *= 0.5;
        self.nu = self.from + self.step;
        Progress::Continues
    }

    /// Takes in whether L has crossed the negative real axis between two points.
    fn cross(&mut self, from: Complex, to: Complex) {
        if (from.im > 0.0) == (to.im > 0.0) {
            return;
        }
        let at = from.re + (to.re - from.re) * from.im / (from.im - to.im);
        if at < -1.0 {
            self.awaited += if from.im > 0.0 { -1 } else { 1 };
            self.margins.gain[0] = self.margins.gain[0].max(-1.0 / at);
        } else if at * Margins::MAX_GAIN < -1.0 {
            self.margins.gain[1] = self.margins.gain[1].min(-1.0 / at);
            self.falling = true;
        }
    }

    fn ends(&self, gain: Complex) -> Progress {
        /// The search ends when |L| is below this and the phase has passed −180°.
        const SMALL: f64 = 0.1;
        /// Widths and distances beyond a resonance at which it adds little.
        const BEYOND: f64 = 8.0;
        const FURTHER: f64 = 1.5;
        if self.resonance.is_some_and(|(resonance, width)| {
            self.nu < (FURTHER * resonance).max(resonance + BEYOND * width) && self.nu <= Self::LAST
        }) {
            return Progress::Continues;
        }
        let power = gain.power();
        let small = power < SMALL * SMALL && self.falling;
        let negligible = power * Margins::MAX_GAIN * Margins::MAX_GAIN < 1.0;
        if small || negligible {
            if self.awaited == 0 {
                Progress::Passes(self.margins)
            } else {
                Progress::Fails
            }
        } else if self.nu > Self::LAST {
            Progress::Fails
        } else {
            Progress::Continues
        }
    }
}

/// The lowest value of the parabola through three values at equal distances, of which the middle one is the
/// least.
fn lowest([before, here, after]: [f64; 3]) -> f64 {
    let slope = after - before;
    let bend = before - here + (after - here);
    here - slope * slope / (8.0 * bend)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tuning::placement::Design;
    use crate::tuning::possible_servos::PossibleServo;
    use crate::tuning::resonance::Mode;
    use crate::tuning::sampled_response::SampledServo;

    /// Gains that place (s + 40)² (s + 8) around q̈ = 100 u.
    const DESIGN: Design = Design {
        bandwidth: 40.0,
        kp: 22.4,
        kd: 0.88,
        ki: 128.0,
        cutoff: 400.0,
        cutoff_place: 0,
        reference_filter: 0.0,
        notch: 0.0,
        feed_forward: None,
        smoothed: false,
        noise: 0.0,
    };

    /// The gains at 1 kHz with a delay of 2.5 samples, the servo's gain times a factor.
    fn walk(factor: f64) -> Progress {
        let servo = PossibleServo {
            a: 0.0,
            b: 100.0 * factor,
            delay: 2.5e-3,
        };
        let sampled = SampledServo::new(&servo, None, 1e-3);
        end(SampledResponse::around(&DESIGN, sampled, 1e-3))
    }

    /// Nearly any distance from −1 is allowed here, so that the winding alone decides.
    fn end(response: SampledResponse) -> Progress {
        let mut walk = FrequencySweep::begin(response, 0.05e-3, 100.0);
        loop {
            match walk.work() {
                Progress::Continues => {}
                end => return end,
            }
        }
    }

    #[test]
    fn a_loop_beyond_either_margin_is_seen_to_be_unstable_by_its_winding() {
        let Progress::Passes(margins) = walk(1.0) else {
            panic!("it is stable");
        };
        let [fall, rise] = margins.gain;
        for within in [2.0 * fall, 0.5, 2.0, 0.5 * rise] {
            assert!(matches!(walk(within), Progress::Passes(_)), "{within}");
        }
        for beyond in [0.5 * fall, 2.0 * rise, 3.0 * rise] {
            assert_eq!(walk(beyond), Progress::Fails, "{beyond}");
        }
    }

    /// The gains around two masses, at 1 kHz: the sweep, and the largest |1/(1 + L)| on a dense grid of points.
    fn resonant(hertz: f64, damping: f64, ratio: f64) -> (Progress, f64) {
        let servo = PossibleServo {
            a: 0.0,
            b: 100.0,
            delay: 5e-4,
        };
        let mode = Mode {
            frequency: core::f64::consts::TAU * hertz,
            damping,
            ratio,
        };
        let sampled = SampledServo::new(&servo, Some(&mode), 1e-3);
        let response = SampledResponse::around(&DESIGN, sampled, 1e-3);
        let sensitivity = |place| {
            let nu = 1e-3 * libm::exp(2.4e-5 * f64::from(place));
            1.0 / libm::sqrt((response.at(nu).gain() + 1.0).power())
        };
        let largest = (0..400_000).map(sensitivity).fold(0.0, f64::max);
        (end(response), largest)
    }

    #[test]
    fn a_narrow_resonance_is_not_stepped_over() {
        for (hertz, damping, ratio) in [
            (40.0, 0.02, 0.3),
            (90.0, 0.005, 0.1),
            (220.0, 0.004, 0.3),
            (610.0, 0.01, 0.5),
        ] {
            let (Progress::Passes(margins), largest) = resonant(hertz, damping, ratio) else {
                panic!("{hertz} Hz is stable");
            };
            let off = margins.sensitivity / largest - 1.0;
            assert!(off.abs() < 0.03, "{hertz} Hz: {off} of {largest}");
        }
        // Beyond the delay's phase its peak is above one.
        let (end, _) = resonant(220.0, 0.004, 2.0);
        assert_eq!(end, Progress::Fails);
    }
}
