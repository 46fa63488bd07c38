//! Why the sampled model loop must be the sampled real loop: the textbook's discretisation beside
//! the matched one, and the core beside an independent statement of its equations.

use crate::support::certified;
use identifier_core::Settings;
use identifier_core::control::{ControlState, Controller};
use identifier_core::excitation::Excitation;
use identifier_core::identifier::{GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{ServoParameters, Unknowns};
use identifier_core::settings::diagonal;
use identifier_core::units::Units;
use virtual_servo::Plant;
use virtual_servo::excitation::BandLimitedWhiteNoise;

const A: f64 = 0.2174;
const B: f64 = 257.7;
const T: f64 = 1e-3;
const KP: f64 = 9.0;
const KD: f64 = 0.19;
const KI: f64 = 4.0;
const MU: f64 = 10.0;
const GAMMA: [f64; 2] = [0.2, 110.0];
const CUTOFF: f64 = 500.0;
const LIMIT: f64 = 10.0;
const INITIAL_B: f64 = 50.0;
const BOUNDS: [[f64; 2]; 2] = [[0.0, 100.0], [5.0, 5000.0]];
/// The smallest b of the paper's range.
const LEAST_B: f64 = 110.0;

/// The paper's servo under a load, at rest.
fn plant(load: f64) -> Plant {
    let servo = ServoParameters::new(A, B, 0.0, load);
    Plant::at_rest(&servo, T)
}

/// The paper's reference.
fn noise(units: &Units) -> BandLimitedWhiteNoise {
    BandLimitedWhiteNoise::new(units, 0.005, 0.1, 1_212_121).expect("valid")
}

/// Discretisation of the model loop.
#[derive(Clone, Copy, PartialEq)]
enum Discretisation {
    /// Forward Euler, and the model's own velocity in its PID and output error where the real loop
    /// has a filtered one.
    Textbook,
    /// The exact zero-order-hold step, the same filter, and the regressor through that filter too.
    Matched,
}

/// The paper's equations written out in SI, with q_e and z_e as states, for an ideal encoder.
/// Returns [â, b̂] at every sample.
fn identify(discretisation: Discretisation, load: f64, duration: f64) -> Vec<[f64; 2]> {
    let units = Units::new(T, 1.0).expect("valid");
    let noise = noise(&units);
    let mut reference = Excitation::<f64>::start(&noise);
    let mut plant = plant(load);

    let pole = (-CUTOFF * T).exp();
    let (mut last_q, mut filtered, mut integral) = (0.0, 0.0, 0.0);
    let (mut q_e, mut v_e, mut last_q_e, mut filtered_e, mut integral_e) =
        (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut held_e, mut filtered_u_e) = (0.0, 0.0);
    let [mut a, mut b] = [0.0, INITIAL_B];
    let samples = (duration / T).round() as usize;
    let mut estimates = Vec::with_capacity(samples);
    for _ in 0..samples {
        let wanted: f64 = noise.process(&mut reference);
        let q = plant.position;
        filtered = pole * filtered + (1.0 - pole) * (q - last_q) / T;
        filtered_e = pole * filtered_e + (1.0 - pole) * (q_e - last_q_e) / T;
        (last_q, last_q_e) = (q, q_e);
        let seen_e = match discretisation {
            Discretisation::Textbook => v_e,
            Discretisation::Matched => filtered_e,
        };
        let (e, e_e) = (wanted - q, wanted - q_e);
        let u = (KP * e - KD * filtered + KI * integral).clamp(-LIMIT, LIMIT);
        let u_e = KP * e_e - KD * seen_e + KI * integral_e;
        integral += T * e;
        integral_e += T * e_e;

        let epsilon = q - q_e;
        let y = MU * epsilon + (filtered - seen_e);
        filtered_u_e = pole * filtered_u_e + (1.0 - pole) * held_e;
        held_e = u_e;
        let phi = match discretisation {
            Discretisation::Textbook => [v_e, -u_e],
            Discretisation::Matched => [filtered_e, -filtered_u_e],
        };
        // The guard of the sampled law, with the smallest α of the paper's box.
        let strength = T * (GAMMA[0] * phi[0] * phi[0] + GAMMA[1] * phi[1] * phi[1]);
        let shortened = (0.05 * LEAST_B * KD / strength).min(1.0);
        a = (a - T * shortened * GAMMA[0] * phi[0] * y).clamp(BOUNDS[0][0], BOUNDS[0][1]);
        b = (b - T * shortened * GAMMA[1] * phi[1] * y).clamp(BOUNDS[1][0], BOUNDS[1][1]);

        match discretisation {
            Discretisation::Textbook => {
                let acceleration = -a * v_e + b * u_e;
                q_e += T * v_e;
                v_e += T * acceleration;
            }
            Discretisation::Matched => {
                let decay = (-a * T).exp();
                let g1 = if a > 0.0 { (1.0 - decay) / a } else { T };
                let g2 = if a > 1e-3 { (T - g1) / a } else { T * T / 2.0 };
                q_e += g1 * v_e + g2 * b * u_e;
                v_e = decay * v_e + g1 * b * u_e;
            }
        }
        plant.advance(u);
        estimates.push([a, b]);
    }
    estimates
}

fn tail_mean(estimates: &[[f64; 2]]) -> [f64; 2] {
    let tail = &estimates[estimates.len() * 3 / 4..];
    [0, 1].map(|i| tail.iter().map(|estimate| estimate[i]).sum::<f64>() / tail.len() as f64)
}

#[test]
fn textbook_discretisation_is_biased_and_the_matched_one_is_not() {
    let textbook = tail_mean(&identify(Discretisation::Textbook, 0.0, 120.0));
    let matched = tail_mean(&identify(Discretisation::Matched, 0.0, 240.0));
    println!("true      a = {A:.4}  b = {B:.2}");
    println!("textbook  a = {:.4}  b = {:.2}", textbook[0], textbook[1]);
    println!("matched   a = {:.4}  b = {:.2}", matched[0], matched[1]);
    assert!(
        textbook[0] > 4.0 * A,
        "the textbook's â is several times too large"
    );
    assert!(
        textbook[1] < 0.95 * B,
        "the textbook's b̂ is some 8 % too small"
    );
    assert!((matched[0] - A).abs() < 1e-4);
    assert!((matched[1] / B - 1.0).abs() < 1e-6);
}

/// The same by the core. Returns [â, b̂] at every sample.
fn identify_by_the_core(load: f64, duration: f64) -> Vec<[f64; 2]> {
    let mut settings = Settings {
        resolution: 1e-5,
        ..certified()
    };
    let learning = &mut settings.identifier;
    learning.initial.b = Some(INITIAL_B);
    learning.bounds.a = Some(BOUNDS[0]);
    learning.bounds.b = Some(BOUNDS[1]);
    learning.gamma = Some(diagonal([GAMMA[0], GAMMA[1], 0.0, 0.0]));
    learning.mu = Some(MU);
    let units = settings.units().expect("valid");
    let controller: Controller<f64, LowPass<f64>> = settings.build().expect("valid");
    let identifier: GradientIdentifier<f64, LowPass<f64>, Unknowns<2>, 2> =
        settings.build().expect("certified");
    let noise = noise(&units);
    let mut reference = Excitation::<f64>::start(&noise);
    let mut plant = plant(load);
    let mut control = ControlState::default();
    let mut state = identifier.start();
    let mut last = 0.0;
    let samples = (duration / T).round() as usize;
    (0..samples)
        .map(|_| {
            let wanted: f64 = noise.process(&mut reference);
            let position = plant.position / settings.resolution;
            let moved = position - std::mem::replace(&mut last, position);
            let step = controller
                .process(&mut control, wanted - position, moved)
                .expect("within reach");
            identifier
                .learn(&mut state, step.increment, step.command)
                .expect("a possible sample");
            plant.advance(step.command);
            let found = identifier.estimates(&state).expect("estimates");
            [found.a, found.b]
        })
        .collect()
}

#[test]
fn the_core_computes_the_papers_equations() {
    for load in [0.0, 20.0] {
        let found = identify_by_the_core(load, 20.0);
        let reference = identify(Discretisation::Matched, load, 20.0);
        assert_eq!(found.len(), reference.len());
        for (k, (found, expected)) in found.iter().zip(&reference).enumerate() {
            let apart = [0, 1].map(|i| (found[i] - expected[i]).abs());
            assert!(
                apart[0] < 1e-6 && apart[1] < 1e-5,
                "sample {k}: {found:?} against {expected:?}"
            );
        }
    }
}
