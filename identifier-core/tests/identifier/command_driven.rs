//! Gauss–Newton driven by the command that acted, over random servos under any controller.

use crate::support::{
    Draw, Kind, Loop, Servo, amplitude_for, humble_servo, learn, on_all_cores, ordinary_servo,
    per_cent, quantile, shown,
};
use identifier_core::Settings;
use identifier_core::identifier::{Event, GaussNewtonIdentifier, Identify};
use identifier_core::number::Number;
use identifier_core::parameters::{PerParameter, ServoParameters, Unknowns};
use identifier_core::settings::FromSettings;

type Identifier<N> = GaussNewtonIdentifier<N, Unknowns<4>, 4>;

#[derive(Debug, Clone, Copy)]
struct Outcome {
    servo: Servo,
    found: ServoParameters,
    /// Output error of the second half, over the encoder's.
    rms: f64,
    started: f64,
    saturation: f64,
    steps: u32,
    last_step: f64,
    lowered: u32,
    bandwidth: f64,
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

fn run<N: Number>(
    kind: Kind,
    servo: &Servo,
    amplitude: f64,
    time: f64,
    config: &Settings,
) -> Outcome {
    let identifier = config.build::<Identifier<N>>().expect("settings");
    let mut state = identifier.start();
    let mut run = Loop::new(kind, servo, amplitude);
    let samples = (time / servo.sample_time) as u64;
    let (mut sum, mut count) = (0.0, 0u64);
    let (mut started, mut steps, mut lowered) = (f64::INFINITY, 0, 0);
    let mut last_step = 0.0;
    for k in 0..samples {
        let (increment, command) = run.sample();
        let seen = learn(&identifier, &mut state, (increment, command));
        match seen.event {
            Event::Started => started = started.min(k as f64 * servo.sample_time),
            Event::LoadStep => {
                steps += 1;
                last_step = k as f64 * servo.sample_time;
            }
            Event::FrictionLowered => lowered += 1,
            _ => {}
        }
        if 2 * k >= samples {
            sum += seen.output_error.to_f64().powi(2);
            count += 1;
        }
    }
    Outcome {
        servo: *servo,
        found: shown(&identifier, &state),
        rms: (sum / count as f64 * 12.0).sqrt(),
        started,
        saturation: run.saturation(),
        steps,
        last_step,
        lowered,
        bandwidth: identifier.report(&state).bandwidth.unwrap_or(0.0),
    }
}

fn saturated_servos(kind: Kind, servos: u32, time: f64) -> Vec<Outcome> {
    on_all_cores(servos, |i| {
        let servo = ordinary_servo(i);
        let part = Draw::new(i + 7777).uniform(0.25, 0.75);
        let amplitude = amplitude_for(Kind::Pid, &servo, part);
        run::<f32>(kind, &servo, amplitude, time, &servo.settings())
    })
}

fn report(name: &str, outcomes: &[Outcome]) {
    let column = |f: &dyn Fn(&Outcome) -> f64| {
        let values: Vec<f64> = outcomes.iter().map(f).collect();
        format!(
            "{:9.5} {:9.5} {:9.5} {:9.5}",
            quantile(&values, 0.5),
            quantile(&values, 0.9),
            quantile(&values, 0.95),
            quantile(&values, 1.0)
        )
    };
    println!(
        "{name}: {} servos; median, 90 %, 95 %, worst",
        outcomes.len()
    );
    println!("  output error / encoder's {}", column(&|o| o.rms));
    println!("  b, relative              {}", column(&|o| o.b()));
    println!("  a / max(1 %, 0.03)       {}", column(&|o| o.a()));
    println!("  d / authority            {}", column(&|o| o.d()));
    println!("  limit acts               {}", column(&|o| o.saturation));
    println!("  start, s                 {}", column(&|o| o.started));
    println!(
        "  load steps               {}",
        column(&|o| f64::from(o.steps))
    );
    println!("  last load step, s        {}", column(&|o| o.last_step));
    println!(
        "  friction lowered         {}",
        column(&|o| f64::from(o.lowered))
    );
    println!(
        "  bandwidth / loop's       {}",
        column(&|o| o.bandwidth / o.servo.bandwidth)
    );
    println!(
        "  within: output error 1.1 {:.1} %, b 0.1 % {:.1} %, a {:.1} %, d 0.3 % {:.1} %",
        per_cent(outcomes, |o| o.rms <= 1.1),
        per_cent(outcomes, |o| o.b() <= 1e-3),
        per_cent(outcomes, |o| o.a() <= 1.0),
        per_cent(outcomes, |o| o.d() <= 3e-3),
    );
}

/// The output error within 1.1 times the encoder's, b within 0.1 %, a within 1 % or 0.03, d within
/// 0.3 % of the authority, each in at least 95 %; and none diverges.
fn assert_figures(outcomes: &[Outcome]) {
    assert!(per_cent(outcomes, |o| o.rms <= 1.1) >= 95.0);
    assert!(per_cent(outcomes, |o| o.b() <= 1e-3) >= 95.0);
    assert!(per_cent(outcomes, |o| o.a() <= 1.0) >= 95.0);
    assert!(per_cent(outcomes, |o| o.d() <= 3e-3) >= 95.0);
    assert!(
        outcomes.iter().all(|o| o.b() <= 0.05),
        "none frozen, none astray"
    );
}

#[test]
fn random_servos_are_identified_under_a_limit_that_acts() {
    let outcomes = saturated_servos(Kind::Pid, 200, 20.0);
    report("PID", &outcomes);
    assert_figures(&outcomes);
    let seconds = 20.0 * outcomes.len() as f64;
    let alarms: u32 = outcomes.iter().map(|o| o.steps).sum();
    println!("  steps of the load that were none: {alarms} in {seconds:.0} s");
    assert!(alarms <= 2);
}

#[test]
fn it_identifies_under_any_controller() {
    for kind in [Kind::Cascade, Kind::PiD, Kind::Relay] {
        let outcomes = saturated_servos(kind, 200, 20.0);
        report(&format!("{kind:?}"), &outcomes);
        assert_figures(&outcomes);
    }
}

#[test]
fn it_starts_without_a_guess() {
    for guess in [None, Some(30.0), Some(1.0 / 30.0)] {
        let outcomes = on_all_cores(300, |i| {
            let mut servo = ordinary_servo(i + 1000);
            let mut draw = Draw::new(i + 555);
            // b over 1000 : 1, the limit with it.
            let authority = servo.authority();
            let b = draw.between(1.0, 1000.0) * 3.0;
            servo.parameters.b = b;
            servo.limit = authority / b;
            let part = draw.uniform(0.02, 0.6);
            let amplitude = amplitude_for(Kind::Pid, &servo, part);
            let mut config = servo.settings();
            if let Some(factor) = guess {
                config.identifier.initial.b = Some(factor * b);
            }
            run::<f32>(Kind::Pid, &servo, amplitude, 2.0, &config)
        });
        report(&format!("start, guess {guess:?}"), &outcomes);
        let known = per_cent(&outcomes, |o| o.b() <= 0.01);
        println!("  b within 1 %: {known:.1} %");
        assert!(known >= 98.0);
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

fn humble<I: Identify<f32> + FromSettings>(i: u32) -> (Ending, Servo, String) {
    const TIME: f64 = 20.0;
    let servo = humble_servo(i);
    let mut draw = Draw::new(i + 4242);
    let kind = draw.one_of(&[Kind::Pid, Kind::Cascade, Kind::PiD]);
    // From a motion of a few counts to full use of the limit.
    let natural = servo.authority() / (servo.bandwidth * servo.bandwidth);
    let amplitude = draw.between(10.0 * servo.count(), 20.0 * servo.count() + natural);
    let identifier = servo.settings().build::<I>().expect("settings");
    let mut state = identifier.start();
    let mut run = Loop::new(kind, &servo, amplitude);
    let samples = (TIME / servo.sample_time) as u64;
    let (mut path, mut before, mut events) = (0.0, None, Vec::new());
    let mut error = 0.0;
    for k in 0..samples {
        let (increment, command) = run.sample();
        let seen = learn(&identifier, &mut state, (increment, command));
        if seen.event != Event::None {
            events.push((k as f64 * servo.sample_time, seen.event));
        }
        if 4 * k >= 3 * samples {
            path += increment.abs();
            error += f64::from(seen.output_error).powi(2);
            if before.is_none() {
                before = Some(shown(&identifier, &state));
            }
        }
    }
    let found = shown(&identifier, &state);
    let truth = servo.parameters;
    let off = (found.b / truth.b - 1.0).abs();
    let deviation = identifier
        .report(&state)
        .errors_of_parameters()
        .map_or(f64::INFINITY, |e| e.b / truth.b);
    let still = before.is_some_and(|before| (before.b / found.b - 1.0).abs() < 1e-3);
    let ending = if identifier.report(&state).errors_of_parameters().is_none() {
        if path < 30.0 * 0.25 * TIME {
            Ending::NoMotion
        } else {
            Ending::NotStarted
        }
    } else if off < 0.05 {
        Ending::Good
    } else if off < 0.2 || off < 4.0 * deviation {
        Ending::Fair
    } else if identifier.at_bounds_in(&identifier.snapshot(&state)) != PerParameter::default() {
        Ending::AtBound
    } else if path < 30.0 * 0.25 * TIME {
        Ending::NoMotion
    } else if still {
        Ending::Frozen
    } else {
        Ending::Wrong
    };
    events.truncate(4);
    let rms = (error / (0.25 * samples as f64) * 12.0).sqrt();
    (
        ending,
        servo,
        format!(
            "{kind:?} b {:.3} ± {deviation:.3} a {:.2} {:.2} c {:.2} {:.2} d {:.2} {:.2} rms {rms:.2} path {path:.0} bw {:.1} sat {:.2} {events:?}",
            found.b / truth.b,
            truth.a,
            found.a,
            truth.coulomb,
            found.coulomb,
            truth.load,
            found.load,
            identifier.report(&state).bandwidth.unwrap_or(0.0),
            run.saturation()
        ),
    )
}

/// Counts the outcomes of runs over ordinary servos, prints the counts and some failures.
fn endings<I: Identify<f32> + FromSettings>(servos: u32) -> Vec<(Ending, Servo, String)> {
    let runs = on_all_cores(servos, humble::<I>);
    for ending in [
        Ending::Good,
        Ending::Fair,
        Ending::NoMotion,
        Ending::NotStarted,
        Ending::AtBound,
        Ending::Wrong,
        Ending::Frozen,
    ] {
        let count = runs.iter().filter(|(e, _, _)| *e == ending).count();
        println!("  {ending:?}: {count}");
        if ending >= Ending::NotStarted {
            for (_, s, text) in runs.iter().filter(|(e, _, _)| *e == ending).take(12) {
                println!(
                    "    {} {text} | auth {:.0} cpr {:.0} T {:.2e} w {:.1}",
                    s.seed,
                    s.authority(),
                    s.counts_per_rev,
                    s.sample_time,
                    s.bandwidth
                );
            }
        }
    }
    runs
}

fn frozen(runs: &[(Ending, Servo, String)]) -> usize {
    runs.iter()
        .filter(|(ending, _, _)| *ending == Ending::Frozen)
        .count()
}

/// `SERVOS=2000` for as many.
#[test]
fn ordinary_servos_do_not_freeze() {
    let given = std::env::var("SERVOS").ok();
    let servos = given.and_then(|text| text.parse().ok()).unwrap_or(600);
    let runs = endings::<Identifier<f32>>(servos);
    assert_eq!(frozen(&runs), 0);
    assert!(per_cent(&runs, |(e, _, _)| *e == Ending::Wrong) <= 0.5);
    assert!(per_cent(&runs, |(e, _, _)| *e <= Ending::NoMotion) >= 99.0);
}

struct LoadStep {
    servo: Servo,
    /// Errors of the load over the step: after 0.1 s, after 0.25 s, after 1.5 s.
    errors: [f64; 3],
    noticed: f64,
    /// Change of a and b over the next 1.5 s.
    moved: [f64; 2],
}

fn load_steps(i: u32) -> (Vec<LoadStep>, [u32; 2], f64) {
    const SETTLED: f64 = 5.0;
    const EVERY: f64 = 1.5;
    let servo = ordinary_servo(i);
    let mut draw = Draw::new(i + 31_337);
    let part = draw.uniform(0.1, 0.5);
    let amplitude = amplitude_for(Kind::Pid, &servo, part);
    let identifier = servo
        .settings()
        .build::<Identifier<f32>>()
        .expect("settings");
    let mut state = identifier.start();
    let mut run = Loop::new(Kind::Pid, &servo, amplitude);
    let mut feed = |run: &mut Loop, time: f64| {
        let mut steps = 0_u32;
        let mut first = f64::INFINITY;
        for k in 0..(time / servo.sample_time) as u64 {
            let (increment, command) = run.sample();
            let seen = learn(&identifier, &mut state, (increment, command));
            if seen.event == Event::LoadStep {
                steps += 1;
                first = first.min(k as f64 * servo.sample_time);
            }
        }
        (shown(&identifier, &state), steps, first)
    };
    let (mut before, _, _) = feed(&mut run, SETTLED);
    let mut results = Vec::new();
    let mut unasked = 0;
    let mut repeated = 0_u32;
    for _ in 0..6 {
        // Half the quiet time before the step counts for false alarms.
        let (_, steps, _) = feed(&mut run, 0.5 * EVERY);
        unasked += steps;
        let size = draw.uniform(0.03, 0.15) * servo.authority();
        let up = servo.parameters.load + run.extra_load < 0.0;
        let step = if up { size } else { -size };
        run.extra_load += step;
        let truth = servo.parameters.load + run.extra_load;
        let error = |found: &ServoParameters| ((found.load - truth) / step).abs();
        let (at_100_ms, one, first) = feed(&mut run, 0.1);
        let (at_250_ms, two, _) = feed(&mut run, 0.15);
        let (after, three, _) = feed(&mut run, EVERY - 0.25);
        repeated += (one + two + three).saturating_sub(1);
        results.push(LoadStep {
            servo,
            errors: [error(&at_100_ms), error(&at_250_ms), error(&after)],
            noticed: first,
            moved: [(after.a - before.a).abs(), (after.b / before.b - 1.0).abs()],
        });
        before = after;
    }
    (results, [unasked, repeated], 6.0 * 0.5 * EVERY)
}

#[test]
fn steps_of_the_load_are_followed() {
    let runs = on_all_cores(200, load_steps);
    let unasked: u32 = runs.iter().map(|(_, [unasked, _], _)| unasked).sum();
    let repeated: u32 = runs.iter().map(|(_, [_, repeated], _)| repeated).sum();
    let time: f64 = runs.iter().map(|(_, _, time)| time).sum();
    let steps: Vec<LoadStep> = runs.into_iter().flat_map(|(steps, _, _)| steps).collect();
    let column = |name: &str, f: &dyn Fn(&LoadStep) -> f64| {
        let values: Vec<f64> = steps.iter().map(f).collect();
        let q = |part| quantile(&values, part);
        println!(
            "  {name:28} {:9.5} {:9.5} {:9.5} {:9.5}",
            q(0.5),
            q(0.9),
            q(0.95),
            q(1.0)
        );
    };
    println!(
        "{} steps of the load; median, 90 %, 95 %, worst",
        steps.len()
    );
    column("noticed after, s", &|s| s.noticed);
    column("error after 0.1 s / step", &|s| s.errors[0]);
    column("error after 0.25 s / step", &|s| s.errors[1]);
    column("error after 1.5 s / step", &|s| s.errors[2]);
    column("a moved, 1/s", &|s| s.moved[0]);
    column("b moved, relative", &|s| s.moved[1]);
    println!(
        "  within 10 %: after 0.1 s {:.1} %, after 0.25 s {:.1} %; b moved < 0.2 % {:.1} %, a {:.1} %; false alarms {unasked} in {time:.0} s, second searches {repeated}",
        per_cent(&steps, |s| s.errors[0] <= 0.1),
        per_cent(&steps, |s| s.errors[1] <= 0.1),
        per_cent(&steps, |s| s.moved[1] <= 2e-3),
        per_cent(&steps, |s| s.moved[0]
            <= (2e-3 * s.servo.parameters.a).max(2e-3)),
    );
    assert!(per_cent(&steps, |s| s.errors[0] <= 0.1) >= 85.0);
    assert!(per_cent(&steps, |s| s.errors[1] <= 0.1) >= 97.0);
    assert!(per_cent(&steps, |s| s.moved[1] <= 2e-3) >= 97.0);
    assert!(unasked <= 1);
}
