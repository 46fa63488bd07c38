//! Three number formats, one answer: the same experiments in f64, f32 and fixed point.

use host_sim::drift::{self, Compared, Difference, Differences, DriftResult};
use host_sim::scenario::{Arithmetic, Reference, Scenario};
use identifier_core::excitation::Excitation;
use identifier_core::parameters::ServoParameters;
use integration_tests::{in_parallel, parse, servo};

const PAPER: &str = include_str!("../../host-sim/scenarios/paper.toml");
const RUBBING: &str = include_str!("../../host-sim/scenarios/drift.toml");

/// Largest distance of a format's tail means from those of f64: â (1/s), b̂, ĉ, d̂ (relative).
struct Tolerance {
    a: f64,
    b: f64,
    coulomb: f64,
    load: f64,
}

const FIXED: Tolerance = Tolerance {
    a: 0.02,
    b: 0.003,
    coulomb: 0.03,
    load: 0.01,
};
const F32: Tolerance = Tolerance {
    a: 0.002,
    b: 0.0002,
    coulomb: 0.005,
    load: 0.002,
};

/// The differences on the same measurements.
fn side_by_side(scenario: &Scenario, turns: u32) -> DriftResult {
    let units = scenario.units();
    let reference = Reference::<f64>::new(&units, &scenario.excitation).expect("valid");
    let mut state = reference.start();
    let mut differences = Differences::lasting(scenario.duration);
    drift::run(
        scenario,
        turns,
        scenario.samples(),
        &mut |_| reference.process(&mut state) * units.position_unit(),
        &mut |compared| differences.add(compared),
    )
    .expect("it fits");
    let result = differences.result(scenario.samples());
    assert!(result.all_finite);
    result
}

/// The differences of a format.
fn differences_of(differences: &DriftResult, format: Arithmetic) -> &[Difference] {
    match format {
        Arithmetic::Fixed => &differences.fixed,
        _ => &differences.f32,
    }
}

/// Distance of a signal from that of f64, the larger of mean and root mean square, and its size.
fn distance(differences: &DriftResult, format: Arithmetic, name: &str) -> (f64, f64) {
    let signal = differences_of(differences, format)
        .iter()
        .find(|signal| signal.name == name);
    let signal = signal.expect("a signal of that name");
    (signal.mean.abs().max(signal.rms), signal.size)
}

#[test]
fn fast_loops_and_many_turns_cost_nothing() {
    let cases = [
        (1e-4, 0),
        (5e-5, 0),
        (2.5e-5, 0),
        (1e-3, 100_000),
        (2.5e-5, 100_000),
    ];
    in_parallel(&cases, |&(sample_time, turns)| {
        let mut scenario = parse(RUBBING);
        scenario.stated.sample_time = sample_time;
        scenario.duration = 10.0;
        let differences = side_by_side(&scenario, turns);
        for format in [Arithmetic::F32, Arithmetic::Fixed] {
            let (a, _) = distance(&differences, format, "a");
            let (b, size) = distance(&differences, format, "b");
            println!(
                "T = {sample_time}, {turns} turns, {}: a off by {a:.1e} 1/s, b by {:.1e}",
                format.name(),
                b / size
            );
            assert!(a < 0.05 && b < 0.005 * size, "{}: {a} {b}", format.name());
        }
    });
}

/// Every sample of the last quarter, in both formats, against the figures above.
fn assert_no_drift(scenario: &Scenario, parameters: &[&str]) {
    let differences = side_by_side(scenario, 0);
    for (format, tolerance) in [(Arithmetic::F32, F32), (Arithmetic::Fixed, FIXED)] {
        assert!(distance(&differences, format, "a").0 < tolerance.a);
        for &name in parameters {
            let (off, size) = distance(&differences, format, name);
            let relative = match name {
                "b" => tolerance.b,
                "coulomb" => tolerance.coulomb,
                _ => tolerance.load,
            };
            assert!(off < relative * size, "{}: {name} {off}", format.name());
        }
    }
}

/// 2·10⁶ samples; 10⁹ are run on demand (docs/number-formats.md).
#[test]
fn a_soak_shows_no_drift() {
    let mut scenario = parse(RUBBING);
    scenario.duration = 2e3;
    assert_no_drift(&scenario, &["b", "coulomb", "load"]);
}

/// The reference is constant for 1000 s, 10⁶ samples, and then moves again.
#[test]
fn estimates_keep_still_without_excitation_and_do_not_burst_after_it() {
    /// Times of motion, before and afterwards, and of rest, s.
    const MOVING: f64 = 20.0;
    const STANDING: f64 = 1000.0;
    /// For the last step of the reference to die away, s.
    const DYING_AWAY: f64 = 1.0;
    for text in [RUBBING, PAPER] {
        let scenario = {
            let mut scenario = parse(text);
            servo(&mut scenario).load = 20.0;
            scenario
        };
        let units = scenario.units();
        let [moving, standing, dying_away] =
            [MOVING, STANDING, DYING_AWAY].map(|time| (time / units.sample_time()).round() as u64);
        let source = Reference::<f64>::new(&units, &scenario.excitation).expect("valid");
        let mut state = source.start();
        let mut last = 0.0;
        let mut reference = |k: u64| {
            if !(moving..moving + standing).contains(&k) {
                last = source.process(&mut state) * units.position_unit();
            }
            last
        };
        let mut before: Option<Compared> = None;
        let of = |servo: &ServoParameters| [servo.a, servo.b, servo.coulomb, servo.load];
        let mut worst = [[0.0_f64; 2]; 4];
        let mut k = 0;
        drift::run(
            &scenario,
            0,
            2 * moving + standing,
            &mut reference,
            &mut |compared| {
                if k == moving + dying_away {
                    before = Some(*compared);
                }
                if let Some(before) = &before {
                    let stands = k < moving + standing;
                    for (then, now) in before.signals.iter().zip(&compared.signals) {
                        for (i, worst) in worst.iter_mut().enumerate() {
                            let [then, now] = [then, now].map(|signals| of(&signals.estimates)[i]);
                            // A parameter that is not estimated is zero, and stays so.
                            let moved = (now - then).abs() / then.abs().max(1e-9);
                            let worst = &mut worst[usize::from(!stands)];
                            *worst = worst.max(moved);
                        }
                    }
                }
                k += 1;
            },
        )
        .expect("it fits");
        println!("standing, moving again (relative): a, b, c, d = {worst:.5?}");
        assert!(
            worst.iter().all(|[standing, _]| *standing < 0.01),
            "{worst:?}"
        );
        let [a, b, coulomb, load] = worst.map(|[_, moving]| moving);
        assert!(
            a < 0.5 && b < 0.02 && coulomb < 0.08 && load < 0.03,
            "{worst:?}"
        );
    }
}

/// Errors of the formats in the controller alone, in decibel over the signal.
#[test]
fn the_pid_alone_has_the_signal_to_noise_of_the_documentation() {
    let mut scenario = parse(PAPER);
    scenario.duration = 20.0;
    let differences = side_by_side(&scenario, 0);
    for (format, velocity, command) in [
        (Arithmetic::F32, 140.0, 130.0),
        (Arithmetic::Fixed, 145.0, 135.0),
    ] {
        let found = differences_of(&differences, format);
        let decibel = |name: &str| {
            let signal = found.iter().find(|signal| signal.name == name);
            let signal = signal.expect("a signal of that name");
            signal.signal_to_noise().expect("a difference")
        };
        println!(
            "{}: velocity {:.0} dB, command {:.0} dB",
            format.name(),
            decibel("velocity"),
            decibel("command")
        );
        assert!(decibel("velocity") > velocity && decibel("command") > command);
    }
}
