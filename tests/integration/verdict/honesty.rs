//! A result that is called converged is right, and a right result is called converged.

use host_sim::scenario::Scenario;
use identifier_core::parameters::Parameter;
use identifier_log::result::Summary;
use identifier_log::verdict::Status;
use integration_tests::{Random, factor, in_parallel, run};

use super::campaign::{ALL_FOUR, KINDS, Kind};

/// The estimators under test; the gradient has a parameter range about the servo.
const ESTIMATORS: [&str; 3] = [
    ALL_FOUR,
    "law = \"gauss-newton\"\nparameters = [\"a\", \"b\"]",
    "law = \"gradient\"\nparameters = [\"a\", \"b\", \"coulomb\"]",
];

/// A kind with everything drawn about it.
fn drawn(random: &mut Random) -> Kind {
    let kind = KINDS[random.uniform(0.0, 2.999) as usize];
    let b = kind.b * random.log_uniform(0.5, 2.0);
    Kind {
        a: kind.a * random.log_uniform(0.3, 3.0),
        b,
        coulomb: kind.coulomb * random.log_uniform(0.3, 3.0),
        counts: kind.counts * random.log_uniform(0.25, 2.0),
        ..kind
    }
}

/// The error of an estimate over its limit: b 5 %, friction and load 20 % of themselves or a
/// hundredth of the command's acceleration.
fn wrongness(summary: &Summary, kind: &Kind) -> f64 {
    let truth = summary.truth.expect("known");
    let off = |parameter: Parameter| {
        let found = summary.estimate(parameter)?.value;
        Some((found - truth.get(parameter)).abs())
    };
    let push = 0.01 * truth.b * kind.command;
    let force = |parameter: Parameter| {
        let allowed = (0.2 * truth.get(parameter).abs()).max(push);
        off(parameter).unwrap_or(0.0) / allowed
    };
    let b = off(Parameter::B).unwrap_or(0.0) / (0.05 * truth.b);
    b.max(force(Parameter::Coulomb)).max(force(Parameter::Load))
}

/// A scenario in which something is amiss: little excitation, too short, a delay, a dead band, a coarse encoder with
/// noise.
fn amiss(random: &mut Random) -> (Kind, Scenario) {
    let mut kind = drawn(random);
    let count = std::f64::consts::TAU / kind.counts;
    let mut plant = String::new();
    let mut encoder = String::new();
    match random.uniform(0.0, 6.0) as u32 {
        0 | 1 => {
            // Two to twenty counts of amplitude.
            let amplitude = random.log_uniform(2.0, 20.0) * count;
            kind.noise[0] = amplitude * amplitude * kind.noise[1];
            kind.command = kind.gains[0] * amplitude;
        }
        2 => kind.duration *= random.log_uniform(0.01, 0.3),
        3 => plant = format!("delay = {:?}", random.uniform(0.3, 4.0) * kind.sample_time),
        4 => {
            plant = format!(
                "dead_band = {:?}",
                random.uniform(0.005, 0.05) * kind.command
            )
        }
        _ => encoder = format!("noise = {:?}", random.log_uniform(0.3, 30.0) * count),
    }
    let coulomb_free = random.uniform(0.0, 1.0) < 0.3;
    if coulomb_free {
        kind.coulomb = 0.0;
    }
    let load = random.uniform(-0.1, 0.1) * kind.b * kind.command;
    plant = format!("load = {load:?}\n{plant}");
    let place = random.uniform(0.0, 2.999) as usize;
    let law = if place == 2 {
        let [low, high] = [
            kind.b * random.log_uniform(0.4, 0.9),
            kind.b * random.log_uniform(1.1, 1.5),
        ];
        format!(
            "{}\nservo_range = {{ a = [0.0, 10.0], b = [{low:?}, {high:?}] }}",
            ESTIMATORS[2]
        )
    } else {
        ESTIMATORS[place].to_owned()
    };
    let scenario = kind.run(random.seed(), &plant, &encoder, &law);
    (kind, scenario)
}

#[test]
fn a_result_called_converged_is_right() {
    let mut random = Random::new(77);
    let runs: Vec<(Kind, Scenario)> = (0..14 * factor::<u32>())
        .map(|_| amiss(&mut random))
        .collect();
    let found = in_parallel(&runs, |(kind, scenario)| (*kind, run(scenario)));
    let mut statuses = std::collections::BTreeMap::<&str, [u32; 2]>::new();
    for (kind, summary) in &found {
        let wrong = wrongness(summary, kind);
        let right = wrong <= 1.0;
        statuses.entry(summary.status().name()).or_default()[usize::from(right)] += 1;
    }
    println!("[wrong, right]: {statuses:?}");
    let [wrong, right] = statuses.get("converged").copied().unwrap_or_default();
    println!(
        "wrong of the converged: {:.2} %",
        100.0 * f64::from(wrong) / f64::from(wrong + right)
    );
    assert!(f64::from(wrong) <= 0.005 * f64::from(wrong + right));
}

#[test]
fn exact_servos_that_move_are_converged_and_their_standard_errors_cover() {
    let mut random = Random::new(5);
    let runs: Vec<(Kind, Scenario)> = (0..18 * factor::<u32>())
        .map(|_| {
            let kind = drawn(&mut random);
            let load = random.uniform(-0.1, 0.1) * kind.b * kind.command;
            (
                kind,
                kind.run(random.seed(), &format!("load = {load:?}"), "", ALL_FOUR),
            )
        })
        .collect();
    let found = in_parallel(&runs, |(kind, scenario)| (*kind, run(scenario)));
    let (mut converged, mut covered, mut all, mut alarms) = (0, 0, 0, 0);
    for (kind, summary) in &found {
        converged += u32::from(summary.status() == Status::Converged);
        alarms += u32::from(summary.status() == Status::Unexplained);
        if summary.status() != Status::Converged {
            println!(
                "{} {} {:?}",
                kind.name,
                summary.reason,
                (summary.residual, &summary.cause)
            );
        }
        for parameter in Parameter::ALL {
            let estimate = summary.estimate(parameter).expect("estimated");
            let error = (estimate.last - summary.truth.expect("known").get(parameter)).abs();
            all += 1;
            let within = estimate
                .std_error
                .is_some_and(|std_error| error <= 3.0 * std_error);
            covered += u32::from(within);
            if !within {
                println!(
                    "{} {}: {error} {:?}",
                    kind.name,
                    parameter.name(),
                    estimate.std_error
                );
            }
        }
    }
    println!(
        "converged {converged}, unexplained {alarms} of {}; {covered} of {all} within three standard errors",
        found.len()
    );
    assert!(f64::from(converged) >= 0.97 * found.len() as f64);
    assert!(f64::from(covered) >= 0.98 * f64::from(all));
}

#[test]
fn standard_errors_of_a_fit_are_the_scatter() {
    const RUNS: usize = 8;
    let kind = Kind {
        duration: 1.0,
        ..KINDS[0]
    };
    let plant = "load = 8.0\nresonance = 900.0\nresonance_damping = 0.05\ninertia_ratio = 0.4";
    for (plant, on_load) in [("load = 8.0", false), (plant, true)] {
        let runs: Vec<Scenario> = (1..)
            .take(RUNS)
            .map(|seed| {
                let mut scenario = kind.run(seed, plant, "", "law = \"fit\"");
                scenario.effects.encoder_on_load = on_load;
                scenario
            })
            .collect();
        let found = in_parallel(&runs, run);
        // The error of a also holds what so short a log leaves open.
        for parameter in [Parameter::B, Parameter::Coulomb, Parameter::Load] {
            let squares = found.iter().map(|summary| {
                let estimate = summary.estimate(parameter).expect("estimated");
                let off = estimate.value - summary.truth.expect("known").get(parameter);
                [off, estimate.std_error.expect("known")].map(|x| x * x)
            });
            let [scatter, own] =
                squares.fold([0.0; 2], |[x, y], [more, further]| [x + more, y + further]);
            let ratio = (own / scatter).sqrt();
            println!("on load {on_load}, {}: {ratio:.2}", parameter.name());
            // Of eight runs a scatter is known to a quarter, and an interval holds more than chance.
            assert!(
                (0.5..6.0).contains(&ratio),
                "on load {on_load}, {}: {ratio}",
                parameter.name()
            );
        }
    }
}

#[test]
fn encoder_errors_alone_raise_no_alarm() {
    let mut random = Random::new(11);
    let runs: Vec<(Kind, &str, Scenario)> = (0..6 * factor::<u32>())
        .flat_map(|_| {
            let kind = drawn(&mut random);
            let count = std::f64::consts::TAU / kind.counts;
            let seed = random.seed();
            [
                ("white noise", format!("noise = {count:?}")),
                ("jitter", "jitter = 0.1".to_owned()),
                ("eccentricity", "eccentricity = 0.002".to_owned()),
            ]
            .map(|(name, encoder)| (kind, name, kind.run(seed, "", &encoder, ALL_FOUR)))
        })
        .collect();
    let found = in_parallel(&runs, |(kind, name, scenario)| {
        (*kind, *name, run(scenario))
    });
    let mut table = std::collections::BTreeMap::<(&str, &str), u32>::new();
    for (kind, name, summary) in &found {
        let status = summary.status();
        *table.entry((name, status.name())).or_default() += 1;
        if status != Status::Converged {
            println!("{} {name}: {}", kind.name, summary.reason);
        }
    }
    println!("{table:?}");
    let alarms = found
        .iter()
        .filter(|(.., summary)| summary.status() == Status::Unexplained)
        .count();
    assert!(alarms as f64 <= 0.02 * found.len() as f64);
}

/// The rounding of 256 counts is neither white nor small beside the motion, and resembles a resonance.
#[test]
fn a_coarse_encoder_is_not_taken_for_a_resonance() {
    let [paper, ..] = KINDS;
    for sample_time in [5e-5, 1e-3] {
        let coarse = Kind {
            sample_time,
            counts: 256.0,
            duration: 6.0,
            ..paper
        };
        for seed in 1..=4 {
            let summary = run(&coarse.run(seed, "", "", ALL_FOUR));
            assert_ne!(summary.status(), Status::Unexplained, "{}", summary.reason);
            assert!(summary.cause.is_none(), "{}", summary.reason);
        }
    }
}

#[test]
fn a_declared_amplifier_is_no_lack_of_the_model() {
    let [paper, ..] = KINDS;
    for (effect, declare) in [
        ("current_loop = 0.002", [0.0, 0.0, 0.002]),
        ("delay = 0.0023", [0.0023, 0.0, 0.0]),
        ("dead_band = 0.2", [0.0, 0.2, 0.0]),
        ("current_loop = 0.002\ndead_band = 0.2", [0.0, 0.2, 0.002]),
    ] {
        let mut scenario = paper.run(7, effect, "", ALL_FOUR);
        let hidden = run(&scenario);
        assert_ne!(hidden.status(), Status::Converged, "{effect}");
        let terms = &mut scenario.stated.identifier.terms;
        [terms.delay, terms.dead_band, terms.current_loop] = declare;
        let declared = run(&scenario);
        assert_eq!(
            declared.status(),
            Status::Converged,
            "{effect}: {}",
            declared.reason
        );
        let off = declared.estimates.b.last / 257.7 - 1.0;
        assert!(off.abs() < 0.005, "{effect}: {off}");
        let off = declared.estimates.coulomb.last / 5.0 - 1.0;
        assert!(off.abs() < 0.05, "{effect}: {off}");
    }
}
