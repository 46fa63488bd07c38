//! The gradient identifier beside any controller: random servos, limits that act, friction.

use crate::support::{
    Draw, Kind, Loop, Servo, amplitude_for, learn, on_all_cores, ordinary_servo, per_cent, quantile,
};
use identifier_core::Settings;
use identifier_core::identifier::{Event, GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{ParameterSet, ServoParameters, Unknowns};
use identifier_core::settings::diagonal;

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
    settings.identifier.gamma = Some(diagonal([ratio * gamma_b, gamma_b, gamma_c, 0.0]));
    settings
}

struct Outcome {
    servo: Servo,
    found: ServoParameters,
    travelled: f64,
    restarts: u32,
    /// Wander of b̂ over the last quarter, relative to b.
    unrest: f64,
}

fn run<S: ParameterSet<P>, const P: usize>(kind: Kind, servo: &Servo, time: f64) -> Outcome {
    let identifier: Listener<S, P> = settings(servo).build().expect("certified");
    let mut state = identifier.start();
    let mut run = Loop::new(kind, servo, amplitude_for(kind, servo, 0.3));
    let samples = (time / servo.sample_time) as u64;
    let (mut travelled, mut restarts) = (0.0, 0);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..samples {
        let (increment, command) = run.sample();
        let seen = learn(&identifier, &mut state, (increment, command));
        restarts += u32::from(seen.event == Event::Restarted);
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
        restarts,
        unrest: high - low,
    }
}

fn without_friction(mut servo: Servo) -> Servo {
    servo.parameters.coulomb = 0.0;
    servo
}

fn report(name: &str, outcomes: &[Outcome]) -> [f64; 3] {
    let column = |f: &dyn Fn(&Outcome) -> f64| {
        let values: Vec<f64> = outcomes.iter().map(f).collect();
        [0.5, 0.9, 0.95, 1.0].map(|part| quantile(&values, part))
    };
    let b = column(&|o| (o.found.b / o.servo.parameters.b - 1.0).abs());
    let d = column(&|o| (o.found.load - o.servo.parameters.load).abs() / o.servo.authority());
    let c = column(&|o| (o.found.coulomb - o.servo.parameters.coulomb).abs() / o.servo.authority());
    let a = column(&|o| (o.found.a - o.servo.parameters.a).abs());
    println!(
        "{name}: {} servos; median, 90 %, 95 %, worst",
        outcomes.len()
    );
    println!(
        "  b relative {b:9.5?}\n  a [1/s]    {a:9.5?}\n  c / authority {c:9.5?}\n  d / authority {d:9.5?}"
    );
    for o in outcomes {
        if (o.found.b / o.servo.parameters.b - 1.0).abs() > 0.05 {
            println!(
                "  far: {:?} found {:?} travelled {} unrest {:.4}",
                o.servo, o.found, o.travelled, o.unrest
            );
        }
    }
    println!(
        "  restarts {}",
        outcomes.iter().map(|o| o.restarts).sum::<u32>()
    );
    [b[2], c[2], d[2]]
}

#[test]
fn it_identifies_under_any_controller_that_is_not_declared() {
    for kind in [Kind::Pid, Kind::Cascade, Kind::PiD, Kind::Relay] {
        let outcomes = on_all_cores(60, |i| {
            run::<Unknowns<2>, 2>(kind, &without_friction(ordinary_servo(i)), 30.0)
        });
        let [b, _, d] = report(&format!("{kind:?}"), &outcomes);
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
    let [b, c, d] = report("friction", &outcomes);
    // Standing still at a wrong value while the servo moves.
    let latched = per_cent(&outcomes, |o| {
        let wrong = (o.found.b / o.servo.parameters.b - 1.0).abs() > 0.05;
        o.travelled > 1000.0 && wrong && o.unrest < 0.002
    });
    println!("  latched {latched} %");
    assert!(latched == 0.0);
    assert!(b < 0.02 && c < 0.01 && d < 0.02);
}
