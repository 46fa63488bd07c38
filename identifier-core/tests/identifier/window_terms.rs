//! Optional terms in a window long enough to show them: one effect at a time.

use core::f64::consts::TAU;

use identifier_core::Settings;
use identifier_core::identifier::{Identify, WindowIdentifier};
use identifier_core::parameters::{AllUnknowns, ServoParameters, Term, Terms, Unknown};
use identifier_core::settings::TermSettings;
use virtual_servo::{Effects, Encoder, Servo as TrueServo};

use crate::support::{Controller, Kind, Reference, TRUTH, on_all_cores, paper};

/// Two seconds of a sample each.
type Window =
    WindowIdentifier<f64, AllUnknowns, { Unknown::COUNT }, 2048, AllUnknowns, { Unknown::COUNT }>;

/// Result of a window after six seconds.
#[derive(Debug)]
struct Found {
    parameters: ServoParameters,
    sizes: Vec<(Unknown, f64)>,
    entered: Terms,
}

fn run(seed: u32, effects: &Effects, terms: &TermSettings) -> Found {
    let servo = paper(seed);
    let mut settings = Settings::new(servo.sample_time, servo.counts_per_rev);
    settings.identifier.start_time = Some(2.048);
    settings.identifier.terms = *terms;
    let window: Window = settings.build().expect("sound settings");
    let mut state = Box::new(window.start());
    let mut plant = TrueServo::at_rest(&TRUTH, effects, servo.sample_time, seed).expect("sound");
    let encoder = Encoder::new(servo.counts_per_rev);
    let mut controller = Controller::new(Kind::Pid, &servo);
    let mut reference = Reference::new(&servo, 0.5, 2 * seed + 3);
    let mut count = encoder.read(plant.position());
    for _ in 0..6000 {
        let now = encoder.read(plant.position());
        let moved = (now - count) as i32;
        count = now;
        let position = now as f64 * TAU / servo.counts_per_rev;
        let command = controller.command(reference.next(), position);
        window
            .process(&mut state, moved, command)
            .expect("ordinary samples");
        window.work(&mut state, u32::MAX);
        plant.advance(command);
    }
    let shown = window.snapshot(&state);
    let sizes = Unknown::ALL
        .into_iter()
        .filter(|unknown| unknown.term().is_some());
    Found {
        parameters: window.estimates(&state),
        sizes: sizes
            .map(|unknown| {
                (
                    unknown,
                    window.value_in(&shown, unknown).expect("it has all"),
                )
            })
            .collect(),
        entered: window.entered(&state),
    }
}

/// Effects, their declarations, the term, and the true sizes.
type Case = (Effects, TermSettings, Term, Vec<(Unknown, f64)>);

fn effects() -> Vec<Case> {
    let none = Effects::NONE;
    let nothing = TermSettings::NONE;
    let authority = 2577.0;
    vec![
        (
            Effects {
                delay: 1.6e-3,
                ..none
            },
            nothing,
            Term::Delay,
            vec![(Unknown::Delay, 1.6e-3)],
        ),
        (
            Effects {
                asymmetry: 0.2,
                ..none
            },
            nothing,
            Term::Asymmetry,
            vec![(Unknown::Asymmetry, 0.2)],
        ),
        (
            Effects {
                low_speed_friction: 5.0,
                low_speed_velocity: 1.5,
                ..none
            },
            TermSettings {
                low_speed_velocity: Some(1.5),
                ..nothing
            },
            Term::LowSpeed,
            vec![(Unknown::LowSpeed, 5.0)],
        ),
        (
            Effects {
                gravity: [0.1 * authority, 0.03 * authority],
                ..none
            },
            nothing,
            Term::Gravity,
            vec![
                (Unknown::GravitySine, 0.1 * authority),
                (Unknown::GravityCosine, 0.03 * authority),
            ],
        ),
        (
            Effects {
                ripple: [0.02 * authority, 0.01 * authority],
                ripple_order: 24,
                ..none
            },
            TermSettings {
                ripple_order: Some(24.0),
                ..nothing
            },
            Term::Ripple,
            vec![
                (Unknown::RippleSine, 0.02 * authority),
                (Unknown::RippleCosine, 0.01 * authority),
            ],
        ),
        (
            Effects {
                dead_band: 0.1,
                ..none
            },
            nothing,
            Term::DeadBand,
            vec![(Unknown::DeadBand, 0.1)],
        ),
    ]
}

fn check(demanded: bool) {
    let mut failures = Vec::new();
    for (effects, declared, term, truth) in effects() {
        let only = Terms::NONE.with(term);
        let terms = match demanded {
            true => TermSettings {
                demanded: only,
                ..declared
            },
            false => TermSettings {
                allowed: only,
                ..declared
            },
        };
        for found in on_all_cores(3, |seed| run(seed, &effects, &terms)) {
            let off = [
                (found.parameters.a - TRUTH.a).abs() / 0.1,
                (found.parameters.b / TRUTH.b - 1.0).abs() / 0.005,
                (found.parameters.coulomb / TRUTH.coulomb - 1.0).abs() / 0.05,
            ];
            let sizes: Vec<f64> = truth
                .iter()
                .map(|(unknown, true_size)| {
                    let (_, size) = found
                        .sizes
                        .iter()
                        .find(|(own, _)| own == unknown)
                        .expect("all");
                    size / true_size - 1.0
                })
                .collect();
            println!(
                "{}: {off:.3?} of what is allowed, sizes {sizes:.4?}",
                term.name()
            );
            let most = if term == Term::Delay { 0.02 } else { 0.15 };
            if found.entered != only
                || off.iter().any(|off| *off > 1.0)
                || sizes.iter().any(|size| size.abs() > most)
            {
                failures.push((term, found));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn a_required_term_is_identified() {
    check(true);
}

#[test]
fn an_allowed_term_enters_by_evidence() {
    check(false);
}

#[test]
fn a_term_without_evidence_stays_out() {
    let all = Term::ALL.into_iter().fold(Terms::NONE, Terms::with);
    let terms = TermSettings {
        allowed: all,
        low_speed_velocity: Some(1.5),
        ripple_order: Some(24.0),
        ..TermSettings::NONE
    };
    for found in on_all_cores(3, |seed| run(seed, &Effects::NONE, &terms)) {
        assert!(found.entered.is_empty(), "{found:?}");
        assert!(
            (found.parameters.b / TRUTH.b - 1.0).abs() < 0.005,
            "{found:?}"
        );
    }
}
