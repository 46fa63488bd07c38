//! One effect of a real servo at a time: with its term in the model everything is found.

use core::f64::consts::TAU;

use identifier_core::Settings;
use identifier_core::identifier::{Event, GaussNewtonIdentifier, Identify};
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use identifier_core::unknowns::{AllUnknowns, Term, Terms, Unknown};
use virtual_servo::{Effects, Encoder, Servo as TrueServo};

use crate::support::{Controller, Kind, Reference, Servo, on_all_cores};

const NO_EFFECT: Effects = Effects {
    delay: 0.0,
    ..Effects::NONE
};

/// The paper's servo with friction, a fast axis, a geared motor.
fn servos() -> [(&'static str, Servo, f64); 3] {
    let servo = |parameters, counts_per_rev, sample_time, limit, bandwidth| Servo {
        parameters,
        counts_per_rev,
        sample_time,
        limit,
        bandwidth,
        offset: 0.0,
        seed: 0,
    };
    let of = |a, b, coulomb, load| ServoParameters {
        a,
        b,
        coulomb,
        load,
    };
    [
        (
            "paper",
            servo(of(0.2174, 257.7, 10.0, 20.0), 10_000.0, 1e-3, 10.0, 35.0),
            0.5,
        ),
        (
            "axis",
            servo(of(1.5, 400.0, 150.0, 30.0), 65_536.0, 1e-4, 10.0, 120.0),
            0.1,
        ),
        (
            "geared",
            servo(of(6.0, 80.0, 15.0, -10.0), 4096.0, 1e-3, 12.0, 25.0),
            0.5,
        ),
    ]
}

struct Found {
    parameters: ServoParameters,
    sizes: Vec<(Unknown, f64, f64)>,
    since: f64,
    rms: f64,
    entered: Terms,
}

fn run<N: Number>(
    servo: &Servo,
    effects: &Effects,
    amplitude: f64,
    settings: &Settings,
    time: f64,
) -> Found {
    let identifier: GaussNewtonIdentifier<N, AllUnknowns, 12> =
        settings.build().expect("sound settings");
    let mut state = identifier.start();
    let mut plant = TrueServo::at_rest(&servo.parameters, effects, servo.sample_time, servo.seed)
        .expect("sound effects");
    let encoder = Encoder::new(servo.counts_per_rev);
    let mut controller = Controller::new(Kind::Pid, servo);
    let mut reference = Reference::new(servo, amplitude, servo.seed + 3);
    let mut count = encoder.read(plant.position());
    let samples = (time / servo.sample_time) as u32;
    let (mut sum, mut late, mut since) = (0.0, 0, f64::NAN);
    for k in 0..samples {
        let now = encoder.read(plant.position());
        let moved = (now - count) as i32;
        count = now;
        let position = now as f64 * TAU / servo.counts_per_rev;
        let command = controller.command(reference.next(), position);
        let seen = identifier
            .process(&mut state, moved, N::from_f64(command))
            .expect("ordinary samples");
        identifier.work(&mut state, u32::MAX);
        if seen.event == Event::TermEntered {
            since = f64::from(k) * servo.sample_time;
        }
        if std::env::var_os("TRACE").is_some() && seen.event != Event::None {
            println!(
                "{:?} at {}: {:?}",
                seen.event,
                f64::from(k) * servo.sample_time,
                identifier.estimates(&state)
            );
        }
        if 2 * k > samples {
            sum += seen.output_error.to_f64().powi(2);
            late += 1;
        }
        plant.advance(command);
    }
    let shown = identifier.show(&state);
    let sizes = Unknown::ALL
        .into_iter()
        .filter(|unknown| unknown.term().is_some())
        .map(|unknown| {
            (
                unknown,
                identifier.value_of(&shown, unknown).expect("it has all"),
                identifier
                    .standard_error_of(&state, unknown)
                    .unwrap_or(f64::NAN),
            )
        })
        .collect();
    Found {
        parameters: identifier.estimates(&state),
        sizes,
        since,
        rms: (sum / f64::from(late) * 12.0).sqrt(),
        entered: identifier.entered(&state),
    }
}

fn settings(servo: &Servo) -> Settings {
    let mut settings = Settings::new(servo.sample_time, servo.counts_per_rev);
    settings.identifier.initial.b = None;
    settings
}

/// The effects, with the term and the true sizes.
fn effects(servo: &Servo) -> Vec<(&'static str, Effects, Option<Term>, Vec<(Unknown, f64)>)> {
    let t = servo.sample_time;
    let authority = servo.authority();
    let c = servo.parameters.coulomb;
    let speed = authority / servo.bandwidth / 4.0;
    vec![
        ("none", NO_EFFECT, None, vec![]),
        (
            "delay 1",
            Effects {
                delay: t,
                ..NO_EFFECT
            },
            Some(Term::Delay),
            vec![(Unknown::Delay, t)],
        ),
        (
            "delay 2.4",
            Effects {
                delay: 2.4 * t,
                ..NO_EFFECT
            },
            Some(Term::Delay),
            vec![(Unknown::Delay, 2.4 * t)],
        ),
        (
            "asymmetry",
            Effects {
                asymmetry: 0.2 * servo.parameters.a.max(0.5),
                ..NO_EFFECT
            },
            Some(Term::Asymmetry),
            vec![(Unknown::Asymmetry, 0.2 * servo.parameters.a.max(0.5))],
        ),
        (
            "low speed",
            Effects {
                low_speed_friction: 0.5 * c,
                low_speed_velocity: 0.1 * speed,
                ..NO_EFFECT
            },
            Some(Term::LowSpeed),
            vec![(Unknown::LowSpeed, 0.5 * c)],
        ),
        (
            "gravity",
            Effects {
                gravity: [0.1 * authority, 0.03 * authority],
                ..NO_EFFECT
            },
            Some(Term::Gravity),
            vec![
                (Unknown::GravitySine, 0.1 * authority),
                (Unknown::GravityCosine, 0.03 * authority),
            ],
        ),
        (
            "ripple",
            Effects {
                ripple: [0.02 * authority, 0.01 * authority],
                ripple_order: 24,
                ..NO_EFFECT
            },
            Some(Term::Ripple),
            vec![
                (Unknown::RippleSine, 0.02 * authority),
                (Unknown::RippleCosine, 0.01 * authority),
            ],
        ),
        (
            "dead band",
            Effects {
                dead_band: 0.01 * servo.limit,
                ..NO_EFFECT
            },
            Some(Term::DeadBand),
            vec![(Unknown::DeadBand, 0.01 * servo.limit)],
        ),
    ]
}

#[test]
fn one_effect_at_a_time() {
    let seeds: u32 = std::env::var("SEEDS").map_or(2, |s| s.parse().expect("a number"));
    let allowed = std::env::var_os("ALLOWED").is_some();
    for (name, servo, amplitude) in servos() {
        for (effect, effects, term, truth) in effects(&servo) {
            if std::env::var("ONLY").is_ok_and(|only| !format!("{name} {effect}").contains(&only)) {
                continue;
            }
            let found = on_all_cores(seeds, |seed| {
                let servo = Servo { seed, ..servo };
                let mut settings = settings(&servo);
                let terms = &mut settings.identifier.terms;
                if std::env::var_os("ALL").is_some() {
                    terms.allowed = Term::ALL.into_iter().fold(Terms::NONE, Terms::with);
                    terms.low_speed_velocity =
                        Some(0.1 * servo.authority() / servo.bandwidth / 4.0);
                    terms.ripple_order = Some(24.0);
                } else if let Some(term) = term {
                    if allowed {
                        terms.allowed = Terms::NONE.with(term);
                    } else {
                        terms.demanded = Terms::NONE.with(term);
                    }
                }
                if effects.low_speed_velocity > 0.0 {
                    terms.low_speed_velocity = Some(effects.low_speed_velocity);
                }
                if effects.ripple_order > 0 {
                    terms.ripple_order = Some(f64::from(effects.ripple_order));
                }
                run::<f64>(
                    &servo,
                    &effects,
                    amplitude,
                    &settings,
                    60.0f64.min(6e5 * servo.sample_time),
                )
            });
            for found in found {
                let (p, q) = (&found.parameters, &servo.parameters);
                let sizes: Vec<String> = truth
                    .iter()
                    .map(|(unknown, value)| {
                        let (_, size, error) = found
                            .sizes
                            .iter()
                            .find(|(u, ..)| u == unknown)
                            .expect("all");
                        format!(
                            "{} {:+.2} % ± {:.2} %",
                            unknown.name(),
                            100.0 * (size / value - 1.0),
                            100.0 * error / value.abs()
                        )
                    })
                    .collect();
                println!(
                    "{name:7} {effect:10} a {:+8.4} b {:+7.3} % c {:+7.2} % d {:+7.3} rms {:5.2} since {:5.2} {:?} {}",
                    p.a - q.a,
                    100.0 * (p.b / q.b - 1.0),
                    100.0 * (p.coulomb / q.coulomb - 1.0),
                    p.load - q.load,
                    found.rms,
                    found.since,
                    found.entered,
                    sizes.join(", "),
                );
            }
        }
    }
}
