//! Logs with a scenario of wrong declarations: other gains, another encoder.

use std::collections::BTreeMap;

use host_sim::scenario::{Purpose, Scenario};
use host_sim::simulate;
use identifier_core::parameters::Parameter;
use identifier_log::result::Summary;
use identifier_log::verdict::Status;
use integration_tests::{Random, factor, in_parallel};
use servo_id::csv;

use super::campaign::{ALL_FOUR, KINDS, Kind};
use super::logs::identify::LogFile;

/// The scenario of a replay that takes gains and counts for this; without the recorded command the
/// declared controller computes one.
fn declared(kind: &Kind, with_command: bool) -> Scenario {
    let control_loop = kind.control_loop("");
    let command = if with_command {
        "command = \"command\""
    } else {
        ""
    };
    let text = format!(
        "{control_loop}[identifier]
{ALL_FOUR}
[log]
time = \"time_s\"
reference = \"reference_rad\"
position = \"position_rad\"
{command}
"
    );
    Scenario::parse("declared", &text, Purpose::Replay).expect("valid")
}

/// Runs a servo, writes its log, and replays that with the declarations.
fn replayed(kind: &Kind, seed: u32, taken_for: &Scenario) -> Summary {
    let scenario = kind.run(seed, "", "", ALL_FOUR);
    let mut trace = Vec::new();
    simulate::run(&scenario, &mut |sample| trace.push(*sample)).expect("it runs");
    let mut text = Vec::new();
    csv::trace(&mut text, &trace).expect("written");
    let found = LogFile::of(&text).replayed(taken_for.clone());
    found.expect("it can be replayed")
}

/// True if b is off by more than 5 %, or friction by more than a fifth and a hundredth of the
/// command's acceleration.
fn is_wrong(summary: &Summary, kind: &Kind) -> bool {
    let last = |parameter| {
        summary
            .estimate(parameter)
            .map_or(f64::NAN, |estimate| estimate.last)
    };
    let push = 0.01 * kind.b * kind.command;
    let b = (last(Parameter::B) / kind.b - 1.0).abs() <= 0.05;
    let coulomb = (last(Parameter::Coulomb) - kind.coulomb).abs() <= (0.2 * kind.coulomb).max(push);
    !(b && coulomb && last(Parameter::Load).abs() <= push)
}

#[test]
fn a_wrong_result_of_a_wrong_declaration_is_not_called_converged() {
    let mut random = Random::new(31);
    let cases: Vec<(Kind, &str, u32, Scenario)> = (0..6 * factor::<u32>())
        .flat_map(|number| {
            let kind = Kind {
                duration: 5.0,
                ..KINDS[number as usize % KINDS.len()]
            };
            let kind = Kind {
                duration: if kind.sample_time < 5e-4 {
                    1.5
                } else {
                    kind.duration
                },
                ..kind
            };
            let mut off = |spread: f64| random.log_uniform(1.0 / spread, spread);
            let [kp, kd, ki] = kind.gains;
            let proportional = Kind {
                gains: [kp * off(1.3), kd, ki],
                ..kind
            };
            let derivative = Kind {
                gains: [kp, kd * off(1.5), ki],
                ..kind
            };
            let coarse = Kind {
                counts: kind.counts * off(5.0),
                ..kind
            };
            let seed = random.seed();
            [
                (kind, "kp", seed, declared(&proportional, false)),
                (kind, "kd", seed, declared(&derivative, false)),
                (kind, "encoder", seed, declared(&coarse, true)),
            ]
        })
        .collect();
    let found = in_parallel(&cases, |(kind, _, seed, scenario)| {
        let summary = replayed(kind, *seed, scenario);
        let wrong = is_wrong(&summary, kind);
        (summary, wrong)
    });
    let mut table = BTreeMap::<(&str, &str, &str), u32>::new();
    for ((summary, wrong), (_, name, ..)) in found.iter().zip(&cases) {
        let kind = if *wrong { "wrong" } else { "right" };
        *table
            .entry((name, summary.status().name(), kind))
            .or_default() += 1;
    }
    println!("{table:#?}");
    let converged = |wrong: bool| {
        let of = |(summary, is): &&(Summary, bool)| {
            *is == wrong && summary.status() == Status::Converged
        };
        found.iter().filter(of).count()
    };
    assert!(converged(true) as f64 <= 0.005 * (converged(true) + converged(false)) as f64);
    assert!(converged(false) > 0);
}
