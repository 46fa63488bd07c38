use crate::number::Complex;
use crate::tuning::{Mode, PossibleServo, SampledServo};

/// The unknowns of a response: ln b, the delay and the current loop's time constant in samples, viscous friction a (1/s), ln ω,
/// ln ζ and ln β.
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
    /// Time constant of the current loop, samples. Its 1/(1 + jωT_c) multiplies the sampled response, which is exact far
    /// below the sampling frequency; the difference of the images above looks like a part of the delay.
    lag: f64,
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
        }
    }

    /// At an angle ωT.
    pub(super) fn at(&self, angle: f64) -> Complex {
        let lag = Complex {
            re: 1.0,
            im: self.lag * angle,
        };
        self.servo.at(libm::tan(0.5 * angle)) / lag
    }
}
