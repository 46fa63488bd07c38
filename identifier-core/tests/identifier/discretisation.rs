//! Why the sampled model loop must be the sampled real loop: the textbook's discretisation beside the core's matched
//! one. `literal_loop` holds the core to the equations themselves.

use crate::support::{certified, learn_as_the_paper, paper_noise};
use identifier_core::Settings;
use identifier_core::control::{ControlState, Controller};
use identifier_core::identifier::{GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{ServoParameters, Unknowns};
use virtual_servo::Plant;

/// The paper's servo.
const SERVO: ServoParameters = ServoParameters::new(0.2174, 257.7, 0.0, 0.0);
const T: f64 = 1e-3;
const KP: f64 = 9.0;
const KD: f64 = 0.19;
const KI: f64 = 4.0;
const MU: f64 = 10.0;
const GAMMA: [f64; 2] = [0.2, 110.0];
const CUTOFF: f64 = 500.0;
const INITIAL_B: f64 = 50.0;
const BOUNDS: [[f64; 2]; 2] = [[0.0, 100.0], [5.0, 5000.0]];
/// The smallest b of the paper's range.
const LEAST_B: f64 = 110.0;

/// The mean of [â, b̂] over the last quarter of a run on the paper's servo, its encoder ideal. `sample` is a sample of
/// a loop: from reference and position, rad, it gives the command and the estimates.
fn tail_mean(duration: f64, mut sample: impl FnMut(f64, f64) -> (f64, [f64; 2])) -> [f64; 2] {
    let settings = certified();
    let mut reference = paper_noise(&settings, 1_212_121);
    let mut plant = Plant::at_rest(&SERVO, T);
    let samples = (duration / T).round() as usize;
    let mut sum = [0.0; 2];
    for k in 0..samples {
        let wanted = reference() * settings.resolution;
        let (command, estimates) = sample(wanted, plant.position);
        plant.advance(command);
        if 4 * k >= 3 * samples {
            sum = [0, 1].map(|i| sum[i] + estimates[i] / (samples / 4) as f64);
        }
    }
    sum
}

/// The paper's equations by forward Euler in SI, with q_e and z_e as states. The model's own velocity is in its PID and
/// in the output error, where the real loop has a filtered one.
fn textbook() -> impl FnMut(f64, f64) -> (f64, [f64; 2]) {
    let pole = (-CUTOFF * T).exp();
    let (mut last_q, mut filtered, mut integral) = (0.0, 0.0, 0.0);
    let (mut q_e, mut v_e, mut integral_e) = (0.0, 0.0, 0.0);
    let [mut a, mut b] = [0.0, INITIAL_B];
    move |wanted, q| {
        filtered = pole * filtered + (1.0 - pole) * (q - last_q) / T;
        last_q = q;
        let (e, e_e) = (wanted - q, wanted - q_e);
        let u = KP * e - KD * filtered + KI * integral;
        let u_e = KP * e_e - KD * v_e + KI * integral_e;
        integral += T * e;
        integral_e += T * e_e;
        let y = MU * (q - q_e) + (filtered - v_e);
        let phi = [v_e, -u_e];
        // The guard of the sampled law, with the smallest α of the paper's box.
        let strength = T * (GAMMA[0] * phi[0] * phi[0] + GAMMA[1] * phi[1] * phi[1]);
        let shortened = (0.05 * LEAST_B * KD / strength).min(1.0);
        a = (a - T * shortened * GAMMA[0] * phi[0] * y).clamp(BOUNDS[0][0], BOUNDS[0][1]);
        b = (b - T * shortened * GAMMA[1] * phi[1] * y).clamp(BOUNDS[1][0], BOUNDS[1][1]);
        let acceleration = -a * v_e + b * u_e;
        q_e += T * v_e;
        v_e += T * acceleration;
        (u, [a, b])
    }
}

/// The core's loop.
fn matched() -> impl FnMut(f64, f64) -> (f64, [f64; 2]) {
    let mut settings = Settings {
        resolution: 1e-5,
        ..certified()
    };
    learn_as_the_paper(&mut settings);
    let controller: Controller<f64, LowPass<f64>> = settings.build().expect("valid");
    let identifier: GradientIdentifier<f64, LowPass<f64>, Unknowns<2>, 2> =
        settings.build().expect("certified");
    let (mut control, mut state) = (ControlState::default(), identifier.start());
    let mut last = 0.0;
    move |wanted, position| {
        let [wanted, position] = [wanted, position].map(|at| at / settings.resolution);
        let moved = position - std::mem::replace(&mut last, position);
        let step = controller
            .process(&mut control, wanted - position, moved)
            .expect("within reach");
        identifier
            .learn(&mut state, step.increment, step.command)
            .expect("a possible sample");
        let found = identifier.estimates(&state).expect("estimates");
        (step.command, [found.a, found.b])
    }
}

#[test]
fn textbook_discretisation_is_biased_and_the_matched_one_is_not() {
    let ServoParameters { a, b, .. } = SERVO;
    let by_textbook = tail_mean(120.0, textbook());
    let by_the_core = tail_mean(240.0, matched());
    println!("true {a:.4} {b:.2}, textbook {by_textbook:.4?}, matched {by_the_core:.4?}");
    assert!(by_textbook[0] > 4.0 * a, "â is several times too large");
    assert!(by_textbook[1] < 0.95 * b, "b̂ is some 8 % too small");
    assert!((by_the_core[0] - a).abs() < 1e-4);
    assert!((by_the_core[1] / b - 1.0).abs() < 1e-6);
}
