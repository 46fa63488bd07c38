use core::f64::consts::TAU;

use identifier_core::number::Complex;
use identifier_core::tuning::{Mode, PossibleServo, SampledServo};

/// The unknowns of a response: ln b, the delay and the current loop's time constant in samples, viscous friction a
/// (1/s), ln ω, ln ζ, ln β.
pub(super) type Unknowns = [f64; UNKNOWNS];
pub(super) const UNKNOWNS: usize = 7;
pub(super) const GAIN: usize = 0;
pub(super) const DELAY: usize = 1;
pub(super) const LAG: usize = 2;
pub(super) const FRICTION: usize = 3;
pub(super) const FREQUENCY: usize = 4;
pub(super) const DAMPING: usize = 5;
pub(super) const RATIO: usize = 6;

/// The sampled response of one mass or two behind a delay and a current loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ResponseModel {
    servo: SampledServo,
    /// Time constant of the current loop, samples. Its 1/(1 + jωT_c) multiplies the sampled response. The first image
    /// has that of its own frequency.
    lag: f64,
    /// b T², the delay in samples and the mode with its frequency per sample, for the image.
    gain: f64,
    delay: f64,
    mode: Option<Mode>,
}

/// The servo with these unknowns, without its lag.
pub(super) fn servo(unknowns: &Unknowns, sample_time: f64) -> PossibleServo {
    PossibleServo {
        a: unknowns[FRICTION],
        b: libm::exp(unknowns[GAIN]),
        delay: unknowns[DELAY] * sample_time,
    }
}

/// Its mode.
pub(super) fn mode(unknowns: &Unknowns) -> Mode {
    Mode {
        frequency: libm::exp(unknowns[FREQUENCY]),
        damping: libm::exp(unknowns[DAMPING]),
        ratio: libm::exp(unknowns[RATIO]),
    }
}

impl ResponseModel {
    pub(super) fn new(unknowns: &Unknowns, two_masses: bool, sample_time: f64) -> Self {
        let mode = two_masses.then(|| mode(unknowns));
        let servo = servo(unknowns, sample_time);
        Self {
            servo: SampledServo::new(&servo, mode.as_ref(), sample_time),
            lag: unknowns[LAG],
            gain: servo.b * sample_time * sample_time,
            delay: unknowns[DELAY],
            mode: mode.map(|mode| Mode {
                frequency: mode.frequency * sample_time,
                ..mode
            }),
        }
    }

    /// True for a model of two masses.
    pub(super) fn has_two_masses(&self) -> bool {
        self.mode.is_some()
    }

    /// At an angle ωT.
    pub(super) fn at(&self, angle: f64) -> Complex {
        let lag = |angle: f64| Complex {
            re: 1.0,
            im: self.lag * angle,
        };
        let image = angle - TAU;
        let held = self.held(image);
        let others = self.servo.at(libm::tan(0.5 * angle)) - held;
        others / lag(angle) + held / lag(image)
    }

    /// The continuous response behind the hold, without the lag.
    fn held(&self, angle: f64) -> Complex {
        let s = Complex { re: 0.0, im: angle };
        let square = s * s;
        let together = Complex::ONE / square;
        let moved = self.mode.map_or(together, |mode| {
            let damped = s.scaled(2.0 * mode.damping * mode.frequency);
            let denominator = square + damped + mode.frequency * mode.frequency;
            together + Complex::ONE.scaled(mode.ratio) / denominator
        });
        let hold = (Complex::ONE - s.scaled(-1.0).exponential()) / s;
        (hold * moved * s.scaled(-self.delay).exponential()).scaled(self.gain)
    }
}
