//! Gauss–Newton driven by the command that acted, over random servos under any controller.

use crate::support::{
    Draw, Kind, Loop, Servo, amplitude_for, humble_servo, learn, on_all_cores, ordinary_servo,
    paper, per_cent, report, shown,
};
use identifier_core::Settings;
use identifier_core::identifier::{Event, GaussNewtonIdentifier, Identify};
use identifier_core::parameters::{AbLoad, PerParameter, ServoParameters, Unknowns};

type Identifier = GaussNewtonIdentifier<f32, Unknowns<4>, 4>;

type Figure<T> = fn(&T) -> f64;

struct Outcome {
    servo: Servo,
    found: ServoParameters,
    /// Output error of the second half, over the encoder's.
    rms: f64,
    started: f64,
    saturation: f64,
    steps: u32,
}

impl Outcome {
    fn b(&self) -> f64 {
        (self.found.b / self.servo.parameters.b - 1.0).abs()
    }

    fn a(&self) -> f64 {
        let a = self.servo.parameters.a;
        (self.found.a - a).abs() / (0.01 * a).max(0.03)
    }

    fn d(&self) -> f64 {
        (self.found.load - self.servo.parameters.load).abs() / self.servo.authority()
    }
}

fn run(kind: Kind, servo: &Servo, amplitude: f64, time: f64, config: &Settings) -> Outcome {
    let identifier = config.build::<Identifier>().expect("settings");
    let mut state = identifier.start();
    let mut run = Loop::new(kind, servo, amplitude);
    let samples = (time / servo.sample_time) as u64;
    let (mut sum, mut started, mut steps) = (0.0, f64::INFINITY, 0);
    for k in 0..samples {
        let seen = learn(&identifier, &mut state, run.sample());
        match seen.event {
            Event::Started => started = started.min(k as f64 * servo.sample_time),
            Event::LoadStep => steps += 1,
            _ => {}
        }
        if 2 * k >= samples {
            sum += f64::from(seen.output_error).powi(2);
        }
    }
    Outcome {
        servo: *servo,
        found: shown(&identifier, &state),
        rms: (sum / (samples - samples.div_ceil(2)) as f64 * 12.0).sqrt(),
        started,
        saturation: run.saturation(),
        steps,
    }
}

/// The outcomes of these servos, each with the amplitude of its reference and its settings, after a time, s.
fn outcomes(kind: Kind, servos: &[(Servo, f64, Settings)], time: f64) -> Vec<Outcome> {
    on_all_cores(servos.len() as u32, |i| {
        let (servo, amplitude, settings) = &servos[i as usize];
        run(kind, servo, *amplitude, time, settings)
    })
}

/// Prints the figures of servos under a limit that acts. The output error is within 1.1 times the encoder's, b within
/// 0.1 %, a within 1 % or 0.03, d within 0.3 % of the authority, each in at least 95 %; and none diverges.
fn check_under_a_limit(kind: Kind, outcomes: &[Outcome]) {
    let figures = [
        (
            "output error / encoder's",
            (|o| o.rms) as Figure<Outcome>,
            1.1,
        ),
        ("b, relative", Outcome::b, 1e-3),
        ("a / max(1 %, 0.03)", Outcome::a, 1.0),
        ("d / authority", Outcome::d, 3e-3),
    ];
    let shown: [(_, Figure<Outcome>); 2] = [
        ("limit acts", |o| o.saturation),
        ("start, s", |o| o.started),
    ];
    for (name, figure) in shown {
        report(&format!("{kind:?}: {name}"), outcomes, figure);
    }
    for (name, figure, most) in figures {
        report(&format!("{kind:?}: {name}"), outcomes, figure);
        let within = per_cent(outcomes, |o| figure(o) <= most);
        println!("    within {most}: {within:.1} %");
        assert!(within >= 95.0, "{name}");
    }
    let is_near = |o: &Outcome| o.b() <= 0.05;
    assert!(outcomes.iter().all(is_near), "none frozen, none astray");
}

#[test]
fn random_servos_are_identified_by_any_controller_under_a_limit_that_acts() {
    let servos = on_all_cores(200, |i| {
        let servo = ordinary_servo(i);
        let part = Draw::new(i + 7777).uniform(0.25, 0.75);
        let amplitude = amplitude_for(Kind::Pid, &servo, part);
        (servo, amplitude, servo.settings())
    });
    for kind in [Kind::Pid, Kind::Cascade, Kind::PiD, Kind::Relay] {
        let outcomes = outcomes(kind, &servos, 20.0);
        check_under_a_limit(kind, &outcomes);
        let alarms: u32 = outcomes.iter().map(|o| o.steps).sum();
        let is_rare = kind != Kind::Pid || alarms <= 2;
        assert!(is_rare, "{alarms} steps of the load that were none");
    }
}

#[test]
fn it_starts_without_a_guess() {
    let mut servos = on_all_cores(300, |i| {
        let mut servo = ordinary_servo(i + 1000);
        let mut draw = Draw::new(i + 555);
        // b over 1000 : 1, the limit with it.
        let authority = servo.authority();
        let b = draw.between(1.0, 1000.0) * 3.0;
        servo.parameters.b = b;
        servo.limit = authority / b;
        let amplitude = amplitude_for(Kind::Pid, &servo, draw.uniform(0.02, 0.6));
        (servo, amplitude, servo.settings())
    });
    for guess in [None, Some(30.0), Some(1.0 / 30.0)] {
        for (servo, _, settings) in &mut servos {
            settings.identifier.initial.b = guess.map(|factor: f64| factor * servo.parameters.b);
        }
        let outcomes = outcomes(Kind::Pid, &servos, 2.0);
        report(&format!("b, guess {guess:?}"), &outcomes, Outcome::b);
        assert!(per_cent(&outcomes, |o| o.b() <= 0.01) >= 98.0);
    }
}

/// It starts at half of the time, and is near in every sample from then on.
#[test]
fn the_recursive_estimator_starts_from_its_first_fit_and_stays_near() {
    let truth = ServoParameters::new(0.2174, 257.7, 0.0, 20.0);
    for seed in 100..120 {
        let servo = paper(truth, 40.0, seed);
        let mut settings = servo.settings();
        settings.identifier.start_time = Some(0.6);
        let recursive: GaussNewtonIdentifier<f32, AbLoad, 3> = settings.build().expect("valid");
        let mut state = recursive.start();
        let mut run = Loop::new(Kind::Pid, &servo, 0.5);
        for k in 0..10_000 {
            learn(&recursive, &mut state, run.sample());
            assert!(k < 1000 || recursive.is_running(&state), "seed {seed}");
            if recursive.is_running(&state) {
                let found = recursive.estimates(&state).expect("estimates");
                let off = [found.b / truth.b - 1.0, found.a - truth.a].map(f64::abs);
                let is_near = off[0] < 0.02 && off[1] < 0.1;
                assert!(is_near, "seed {seed}, sample {k}: {found:?}");
            }
        }
    }
}

/// Outcome of a run over an ordinary servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Ending {
    /// b within 5 %.
    Good,
    /// b within 20 %, or within four of its standard errors.
    Fair,
    /// Not started, and the servo moved less than 30 counts a second.
    NoMotion,
    /// Not started, though it moved.
    NotStarted,
    /// At a bound, and reported there.
    AtBound,
    /// Wrong, but it still moves.
    Wrong,
    /// Wrong and still while the servo moves.
    Frozen,
}

fn humble(i: u32) -> (Ending, Servo, ServoParameters) {
    const TIME: f64 = 20.0;
    let servo = humble_servo(i);
    let mut draw = Draw::new(i + 4242);
    let kind = draw.one_of(&[Kind::Pid, Kind::Cascade, Kind::PiD]);
    // From a motion of a few counts to full use of the limit.
    let natural = servo.authority() / (servo.bandwidth * servo.bandwidth);
    let amplitude = draw.between(10.0 * servo.count(), 20.0 * servo.count() + natural);
    let identifier = servo.settings().build::<Identifier>().expect("settings");
    let mut state = identifier.start();
    let mut run = Loop::new(kind, &servo, amplitude);
    let samples = (TIME / servo.sample_time) as u64;
    let (mut path, mut before) = (0.0, None);
    for k in 0..samples {
        let (increment, command) = run.sample();
        learn(&identifier, &mut state, (increment, command));
        if 4 * k >= 3 * samples {
            path += increment.abs();
            before.get_or_insert_with(|| shown(&identifier, &state));
        }
    }
    let found = shown(&identifier, &state);
    let b = servo.parameters.b;
    let off = (found.b / b - 1.0).abs();
    let moves = path >= 30.0 * 0.25 * TIME;
    let still = before.is_some_and(|before| (before.b / found.b - 1.0).abs() < 1e-3);
    let at_bounds = identifier.at_bounds_in(&identifier.snapshot(&state));
    let ending = match identifier.report(&state).errors_of_parameters() {
        None if moves => Ending::NotStarted,
        None => Ending::NoMotion,
        Some(_) if off < 0.05 => Ending::Good,
        Some(errors) if off < 0.2 || off < 4.0 * errors.b / b => Ending::Fair,
        _ if at_bounds != PerParameter::default() => Ending::AtBound,
        _ if !moves => Ending::NoMotion,
        _ if still => Ending::Frozen,
        _ => Ending::Wrong,
    };
    (ending, servo, found)
}

/// `SERVOS=2000` for as many.
#[test]
fn ordinary_servos_do_not_freeze() {
    let given = std::env::var("SERVOS").ok();
    let servos = given.and_then(|text| text.parse().ok()).unwrap_or(600);
    let runs = on_all_cores(servos, humble);
    let mut counts = std::collections::BTreeMap::new();
    for run in &runs {
        *counts.entry(run.0).or_insert(0) += 1;
        if run.0 >= Ending::NotStarted {
            println!("{run:?}");
        }
    }
    println!("{counts:?}");
    assert_eq!(counts.get(&Ending::Frozen), None);
    assert!(per_cent(&runs, |run| run.0 == Ending::Wrong) <= 0.5);
    assert!(per_cent(&runs, |run| run.0 <= Ending::NoMotion) >= 99.0);
}

struct LoadStep {
    /// Errors of the load over the step: after 0.1 s, after 0.25 s.
    errors: [f64; 2],
    /// Change of b over the next 1.5 s.
    moved: f64,
}

/// Steps of the load, and how many were seen that were none.
fn load_steps(i: u32) -> (Vec<LoadStep>, u32) {
    const SETTLED: f64 = 5.0;
    const EVERY: f64 = 1.5;
    let servo = ordinary_servo(i);
    let mut draw = Draw::new(i + 31_337);
    let amplitude = amplitude_for(Kind::Pid, &servo, draw.uniform(0.1, 0.5));
    let identifier = servo.settings().build::<Identifier>().expect("settings");
    let mut state = identifier.start();
    let mut run = Loop::new(Kind::Pid, &servo, amplitude);
    let mut feed = |run: &mut Loop, time: f64| {
        let samples = 0..(time / servo.sample_time) as u64;
        let events = samples.map(|_| learn(&identifier, &mut state, run.sample()).event);
        let steps = events.filter(|event| *event == Event::LoadStep).count();
        (shown(&identifier, &state), steps as u32)
    };
    let (mut before, _) = feed(&mut run, SETTLED);
    let (mut results, mut unasked) = (Vec::new(), 0);
    for _ in 0..6 {
        // Half the quiet time before the step counts for false alarms.
        unasked += feed(&mut run, 0.5 * EVERY).1;
        let size = draw.uniform(0.03, 0.15) * servo.authority();
        let up = servo.parameters.load + run.extra_load < 0.0;
        let step = if up { size } else { -size };
        run.extra_load += step;
        let truth = servo.parameters.load + run.extra_load;
        let errors = [0.1, 0.15].map(|time| ((feed(&mut run, time).0.load - truth) / step).abs());
        let (after, _) = feed(&mut run, EVERY - 0.25);
        let moved = (after.b / before.b - 1.0).abs();
        results.push(LoadStep { errors, moved });
        before = after;
    }
    (results, unasked)
}

#[test]
fn steps_of_the_load_are_followed() {
    let runs = on_all_cores(200, load_steps);
    let unasked: u32 = runs.iter().map(|(_, unasked)| unasked).sum();
    let steps: Vec<LoadStep> = runs.into_iter().flat_map(|(steps, _)| steps).collect();
    let figures = [
        (
            "error after 0.1 s",
            (|s| s.errors[0]) as Figure<LoadStep>,
            0.1,
            85.0,
        ),
        ("error after 0.25 s", |s| s.errors[1], 0.1, 97.0),
        ("b moved, relative", |s| s.moved, 2e-3, 97.0),
    ];
    for (name, figure, most, least) in figures {
        report(name, &steps, figure);
        let within = per_cent(&steps, |step| figure(step) <= most);
        println!("    within {most}: {within:.1} %");
        assert!(within >= least, "{name}: {within} %");
    }
    assert!(unasked <= 1, "{unasked} false alarms");
}
