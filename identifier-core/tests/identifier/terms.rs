//! Servos with one real-world effect at a time: with its term the model identifies all parameters.

use identifier_core::identifier::{GaussNewtonIdentifier, Identify};
use identifier_core::parameters::{AllUnknowns, ServoParameters, Term, Terms, Unknown};
use virtual_servo::Effects;

use crate::support::{Servo, TRUTH, beside_pid, on_all_cores, paper};

/// A servo and the amplitude of its reference, rad.
struct Case {
    name: &'static str,
    servo: Servo,
    amplitude: f64,
    /// Samples.
    length: u32,
}

/// The paper's servo with friction, a fast axis, a geared motor.
fn cases() -> [Case; 3] {
    let paper = paper(TRUTH, 35.0, 0);
    [
        Case {
            name: "paper",
            servo: paper,
            amplitude: 0.5,
            length: 30_000,
        },
        Case {
            name: "axis",
            servo: Servo {
                parameters: ServoParameters::new(1.5, 400.0, 150.0, 30.0),
                counts_per_rev: 65_536.0,
                sample_time: 1e-4,
                bandwidth: 120.0,
                ..paper
            },
            amplitude: 0.1,
            length: 150_000,
        },
        Case {
            name: "geared",
            servo: Servo {
                parameters: ServoParameters::new(6.0, 80.0, 15.0, -10.0),
                counts_per_rev: 4096.0,
                limit: 12.0,
                bandwidth: 25.0,
                ..paper
            },
            amplitude: 0.5,
            length: 30_000,
        },
    ]
}

/// An effect, its term, and the true sizes.
struct Effect {
    effects: Effects,
    term: Term,
    sizes: Vec<(Unknown, f64)>,
}

fn effects(servo: &Servo) -> Vec<Effect> {
    let authority = servo.authority();
    let friction = servo.parameters.coulomb;
    let delay = 1.6 * servo.sample_time;
    let asymmetry = 0.2 * servo.parameters.a.max(0.5);
    let waves = |part: f64| [part * authority, 0.3 * part * authority];
    let ([gravity_sine, gravity_cosine], [ripple_sine, ripple_cosine]) = (waves(0.1), waves(0.02));
    let effect = |term, sizes: &[(Unknown, f64)], change: &dyn Fn(&mut Effects)| {
        let mut effects = Effects::NONE;
        change(&mut effects);
        Effect {
            effects,
            term,
            sizes: sizes.to_vec(),
        }
    };
    let gravity = [
        (Unknown::GravitySine, gravity_sine),
        (Unknown::GravityCosine, gravity_cosine),
    ];
    let ripple = [
        (Unknown::RippleSine, ripple_sine),
        (Unknown::RippleCosine, ripple_cosine),
    ];
    let dead_band = 0.01 * servo.limit;
    vec![
        effect(Term::Delay, &[(Unknown::Delay, delay)], &|of| {
            of.delay = delay
        }),
        effect(Term::Asymmetry, &[(Unknown::Asymmetry, asymmetry)], &|of| {
            of.asymmetry = asymmetry
        }),
        effect(
            Term::LowSpeed,
            &[(Unknown::LowSpeed, 0.5 * friction)],
            &|of| {
                (of.low_speed_friction, of.low_speed_velocity) = (0.5 * friction, low_speed(servo));
            },
        ),
        effect(Term::Gravity, &gravity, &|of| {
            of.gravity = [gravity_sine, gravity_cosine]
        }),
        effect(Term::Ripple, &ripple, &|of| {
            (of.ripple, of.ripple_order) = ([ripple_sine, ripple_cosine], RIPPLE);
        }),
        effect(Term::DeadBand, &[(Unknown::DeadBand, dead_band)], &|of| {
            of.dead_band = dead_band
        }),
    ]
}

const RIPPLE: u32 = 24;

/// v_s of friction at low speed, rad/s.
fn low_speed(servo: &Servo) -> f64 {
    0.025 * servo.authority() / servo.bandwidth
}

/// Estimates in single precision, of a set with every term.
struct Found {
    parameters: ServoParameters,
    sizes: Vec<(Unknown, f64)>,
    entered: Terms,
}

impl Found {
    fn size(&self, unknown: Unknown) -> f64 {
        let known = self.sizes.iter().find(|(known, _)| *known == unknown);
        known.map_or(f64::NAN, |(_, size)| *size)
    }
}

fn run(case: &Case, seed: u32, effects: &Effects, demanded: Terms) -> Found {
    let servo = Servo { seed, ..case.servo };
    let mut settings = servo.settings();
    let terms = &mut settings.identifier.terms;
    terms.demanded = demanded;
    terms.low_speed_velocity = Some(low_speed(&servo));
    terms.ripple_order = Some(f64::from(RIPPLE));
    let identifier: GaussNewtonIdentifier<f32, AllUnknowns, { Unknown::COUNT }> =
        settings.build().expect("sound settings");
    let motion = (case.amplitude, case.length);
    let state = beside_pid(&identifier, &servo, effects, motion, |command| {
        command as f32
    });
    let shown = identifier.snapshot(&state);
    let size = |unknown| Some((unknown, identifier.value_in(&shown, unknown)?));
    Found {
        parameters: identifier.estimates(&state).expect("estimates"),
        sizes: Unknown::ALL.into_iter().filter_map(size).collect(),
        entered: identifier.report(&state).entered,
    }
}

/// The four parameters as found are those of the servo.
fn assert_parameters(what: &str, found: &ServoParameters, servo: &ServoParameters) {
    let off = |found: f64, truth: f64| (found - truth).abs();
    assert!(off(found.b, servo.b) < 0.005 * servo.b, "{what}: {found:?}");
    let most = (0.03 * servo.a).max(0.1);
    assert!(off(found.a, servo.a) < most, "{what}: {found:?}");
    let most = 0.05 * servo.coulomb;
    assert!(
        off(found.coulomb, servo.coulomb) < most,
        "{what}: {found:?}"
    );
}

#[test]
fn with_its_term_each_effect_is_found_and_the_parameters_are_right() {
    for case in cases() {
        for Effect {
            effects,
            term,
            sizes,
        } in effects(&case.servo)
        {
            let demanded = Terms::NONE.with(term);
            for found in on_all_cores(2, |seed| run(&case, seed, &effects, demanded)) {
                let what = format!("{}, {}", case.name, term.name());
                assert!(found.entered.has(term), "{what}");
                assert_parameters(&what, &found.parameters, &case.servo.parameters);
                // A wave is measured by its amplitude: the encoder shows the last edge, half a count
                // behind on the mean, which turns the phase.
                let amplitude = |of: &dyn Fn(&(Unknown, f64)) -> f64| {
                    sizes.iter().map(of).fold(0.0, f64::hypot)
                };
                let truth = amplitude(&|(_, size)| *size);
                let off = amplitude(&|(unknown, _)| found.size(*unknown)) / truth - 1.0;
                println!("{what}: {:+.3} %", 100.0 * off);
                assert!(off.abs() < 0.02, "{what}: {off}");
            }
        }
    }
}

#[test]
fn a_term_that_is_not_demanded_stays_out_and_its_effect_shows_in_the_residual() {
    let [paper, ..] = cases();
    let delay = Effects {
        delay: 1.6 * paper.servo.sample_time,
        ..Effects::NONE
    };
    let found = run(&paper, 0, &delay, Terms::NONE);
    assert!(found.entered.is_empty());
    assert!(found.size(Unknown::Delay).abs() < 1e-12);
    let truth = &paper.servo.parameters;
    assert!((found.parameters.coulomb / truth.coulomb - 1.0).abs() > 0.15);
}
