//! The gradient identifier beside any controller: random servos, limits that act, friction.

use crate::support::{
    Draw, Kind, Loop, Servo, amplitude_for, learn, on_all_cores, ordinary_servo, per_cent, report,
};
use identifier_core::Settings;
use identifier_core::identifier::{GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{ParameterSet, PerParameter, ServoParameters, Unknowns};

type Listener<S, const P: usize> = GradientIdentifier<f32, LowPass<f32>, S, P>;

/// The settings of the identifier for a servo: a box around it, four times as wide in b, and Γ of the size
/// that the box and the command suggest. Nothing of the controller.
fn settings(servo: &Servo) -> Settings {
    let ServoParameters { a, b, .. } = servo.parameters;
    let mut settings =
        (servo.settings()).with_servo_range([0.0, 2.0 * a.max(1.0)], [b / 2.0, b * 2.0]);
    settings.identifier.bandwidth = Some(servo.bandwidth);
    settings.identifier.initial.b = Some(b * Draw::new(servo.seed).between(0.5, 2.0));
    // φ is about [speed, command]: equal rates for a and b, sized by the guard.
    let speed = servo.authority() / servo.bandwidth;
    let ratio = (0.5 * servo.limit / (0.3 * speed)).powi(2);
    let gamma_b = 0.05 * servo.bandwidth / servo.sample_time / servo.limit.powi(2);
    let gamma_c = gamma_b * (0.5 * servo.limit).powi(2);
    settings.identifier.gamma = Some(PerParameter::new(ratio * gamma_b, gamma_b, gamma_c, 0.0));
    settings
}

struct Outcome {
    servo: Servo,
    found: ServoParameters,
    travelled: f64,
    /// Wander of b̂ over the last quarter, relative to b.
    unrest: f64,
}

fn run<S: ParameterSet<P>, const P: usize>(kind: Kind, servo: &Servo, time: f64) -> Outcome {
    let identifier: Listener<S, P> = settings(servo).build().expect("certified");
    let mut state = identifier.start();
    let mut run = Loop::new(kind, servo, amplitude_for(kind, servo, 0.3));
    let samples = (time / servo.sample_time) as u64;
    let (mut travelled, mut low, mut high) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..samples {
        let (increment, command) = run.sample();
        learn(&identifier, &mut state, (increment, command));
        if 4 * k > 3 * samples {
            travelled += increment.abs();
            let b = identifier.estimates(&state).expect("estimates").b / servo.parameters.b;
            low = low.min(b);
            high = high.max(b);
        }
    }
    Outcome {
        servo: *servo,
        found: identifier.estimates(&state).expect("estimates"),
        travelled,
        unrest: high - low,
    }
}

impl Outcome {
    fn b(&self) -> f64 {
        (self.found.b / self.servo.parameters.b - 1.0).abs()
    }
}

/// The errors of b (relative), c and d (over the authority) that 95 % are within.
fn errors(name: &str, outcomes: &[Outcome]) -> [f64; 3] {
    let [b, c, d] = [
        ("b relative", Outcome::b as fn(&Outcome) -> f64),
        ("c / authority", |o| {
            (o.found.coulomb - o.servo.parameters.coulomb).abs() / o.servo.authority()
        }),
        ("d / authority", |o| {
            (o.found.load - o.servo.parameters.load).abs() / o.servo.authority()
        }),
    ]
    .map(|(figure, of)| report(&format!("{name}: {figure}"), outcomes, of));
    [b[2], c[2], d[2]]
}

#[test]
fn it_identifies_under_any_controller_that_is_not_declared() {
    for kind in [Kind::Pid, Kind::Cascade, Kind::PiD, Kind::Relay] {
        let outcomes = on_all_cores(60, |i| {
            let mut servo = ordinary_servo(i);
            servo.parameters.coulomb = 0.0;
            run::<Unknowns<2>, 2>(kind, &servo, 30.0)
        });
        let [b, _, d] = errors(&format!("{kind:?}"), &outcomes);
        // A relay answers every edge of the encoder with its whole command, so that the noise in φ and
        // in ε is one and the same, and (11) is biased by their product. Gauss–Newton is not.
        if kind != Kind::Relay {
            assert!(b < 0.01 && d < 0.01, "{kind:?}");
        }
    }
}

#[test]
fn friction_is_found_and_nothing_latches() {
    let outcomes = on_all_cores(200, |i| {
        let mut servo = ordinary_servo(i + 1000);
        let mut draw = Draw::new(i + 5);
        servo.sample_time = draw.one_of(&[4e-3, 1e-3, 2.5e-4]);
        servo.bandwidth = servo.bandwidth.min(0.1 / servo.sample_time);
        servo.parameters.coulomb = draw.between(0.01, 0.1) * servo.authority();
        run::<Unknowns<3>, 3>(Kind::Pid, &servo, 30.0)
    });
    let [b, c, d] = errors("friction", &outcomes);
    // Standing still at a wrong value while the servo moves.
    let latched = per_cent(&outcomes, |o| {
        o.travelled > 1000.0 && o.b() > 0.05 && o.unrest < 0.002
    });
    assert!(latched == 0.0, "{latched} %");
    assert!(b < 0.02 && c < 0.01 && d < 0.02);
}
