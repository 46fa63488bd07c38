//! An independent model of a loop: its frequency response from the textbook's formulas, and its motion by the
//! servo that the core is judged by.

use std::f64::consts::{PI, TAU};

use identifier_core::Settings;
use identifier_core::control::{Controller, Shaped};
use identifier_core::measurement::LowPass;
use identifier_core::number::Complex;
use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::settings::ControllerSettings;
use identifier_core::tuning::{StepMeasure, Tuner, Tuning, TuningError, TuningSettings};
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
        let far = |place| sign * servo.standard_error(place);
        let (ServoParameters { a, b, .. }, delay) = nominal;
        let a = (a + far(IdentifiedServo::A)).max(0.0);
        let b = b + far(IdentifiedServo::B);
        all.push((ServoParameters { a, ..nominal.0 }, delay));
        all.push((ServoParameters { b, ..nominal.0 }, delay));
        let late = (delay + far(IdentifiedServo::DELAY)).max(0.0);
        all.push((nominal.0, late));
    }
    all
}

/// The result, and its number of slices of work.
pub(crate) fn tuned(
    settings: &TuningSettings,
    servo: &IdentifiedServo,
) -> (Result<Tuning, TuningError>, u32) {
    match Tuner::new(settings, servo) {
        Ok(tuner) => worked(&tuner),
        Err(error) => (Err(error), 0),
    }
}

/// The same of a tuner.
pub(crate) fn worked(tuner: &Tuner) -> (Result<Tuning, TuningError>, u32) {
    let mut state = tuner.start();
    let mut slices = 1..;
    let found = slices.find_map(|slices| Some((tuner.work(&mut state)?, slices)));
    found.expect("it ends")
}

/// L at ω, the loop opened at the command: the transfer matrix of the servo sampled by hand, C (zI − Φ)⁻¹ Γ,
/// times the controller's transfer function.
pub(crate) fn loop_gain(
    tuning: &Tuning,
    time: f64,
    (ServoParameters { a, b, .. }, delay): &Candidate,
    omega: f64,
) -> Complex {
    let number = |re, im| Complex { re, im };
    let z_to = |samples: f64| number(0.0, omega * time * samples).exponential();
    // Contribution of a force over the last `time` of a sample to position and velocity.
    let added = |time: f64| -> [f64; 2] {
        if a * time < 1e-5 {
            let velocity = time * (1.0 - a * time / 2.0);
            [time * time / 2.0 * (1.0 - a * time / 3.0), velocity]
        } else {
            let velocity = -(-a * time).exp_m1() / a;
            [(time - velocity) / a, velocity]
        }
    };
    let whole = (delay / time).floor();
    let part = delay / time - whole;
    let all = added(time);
    let newer = added((1.0 - part) * time);
    let input = |i: usize| {
        let late = z_to(-whole).scaled(newer[i]);
        (late + z_to(-whole - 1.0).scaled(all[i] - newer[i])).scaled(*b)
    };
    let z = z_to(1.0);
    let velocity = input(1) / (z + -(-a * time).exp());
    let position = (input(0) + velocity.scaled(all[1])) / (z + -1.0);

    let p = (-tuning.cutoff * time).exp();
    let filter = z.scaled((1.0 - p) / time) / (z + -p);
    let derivative = filter * (Complex::ONE - z_to(-1.0));
    let integral = number(tuning.ki * time, 0.0) / (z + -1.0);
    position * (derivative.scaled(tuning.kd) + integral + tuning.kp)
}

/// The largest |1/(1 + L)| on a dense grid of frequencies.
pub(crate) fn sensitivity(tuning: &Tuning, sample_time: f64, servo: &Candidate) -> f64 {
    const POINTS: u32 = 4000;
    let (low, high) = (tuning.bandwidth / 100.0, PI / sample_time);
    (0..=POINTS)
        .map(|i| low * (high / low).powf(f64::from(i) / f64::from(POINTS)))
        .map(|omega| {
            let distance = loop_gain(tuning, sample_time, servo, omega) + 1.0;
            1.0 / distance.power().sqrt()
        })
        .fold(0.0, f64::max)
}

/// A loop that runs: the core's controller around the virtual servo. At rest at first; the integral holds `held`, command
/// units. A sample towards a reference gives the position as it is seen.
pub(crate) fn bench(
    tuning: &Tuning,
    settings: &TuningSettings,
    (parameters, delay): &Candidate,
    held: f64,
) -> impl FnMut(f64) -> f64 + use<> {
    let effects = Effects {
        delay: *delay,
        ..Effects::NONE
    };
    bench_of(tuning, settings, parameters, &effects, held)
}

/// The same of a servo with effects.
pub(crate) fn bench_of(
    tuning: &Tuning,
    settings: &TuningSettings,
    parameters: &ServoParameters,
    effects: &Effects,
    held: f64,
) -> impl FnMut(f64) -> f64 + use<> {
    let (sample_time, resolution) = (settings.sample_time, settings.resolution);
    let limit = [-settings.command, settings.command];
    let controller = Settings {
        resolution: 1.0,
        cutoff: tuning.cutoff,
        controller: Some(ControllerSettings::tuned(tuning, limit)),
        ..Settings::new(sample_time, 1.0)
    };
    let controller: Controller<f64, LowPass<f64>, Shaped<f64>> = controller.build().expect("valid");
    let integral = held / (tuning.ki * sample_time);
    let mut state = controller.start().with_integral(integral);
    let mut servo = Servo::at_rest(parameters, effects, sample_time, 1).expect("valid");
    let encoder = (resolution > 0.0).then(|| Encoder::new(TAU / resolution));
    let mut last = 0.0;
    move |reference| {
        // It begins in the middle of a count.
        let position = servo.position() + 0.5 * resolution;
        let count = |encoder: &Encoder| encoder.read(position) as f64 * resolution;
        let measured = encoder.as_ref().map_or(position, count);
        let increment = measured - std::mem::replace(&mut last, measured);
        let sample = controller.process(&mut state, reference - measured, increment);
        servo.advance(sample.expect("in range").command);
        measured
    }
}

/// The step of the settings, followed for so long, s.
pub(crate) fn step(
    mut bench: impl FnMut(f64) -> f64,
    settings: &TuningSettings,
    duration: f64,
) -> StepMeasure<f64> {
    let mut measure = StepMeasure::new(settings.step, settings.resolution);
    for _ in 0..(duration / settings.sample_time) as u64 {
        measure.take(bench(settings.step));
    }
    measure
}

/// A quantile of some values.
pub(crate) fn quantile(values: &mut [f64], part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * part).round() as usize]
}
