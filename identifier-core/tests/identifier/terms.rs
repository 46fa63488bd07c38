//! Servos with one real-world effect at a time: with its term the model identifies all parameters.

use identifier_core::identifier::{GaussNewtonIdentifier, Identify};
use identifier_core::parameters::{AllUnknowns, ServoParameters, Term, Terms, Unknown};
use virtual_servo::Effects;

use crate::support::{Servo, TRUTH, beside_pid, on_all_cores, paper};

/// A name, a servo, the amplitude of its reference, rad, and the samples.
type Case = (&'static str, Servo, (f64, u32));

/// The paper's servo with friction, a fast axis, a geared motor.
fn cases() -> [Case; 3] {
    let paper = paper(TRUTH, 35.0, 0);
    let axis = Servo {
        parameters: ServoParameters::new(1.5, 400.0, 150.0, 30.0),
        counts_per_rev: 65_536.0,
        sample_time: 1e-4,
        bandwidth: 120.0,
        ..paper
    };
    let geared = Servo {
        parameters: ServoParameters::new(6.0, 80.0, 15.0, -10.0),
        counts_per_rev: 4096.0,
        limit: 12.0,
        bandwidth: 25.0,
        ..paper
    };
    [
        ("paper", paper, (0.5, 30_000)),
        ("axis", axis, (0.1, 150_000)),
        ("geared", geared, (0.5, 30_000)),
    ]
}

/// An effect, its term, and the true sizes.
type Effect = (Effects, Term, Vec<(Unknown, f64)>);

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
        (effects, term, sizes.to_vec())
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

/// Estimates in single precision, of a set with every term: the parameters, the size of an unknown, and what entered.
type Found<F> = (ServoParameters, F, Terms);

fn run(
    (_, servo, motion): &Case,
    seed: u32,
    effects: &Effects,
    demanded: Terms,
) -> Found<impl Fn(Unknown) -> f64 + Send + use<>> {
    let servo = Servo { seed, ..*servo };
    let mut settings = servo.settings();
    let terms = &mut settings.identifier.terms;
    terms.demanded = demanded;
    terms.low_speed_velocity = Some(low_speed(&servo));
    terms.ripple_order = Some(f64::from(RIPPLE));
    let identifier: GaussNewtonIdentifier<f32, AllUnknowns, { Unknown::COUNT }> =
        settings.build().expect("sound settings");
    let told = |command| command as f32;
    let state = beside_pid(&identifier, &servo, effects, *motion, told);
    let shown = identifier.snapshot(&state);
    let parameters = identifier.estimates(&state).expect("estimates");
    let entered = identifier.report(&state).entered;
    let size = move |unknown| identifier.value_in(&shown, unknown).unwrap_or(f64::NAN);
    (parameters, size, entered)
}

#[test]
fn with_its_term_each_effect_is_found_and_the_parameters_are_right() {
    for case in cases() {
        for (effects, term, sizes) in effects(&case.1) {
            let demanded = Terms::NONE.with(term);
            let runs = on_all_cores(2, |seed| run(&case, seed, &effects, demanded));
            for (found, size_of, entered) in runs {
                let what = format!("{}, {}", case.0, term.name());
                assert!(entered.has(term), "{what}");
                let servo = case.1.parameters;
                for (found, truth, most) in [
                    (found.b, servo.b, 0.005 * servo.b),
                    (found.a, servo.a, (0.03 * servo.a).max(0.1)),
                    (found.coulomb, servo.coulomb, 0.05 * servo.coulomb),
                ] {
                    assert!((found - truth).abs() < most, "{what}: {found} {truth}");
                }
                // A wave is measured by its amplitude: the encoder shows the last edge, half a count
                // behind on the mean, which turns the phase.
                let [truth, own] = [0, 1].map(|i| {
                    let sizes = sizes
                        .iter()
                        .map(|(unknown, size)| [*size, size_of(*unknown)][i]);
                    sizes.fold(0.0, f64::hypot)
                });
                let off = own / truth - 1.0;
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
        delay: 1.6 * paper.1.sample_time,
        ..Effects::NONE
    };
    let (found, size_of, entered) = run(&paper, 0, &delay, Terms::NONE);
    assert!(entered.is_empty());
    assert!(size_of(Unknown::Delay).abs() < 1e-12);
    let off = found.coulomb / paper.1.parameters.coulomb - 1.0;
    assert!(off.abs() > 0.15, "{off}");
}
