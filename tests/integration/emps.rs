//! A measured log: the Electro-Mechanical Positioning System of A. Janot, M. Gautier and M. Brunot
//! (Workshop on Nonlinear System Identification Benchmarks, 2019; nonlinearbenchmark.org).
//!
//! The log is not part of this project. Put `emps_train.csv.gz` (columns t_s, q_ref_m, q_m, vir_V)
//! where `EMPS_LOG` points, or in `shared/data/emps` beside the project.

use std::path::{Path, PathBuf};

use host_sim::scenario::{Arithmetic, LogSettings, Purpose, Scenario};
use host_sim::{IdentifiedScenario, identify_logs};
use identifier_core::parameters::{ServoParameters, Unknown};
use identifier_log::FoundServo;
use identifier_log::experiment::TermEstimate;
use identifier_log::log::Log;
use identifier_log::predict::predict;
use identifier_log::result::Summary;
use identifier_log::verdict::Status;
use integration_tests::{Random, environment, in_parallel, skipped};

/// Force per command, N/V: known.
const FORCE: f64 = 35.150_651_882_485_47;

/// Published off-line reference (inverse model, zero-phase filtering): M kg, Fv N/(m/s), Fc N, OF N.
const PUBLISHED: [f64; 4] = [95.1089, 203.5034, 20.3935, -3.1648];

/// The same for friction that differs with the direction: M, Fv forwards and backwards, and the mean of
/// Fc's 20.144 and 20.628.
const ASYMMETRIC: [f64; 4] = [95.154, 166.71, 240.42, 20.386];

fn log_path() -> Option<PathBuf> {
    // A log that is named must exist: reading it fails if it does not.
    if let Some(named) = std::env::var_os("EMPS_LOG") {
        return Some(named.into());
    }
    let beside =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/emps/emps_train.csv.gz");
    beside.exists().then_some(beside)
}

/// A scenario of the log with an estimator, from the published values times these factors.
fn scenario(law: &str, factors: [f64; 4]) -> Scenario {
    let [mass, viscous, coulomb, offset] = std::array::from_fn(|i| PUBLISHED[i] * factors[i]);
    let text = format!(
        "[amplifier]\n\
         limit = 10.0\n\
         [controller]\n\
         kp = {kp}\n\
         kd = 243.45\n\
         ki = 0.0\n\
         sample_time = 0.001\n\
         velocity_filter = {{ kind = \"averaged-difference\" }}\n\
         [identifier]\n\
         {law}\n\
         parameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n\
         initial = {{ a = {a}, b = {b}, coulomb = {c}, load = {d} }}\n\
         arithmetic = \"f64\"\n\
         [log]\n\
         time = \"t_s\"\n\
         reference = \"q_ref_m\"\n\
         position = \"q_m\"\n\
         command = \"vir_V\"\n",
        kp = 160.18 * 243.45,
        a = viscous / mass,
        b = FORCE / mass,
        c = coulomb / mass,
        d = -offset / mass,
    );
    Scenario::parse("emps", &text, Purpose::Replay).expect("valid")
}

fn found(scenario: Scenario, log: &Log, passes: u32) -> IdentifiedScenario {
    let logs = std::slice::from_ref(log);
    let found = identify_logs(scenario, logs, &[], passes, &|| true, &mut |_, _| {});
    found.expect("it can be replayed")
}

/// M, Fv, Fc, OF after `passes`.
fn identify(log: &Log, scenario: Scenario, passes: u32) -> [f64; 4] {
    let declared = scenario.stated.controller.is_some();
    let summary = found(scenario, log, passes).summary;
    assert_eq!(summary.replay.agreement.is_some(), declared);
    if let Some(agreement) = &summary.replay.agreement {
        assert!(agreement.relative < 0.01, "{agreement}");
    }
    let mass = FORCE / summary.estimates.b.last;
    [
        mass,
        summary.estimates.a.last * mass,
        summary.estimates.coulomb.last * mass,
        -summary.estimates.load.last * mass,
    ]
}

/// M, Fv forwards and backwards, Fc.
fn by_direction(summary: &Summary, asymmetry: f64) -> [f64; 4] {
    let mass = FORCE / summary.estimates.b.last;
    let a = summary.estimates.a.last;
    let coulomb = summary.estimates.coulomb.last;
    [1.0, a + asymmetry, a - asymmetry, coulomb].map(|part| part * mass)
}

/// The log, if it is present.
fn log() -> Option<Log> {
    let Some(path) = log_path() else {
        skipped("the EMPS log is not at hand: EMPS_LOG names it");
        return None;
    };
    let columns = scenario("law = \"gauss-newton\"", [1.0; 4]).log_columns();
    Some(read(&path, &columns))
}

fn read(path: &Path, columns: &LogSettings) -> Log {
    Log::read(path, columns, Some(1e-3)).expect("a sound log")
}

/// Starts, times `CAMPAIGN`.
const STARTS: usize = 4;

/// Results of one pass from starts of 0.3 to 3 times the published values.
fn from_many_starts(log: &Log, law: &str, arithmetic: Arithmetic) -> Vec<Summary> {
    let mut random = Random::new(5);
    let starts: Vec<[f64; 4]> = (0..STARTS * environment("CAMPAIGN").unwrap_or(1))
        .map(|_| std::array::from_fn(|_| random.log_uniform(0.3, 3.0)))
        .collect();
    in_parallel(&starts, |&factors| {
        let mut scenario = scenario(law, factors);
        scenario.identifier.arithmetic = arithmetic;
        found(scenario, log, 1).summary
    })
}

/// True if the largest and the smallest of some values differ by less than a share of the first.
fn in_one_place(values: impl Iterator<Item = f64> + Clone, part: f64) -> bool {
    let (low, high) = values
        .clone()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
    values
        .into_iter()
        .next()
        .is_some_and(|first| high - low <= part * first.abs())
}

#[test]
fn one_causal_pass_finds_the_published_values_from_a_third_to_three_times_them() {
    let Some(log) = log() else { return };
    let law = "law = \"gauss-newton\"\nrequired_terms = [\"asymmetry\"]";
    for (arithmetic, apart) in [(Arithmetic::F32, 5e-3), (Arithmetic::F64, 1e-3)] {
        let found: Vec<[f64; 4]> = from_many_starts(&log, law, arithmetic)
            .iter()
            .map(|summary| by_direction(summary, summary.estimates.terms[0].value))
            .collect();
        println!("{arithmetic:?}: M, Fv+, Fv-, Fc = {:.3?}", found[0]);
        for values in &found {
            for i in 0..4 {
                let off = values[i] / ASYMMETRIC[i] - 1.0;
                assert!(off.abs() < [0.01, 0.03, 0.03, 0.03][i], "{values:?}");
            }
        }
        for i in 0..4 {
            assert!(in_one_place(found.iter().map(|values| values[i]), apart));
        }
    }
}

/// One fit to the whole log, of which nothing is known beforehand, and no term is asked for.
#[test]
fn one_fit_finds_the_asymmetry_first_and_then_the_published_values() {
    let Some(log) = log() else { return };
    let text = "[amplifier]\nlimit = 10.0\n[identifier]\nlaw = \"fit\"\n[log]\ntime = \"t_s\"\n\
                position = \"q_m\"\ncommand = \"vir_V\"\n";
    let scenario = Scenario::parse("emps", text, Purpose::Replay).expect("valid settings");
    let summary = found(scenario, &log, 1).summary;
    assert_eq!(summary.status(), Status::Converged, "{}", summary.reason);
    let fit = summary.fit.as_ref().expect("a fit");
    let first = fit.effects.first().map(|effect| (effect.name, effect.or));
    assert_eq!(first, Some(("asymmetry", None)), "{fit:?}");
    let size = |unknown| {
        let mut terms = summary.estimates.terms.iter();
        terms
            .find(|term| term.unknown == unknown)
            .map(|term| term.value)
    };
    let asymmetry = size(Unknown::Asymmetry).expect("it entered");
    let found = by_direction(&summary, asymmetry);
    println!("M, Fv+, Fv-, Fc = {found:.3?}");
    for (i, most) in [0.01, 0.04, 0.04, 0.05].into_iter().enumerate() {
        let off = found[i] / ASYMMETRIC[i] - 1.0;
        assert!(off.abs() < most, "{found:?}");
    }
}

/// A model of one friction for both directions ends between them, wherever it starts.
#[test]
fn without_the_asymmetry_every_start_ends_in_one_place() {
    let Some(log) = log() else { return };
    let summaries = from_many_starts(&log, "law = \"gauss-newton\"", Arithmetic::F64);
    let mass = FORCE / summaries[0].estimates.b.last;
    let viscous = summaries[0].estimates.a.last * mass;
    println!("M {mass:.3}, Fv {viscous:.2}");
    assert!((mass / PUBLISHED[0] - 1.0).abs() < 0.01, "{mass}");
    assert!((viscous / PUBLISHED[1] - 1.0).abs() < 0.03, "{viscous}");
    for of in [
        |s: &Summary| s.estimates.a.last,
        |s: &Summary| s.estimates.b.last,
        |s: &Summary| s.estimates.coulomb.last,
    ] {
        assert!(in_one_place(summaries.iter().map(of), 1e-3));
    }
}

/// Both published protocols, on the log that was learnt from: the whole loop simulated from the
/// reference (relative errors of position, velocity and command), and the servo driven by the recorded
/// command (m). Printed beside the predictions of the published values.
#[test]
fn both_published_protocols_give_errors_like_the_published_values() {
    let Some(log) = log() else { return };
    let scenario_of = |terms: &str| {
        let law = format!("law = \"gauss-newton\"\n{terms}");
        scenario(&law, [1.0; 4])
    };
    let predicted = |scenario: &Scenario, servo: &FoundServo| {
        let logs = std::slice::from_ref(&log);
        let options = scenario.options.clone().fitted(logs, false);
        predict(&options, servo, &log).expect("it can be predicted")
    };
    let found = |terms: &str| {
        let scenario = scenario_of(terms);
        let servo = found(scenario.clone(), &log, 1).servo.expect("a servo");
        predicted(&scenario, &servo)
    };
    let published = |[mass, viscous, asymmetry, coulomb, offset]: [f64; 5]| {
        let scenario = scenario_of("");
        let known = ServoParameters {
            a: viscous / mass,
            b: FORCE / mass,
            coulomb: coulomb / mass,
            load: -offset / mass,
        };
        let asymmetry = TermEstimate {
            unknown: Unknown::Asymmetry,
            value: asymmetry / mass,
            std_error: 0.0,
            since: 0,
        };
        predicted(
            &scenario,
            &FoundServo::of_estimates(&scenario, &known, &[asymmetry]),
        )
    };
    let [mass, forwards, backwards, coulomb] = ASYMMETRIC;
    let halves = (0.5 * (forwards + backwards), 0.5 * (forwards - backwards));
    let low_speed = "required_terms = [\"asymmetry\", \"low-speed\"]\nlow_speed_velocity = 0.015";
    let [m, v, c, o] = PUBLISHED;
    let rows = [
        ("published M, Fv, Fc, OF", published([m, v, 0.0, c, o])),
        (
            "published M, Fv+, Fv-, Fc",
            published([mass, halves.0, halves.1, coulomb, 0.0]),
        ),
        ("a, b, c, d", found("")),
        (
            "a, b, c, d, asymmetry",
            found("required_terms = [\"asymmetry\"]"),
        ),
        ("a, b, c, d, asymmetry, low speed", found(low_speed)),
    ];
    let errors = rows.map(|(name, predicted)| {
        let (closed, open) = predicted
            .closed_loop
            .zip(predicted.open_loop)
            .expect("a loop and a command");
        let command = closed.command.expect("a recorded command");
        println!(
            "{name}: position {:.4} %, velocity {:.3} %, command {:.2} %; open loop {:.2} mm",
            100.0 * closed.position,
            100.0 * closed.velocity,
            100.0 * command,
            1e3 * open.rms
        );
        [closed.position, closed.velocity, command]
    });
    let [_, published, ours, with_asymmetry, with_low_speed] = errors;
    // The causal estimates predict as well as the published values, and each term helps.
    for i in 0..3 {
        assert!(with_asymmetry[i] < 1.1 * published[i], "{errors:?}");
    }
    assert!(with_asymmetry[2] < 0.9 * ours[2], "{errors:?}");
    assert!(with_low_speed[2] < 0.9 * with_asymmetry[2], "{errors:?}");
}

/// Forty passes of the gradient come near the published values. Nothing need be declared of the loop: the recorded command and
/// the correction's gains are enough.
#[test]
fn the_recorded_command_needs_neither_controller_nor_reference() {
    let Some(log) = log() else { return };
    let law = "law = \"paper\"\nmu = 40.0\ngamma = [55.0, 0.075, 7.5, 7.5]";
    let declared = scenario(law, [1.0; 4]);
    let mut listening = declared.clone();
    let controller = listening.stated.controller.take().expect("it is declared");
    listening.stated.identifier.correction = Some([controller.kp, controller.kd, controller.ki]);
    listening.log = Some(LogSettings {
        reference: None,
        ..declared.log_columns()
    });
    let bare = read(&log_path().expect("it is there"), &listening.log_columns());
    let [known, alone] = [identify(&log, declared, 40), identify(&bare, listening, 40)];
    println!("M, Fv, Fc, OF = {known:.3?} with the controller declared, {alone:.3?} without");
    for (i, tolerance) in [0.01, 0.05, 0.04, 0.02].into_iter().enumerate() {
        let off = known[i] / PUBLISHED[i] - 1.0;
        assert!(off.abs() < tolerance, "{known:?}");
        assert!((alone[i] / known[i] - 1.0).abs() < 5e-3);
    }
}
