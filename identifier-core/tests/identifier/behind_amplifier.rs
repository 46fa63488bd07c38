//! A declared amplifier acts for every law: with it a, b and c are found as without the
//! effect, and undeclared it spoils them.

use identifier_core::Settings;
use identifier_core::identifier::{GaussNewtonIdentifier, GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{PerParameter, ServoParameters, Term, Terms, Unknown, Unknowns};
use identifier_core::settings::{FromSettings, TermSettings};
use virtual_servo::Effects;

use crate::support::{TRUTH, beside_pid, on_all_cores, paper};

type Gradient = GradientIdentifier<f64, LowPass<f64>, Unknowns<4>, 4>;
type GaussNewton = GaussNewtonIdentifier<f64, Unknowns<4>, 4>;

/// Effects of the amplifier, the settings that declare them, and a name.
fn effects() -> [(&'static str, Effects, TermSettings); 3] {
    let of = |name, delay, current_loop, dead_band| {
        let (mut effects, mut declared) = (Effects::NONE, TermSettings::NONE);
        (effects.delay, declared.delay) = (delay, delay);
        (effects.current_loop, declared.current_loop) = (current_loop, current_loop);
        (effects.dead_band, declared.dead_band) = (dead_band, dead_band);
        (name, effects, declared)
    };
    [
        of("delay", 1.6e-3, 0.0, 0.0),
        of("current loop behind a delay", 1.6e-3, 1e-3, 0.0),
        of("dead band", 0.0, 0.0, 0.1),
    ]
}

fn settings(declared: &TermSettings) -> Settings {
    let mut settings = Settings::new(1e-3, 10_000.0).with_servo_range([0.0, 5.0], [150.0, 400.0]);
    let given = &mut settings.identifier;
    given.bandwidth = Some(35.0);
    given.gamma = Some(PerParameter::new(30.0, 2000.0, 600.0, 1e-6));
    given.known.load = true;
    given.initial.load = Some(TRUTH.load);
    given.terms = *declared;
    settings
}

/// A law's estimates after a time (s).
fn found<I: FromSettings + Identify<f64>>(
    settings: &Settings,
    effects: &Effects,
    seed: u32,
    time: f64,
) -> (ServoParameters, Option<f64>) {
    let servo = paper(TRUTH, 35.0, seed);
    let (amplifier, behind) = settings.amplifier::<f64, 8>().expect("sound settings");
    let mut amplified = amplifier.start();
    let identifier: I = behind.build().expect("sound settings");
    let samples = (time / servo.sample_time) as u32;
    let state = beside_pid(&identifier, &servo, effects, (0.5, samples), |command| {
        amplifier.process(&mut amplified, command)
    });
    let delay = identifier.value_in(&identifier.snapshot(&state), Unknown::Delay);
    (identifier.estimates(&state).expect("estimates"), delay)
}

/// The largest errors of a law over a few seeds: of a (1/s), b and c (relative).
fn errors<I: FromSettings + Identify<f64>>(
    declared: &TermSettings,
    effects: &Effects,
    time: f64,
) -> [f64; 3] {
    let runs = on_all_cores(4, |seed| {
        let (found, _) = found::<I>(&settings(declared), effects, seed, time);
        let b = found.b / TRUTH.b - 1.0;
        [found.a - TRUTH.a, b, found.coulomb / TRUTH.coulomb - 1.0].map(f64::abs)
    });
    [0, 1, 2].map(|i| runs.iter().map(|run| run[i]).fold(0.0, f64::max))
}

fn check<I: FromSettings + Identify<f64>>(law: &str, time: f64) {
    let without = errors::<I>(&TermSettings::NONE, &Effects::NONE, time);
    println!("{law}: without an effect {without:.4?}");
    for (name, effects, declared) in effects() {
        let with = errors::<I>(&declared, &effects, time);
        let undeclared = errors::<I>(&TermSettings::NONE, &effects, time);
        println!("{law}, {name}: declared {with:.4?}, undeclared {undeclared:.4?}");
        // a 1/s, b and c relative: largest increase of the errors by the effect.
        let most = [0.1, 0.005, 0.03];
        let within = (0..3).all(|i| with[i] < without[i] + most[i]);
        let spoils = (0..3).any(|i| undeclared[i] > without[i] + 2.0 * most[i]);
        assert!(within && spoils, "{law}, {name}");
    }
}

#[test]
fn the_gradient_estimator_finds_the_servo_behind_its_amplifier() {
    check::<Gradient>("gradient", 40.0);
}

#[test]
fn gauss_newton_finds_the_servo_behind_its_amplifier() {
    check::<GaussNewton>("gauss-newton", 20.0);
}

#[test]
fn a_declared_delay_that_is_estimated_counts_once() {
    let [(_, effects, mut terms), ..] = effects();
    for declared in [0.0, 1e-3, 2.5e-3] {
        terms.delay = declared;
        terms.demanded = Terms::NONE.with(Term::Delay);
        let mut settings = settings(&terms);
        settings.identifier.known.load = false;
        let (found, total) =
            found::<GaussNewtonIdentifier<f64, Unknowns<5>, 5>>(&settings, &effects, 1, 20.0);
        let total = total.expect("it has a delay") / effects.delay;
        assert!((total - 1.0).abs() < 0.02, "{declared}: {total}");
        let b = found.b / TRUTH.b;
        assert!((b - 1.0).abs() < 0.005, "{declared}: {b}");
    }
}

#[test]
fn declarations_without_effect_are_refused_by_name() {
    type BareGaussNewton = GaussNewtonIdentifier<f64, Unknowns<5>, 5>;
    fn refusal<I: FromSettings>(declared: TermSettings) -> String {
        let built = settings(&declared).build::<I>();
        built.err().expect("refused").to_string()
    }
    let [(_, _, delay), _, _] = effects();
    let mut current_loop = TermSettings::NONE;
    current_loop.current_loop = 1e-3;
    for answer in [refusal::<Gradient>(delay), refusal::<GaussNewton>(delay)] {
        assert!(answer.starts_with("delay is declared"), "{answer}");
    }
    for answer in [
        refusal::<Gradient>(current_loop),
        refusal::<GaussNewton>(current_loop),
        refusal::<BareGaussNewton>(current_loop),
    ] {
        assert!(answer.starts_with("current_loop is declared"), "{answer}");
    }
    type Change = fn(&mut TermSettings);
    let rows: [(Change, &str); 4] = [
        (|terms| terms.delay = 6.1e-3, "delay"),
        (|terms| terms.delay = -1e-3, "delay"),
        (|terms| terms.current_loop = 1.0, "current_loop"),
        (|terms| terms.dead_band = f64::NAN, "dead_band"),
    ];
    for (change, name) in rows {
        let mut declared = TermSettings::NONE;
        change(&mut declared);
        let refused = settings(&declared).amplifier::<f64, 8>();
        let answer = refused.expect_err("refused").to_string();
        assert!(answer.starts_with(name), "{answer}");
    }
}
