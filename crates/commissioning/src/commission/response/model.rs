use core::f64::consts::TAU;

use identifier_core::number::Complex;
use identifier_core::tuning::{MeasuredLine, Mode, PossibleServo, SampledServo};

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

/// The sampled response of one mass or two behind a delay and a current loop. It is computed in single precision, whose
/// rounding is far below the error of any measured line, and built in double precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ResponseModel {
    servo: SampledServo<f32>,
    /// Time constant of the current loop, samples. Its 1/(1 + jωT_c) multiplies the sampled response. The first image
    /// has that of its own frequency.
    lag: f32,
    /// b T², the delay in samples, and 2ζω, ω² and β of the mode in samples, for the image.
    gain: f32,
    delay: f32,
    mode: Option<[f32; 3]>,
}

/// Where a line lies in the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// ωT, and that of the first image.
    angle: f32,
    image: f32,
    /// e^(jωT) − 1.
    delta: Complex<f32>,
}

impl Place {
    pub(super) fn of(line: &MeasuredLine, sample_time: f64) -> Self {
        let angle = line.frequency * sample_time;
        let (sine, cosine) = libm::sincos(0.5 * angle);
        let delta = Complex {
            re: -2.0 * sine * sine,
            im: 2.0 * sine * cosine,
        };
        Self {
            angle: angle as f32,
            image: (angle - TAU) as f32,
            delta: delta.to(),
        }
    }
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
        let servo = servo(unknowns, sample_time);
        let one = Self::of(&servo, unknowns[LAG], sample_time);
        match two_masses {
            true => one.with_mode(servo.delay, &mode(unknowns), sample_time),
            false => one,
        }
    }

    /// Of one mass with a lag in samples.
    pub(super) fn of(servo: &PossibleServo, lag: f64, sample_time: f64) -> Self {
        Self {
            servo: SampledServo::new(servo, None, sample_time).single(),
            lag: lag as f32,
            gain: (servo.b * sample_time * sample_time) as f32,
            delay: (servo.delay / sample_time) as f32,
            mode: None,
        }
    }

    /// With another lag, samples.
    pub(super) fn with_lag(self, lag: f64) -> Self {
        Self {
            lag: lag as f32,
            ..self
        }
    }

    /// With a second mass, behind the same delay, s.
    pub(super) fn with_mode(self, delay: f64, mode: &Mode, sample_time: f64) -> Self {
        let frequency = mode.frequency * sample_time;
        let damped = 2.0 * mode.damping * frequency;
        Self {
            servo: self.servo.with_mode(delay, mode, sample_time),
            mode: Some([damped, frequency * frequency, mode.ratio].map(|part| part as f32)),
            ..self
        }
    }

    /// True for a model of two masses.
    pub(super) fn has_two_masses(&self) -> bool {
        self.mode.is_some()
    }

    /// At the place of a line.
    pub(super) fn at(&self, place: &Place) -> Complex<f32> {
        let lag = |angle: f32| Complex {
            re: 1.0,
            im: self.lag * angle,
        };
        let held = self.held(place);
        let others = self.servo.at_delta(place.delta) - held;
        others / lag(place.angle) + held / lag(place.image)
    }

    /// The continuous response behind the hold at the first image, without the lag.
    fn held(&self, Place { image, delta, .. }: &Place) -> Complex<f32> {
        let square = -image * image;
        let together = Complex {
            re: 1.0 / square,
            im: 0.0,
        };
        let moved = self.mode.map_or(together, |[damped, stiffness, ratio]| {
            let denominator = Complex {
                re: square + stiffness,
                im: damped * image,
            };
            together + Complex::ONE.scaled(ratio) / denominator
        });
        // (1 − e^(−s))/s, of which e^(−s) is that of the line.
        let late = delta.conjugate();
        let hold = Complex {
            re: -late.im / image,
            im: late.re / image,
        };
        let (sine, cosine) = libm::sincosf(image * self.delay);
        let delay = Complex {
            re: cosine,
            im: -sine,
        };
        (hold * moved * delay).scaled(self.gain)
    }
}
