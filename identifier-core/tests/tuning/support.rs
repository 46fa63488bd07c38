//! An independent model of a loop: its frequency response from the textbook's formulas, and its motion by the
//! servo that the core is judged by.

use identifier_core::control::{
    CommandLimit, ControlState, Controller, Gains, Shaped, ShapedState,
};
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::parameters::IdentifiedServo;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::ControllerSettings;
use identifier_core::tuning::{StepMeasure, Tuner, Tuning, TuningError, TuningSettings};
use identifier_core::units::Units;
use virtual_servo::{Effects, Encoder, Servo};

/// A servo that is known with these standard errors of a, b and the delay, each on its own.
pub(crate) fn identified(
    parameters: ServoParameters,
    delay: f64,
    [a, b, of_delay]: [f64; 3],
) -> IdentifiedServo {
    IdentifiedServo::known(parameters, delay).with_errors([a, b, 0.0, of_delay, 0.0])
}

/// A servo and its delay, s.
pub(crate) type Candidate = (ServoParameters, f64);

/// The servo and those three standard errors away from it.
pub(crate) fn candidates(servo: &IdentifiedServo) -> Vec<Candidate> {
    let nominal = (servo.parameters, servo.delay);
    let mut all = vec![nominal];
    for sign in [3.0, -3.0] {
        for place in [
            IdentifiedServo::A,
            IdentifiedServo::B,
            IdentifiedServo::DELAY,
        ] {
            let far = sign * servo.standard_error(place);
            let (mut parameters, mut delay) = nominal;
            match place {
                IdentifiedServo::A => parameters.a = (parameters.a + far).max(0.0),
                IdentifiedServo::B => parameters.b += far,
                _ => delay = (delay + far).max(0.0),
            }
            all.push((parameters, delay));
        }
    }
    all
}

/// The result, and its number of slices of work.
pub(crate) fn tuned(
    settings: &TuningSettings,
    servo: &IdentifiedServo,
) -> (Result<Tuning, TuningError>, u32) {
    let tuner = match Tuner::new(settings, servo) {
        Ok(tuner) => tuner,
        Err(error) => return (Err(error), 0),
    };
    let mut state = tuner.start();
    for slices in 1.. {
        if let Some(result) = tuner.work(&mut state) {
            return (result, slices);
        }
    }
    unreachable!("it ends");
}

/// Real and imaginary part.
type Complex = (f64, f64);

fn times((a, b): Complex, (c, d): Complex) -> Complex {
    (a * c - b * d, a * d + b * c)
}

fn over(x: Complex, (c, d): Complex) -> Complex {
    let (re, im) = times(x, (c, -d));
    let size = c * c + d * d;
    (re / size, im / size)
}

/// L at ω, the loop opened at the command: the transfer matrix of the servo sampled by hand, C (zI − Φ)⁻¹ Γ,
/// times the controller's transfer function.
pub(crate) fn loop_gain(
    tuning: &Tuning,
    sample_time: f64,
    servo: &Candidate,
    omega: f64,
) -> Complex {
    let (ServoParameters { a, b, .. }, delay) = *servo;
    let z_to = |samples: f64| {
        let angle = omega * sample_time * samples;
        (angle.cos(), angle.sin())
    };
    // Contribution of a force over the last `time` of a sample to position and velocity.
    let added = |time: f64| -> [f64; 2] {
        if a * time < 1e-5 {
            [
                time * time / 2.0 * (1.0 - a * time / 3.0),
                time * (1.0 - a * time / 2.0),
            ]
        } else {
            let velocity = -(-a * time).exp_m1() / a;
            [(time - velocity) / a, velocity]
        }
    };
    let whole = (delay / sample_time).floor();
    let part = delay / sample_time - whole;
    let all = added(sample_time);
    let newer = added((1.0 - part) * sample_time);
    let input = |i: usize| {
        let late = z_to(-whole);
        let later = z_to(-whole - 1.0);
        (
            b * (newer[i] * late.0 + (all[i] - newer[i]) * later.0),
            b * (newer[i] * late.1 + (all[i] - newer[i]) * later.1),
        )
    };
    let (re, im) = z_to(1.0);
    let decay = (-a * sample_time).exp();
    let velocity = over(input(1), (re - decay, im));
    let forced = (
        input(0).0 + all[1] * velocity.0,
        input(0).1 + all[1] * velocity.1,
    );
    let position = over(forced, (re - 1.0, im));

    let p = (-tuning.cutoff * sample_time).exp();
    let difference = (1.0 - z_to(-1.0).0, -z_to(-1.0).1);
    let filter = over(
        ((1.0 - p) / sample_time * re, (1.0 - p) / sample_time * im),
        (re - p, im),
    );
    let derivative = times(filter, difference);
    let integral = over((tuning.ki * sample_time, 0.0), (re - 1.0, im));
    let controller = (
        tuning.kp + tuning.kd * derivative.0 + integral.0,
        tuning.kd * derivative.1 + integral.1,
    );
    times(position, controller)
}

/// The largest |1/(1 + L)| on a dense grid of frequencies.
pub(crate) fn sensitivity(tuning: &Tuning, sample_time: f64, servo: &Candidate) -> f64 {
    const POINTS: u32 = 4000;
    let (low, high) = (tuning.bandwidth / 100.0, std::f64::consts::PI / sample_time);
    (0..=POINTS)
        .map(|i| low * (high / low).powf(f64::from(i) / f64::from(POINTS)))
        .map(|omega| {
            let (re, im) = loop_gain(tuning, sample_time, servo, omega);
            1.0 / (1.0 + re).hypot(im)
        })
        .fold(0.0, f64::max)
}

/// A loop that runs: the core's controller around the virtual servo.
pub(crate) struct Bench {
    controller: Controller<f64, LowPass<f64>, Shaped<f64>>,
    state: ControlState<f64, <LowPass<f64> as VelocityEstimate<f64>>::State, ShapedState<f64>>,
    servo: Servo,
    encoder: Option<(Encoder, f64)>,
    measured: f64,
    /// Where within a count it begins, rad.
    offset: f64,
}

impl Bench {
    /// At rest; the integral holds `held`, command units.
    pub(crate) fn new(
        tuning: &Tuning,
        settings: &TuningSettings,
        (parameters, delay): &Candidate,
        held: f64,
    ) -> Self {
        let effects = Effects {
            delay: *delay,
            ..Effects::NONE
        };
        Self::of(tuning, settings, parameters, &effects, held)
    }

    /// The same of a servo with effects.
    pub(crate) fn of(
        tuning: &Tuning,
        settings: &TuningSettings,
        parameters: &ServoParameters,
        effects: &Effects,
        held: f64,
    ) -> Self {
        let TuningSettings {
            sample_time,
            resolution,
            command,
            ..
        } = *settings;
        let range = [-command, command];
        let limit = CommandLimit::from_range(range).expect("valid");
        let units = Units::new(sample_time, 1.0).expect("valid");
        let gains = Gains::new(tuning.kp, tuning.kd, tuning.ki).expect("valid");
        let state = ControlState::default();
        let velocity = LowPass::new(&units, tuning.cutoff).expect("valid");
        let pid = ControllerSettings::tuned(tuning, range);
        let shaping = pid.shaping(&units, &velocity.transfer()).expect("valid");
        Self {
            controller: Controller::new(&units, &gains, &limit, velocity).with_shaping(shaping),
            state: state.with_integral(held / (tuning.ki * sample_time)),
            servo: Servo::at_rest(parameters, effects, sample_time, 1).expect("valid"),
            encoder: (resolution > 0.0)
                .then(|| (Encoder::new(std::f64::consts::TAU / resolution), resolution)),
            measured: 0.0,
            offset: 0.5 * resolution,
        }
    }

    /// One sample towards a reference: position as it is seen and command.
    pub(crate) fn advance(&mut self, reference: f64) -> (f64, f64) {
        self.advance_with(reference, 0.0)
    }

    /// The same with a command on top of the controller's.
    pub(crate) fn advance_with(&mut self, reference: f64, on_top: f64) -> (f64, f64) {
        let position = self.servo.position() + self.offset;
        let measured = match &self.encoder {
            Some((encoder, resolution)) => encoder.read(position) as f64 * resolution,
            None => position,
        };
        let increment = measured - self.measured;
        self.measured = measured;
        let sample = self
            .controller
            .process(&mut self.state, reference - measured, increment)
            .expect("in range");
        let command = sample.command + on_top;
        self.servo.advance(command);
        (measured, command)
    }
}

/// The step of the settings, followed for so long, s.
pub(crate) fn step(
    bench: &mut Bench,
    settings: &TuningSettings,
    duration: f64,
) -> StepMeasure<f64> {
    let mut measure = StepMeasure::new(settings.step, settings.resolution);
    for _ in 0..(duration / settings.sample_time) as u64 {
        measure.take(bench.advance(settings.step).0);
    }
    measure
}

/// A quantile of some values.
pub(crate) fn quantile(values: &mut [f64], part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * part).round() as usize]
}
