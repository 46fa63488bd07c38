//! The scan of logs: nothing is said of a healthy one, and every broken one is named or mended.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::PathBuf;

use host_sim::analysis::remarks as remarks_about;
use host_sim::experiment::Sample;
use host_sim::log::Log;
use host_sim::replay::{fitted, replay};
use host_sim::scan::Remark;
use host_sim::scenario::{Purpose, Scenario};
use host_sim::simulate;
use integration_tests::{Random, in_parallel, parse};

/// A servo with its loop, and the motion that is logged.
#[derive(Debug, Clone)]
struct Drawn {
    text: String,
    counts: f64,
    rate: f64,
    /// Time from which it is logged, s.
    begins: f64,
}

const RATES: [f64; 7] = [250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0, 20_000.0];
const COUNTS: [f64; 6] = [500.0, 2000.0, 4096.0, 10_000.0, 65_536.0, 0.0];

/// A healthy servo with effects, drawn.
fn drawn(number: usize, random: &mut Random) -> Drawn {
    let rate = RATES[number % RATES.len()];
    let counts = COUNTS[number % COUNTS.len()];
    let a = random.uniform(0.0, 10.0);
    let b = random.log_uniform(60.0, 2000.0);
    let scale = 257.7 / b;
    let mut share = |part: f64, below: f64| {
        if random.uniform(0.0, 1.0) < part {
            random.uniform(0.0, below)
        } else {
            0.0
        }
    };
    let (load, coulomb, gravity) = (share(0.5, 30.0), share(0.6, 25.0), share(0.3, 40.0));
    let (delay, noise) = (share(0.4, 2.5), share(0.4, 3.0));
    let step = if counts > 0.0 { TAU / counts } else { 1e-4 };
    // Small travel, and slow links, whose command holds their weight.
    let small = number % 5 == 4;
    let hangs = number % 11 == 7;
    let power = if small { 2e-5 } else { 0.005 };
    let excitation = match hangs {
        true => {
            "kind = \"multisine\"\namplitudes = [0.9, 0.3]\nfrequencies = [1.5, 4.0]".to_owned()
        }
        false => format!(
            "kind = \"band-limited-white-noise\"\npower = {power:?}\nsample_time = 0.1\nseed = {}",
            random.seed()
        ),
    };
    let gravity = if hangs { -0.3 * b } else { gravity };
    let duration = (20_000.0 / rate).clamp(4.0, 8.0);
    let text = format!(
        "[plant]\na = {a:?}\nb = {b:?}\nload = {load:?}\ncoulomb = {coulomb:?}\ndelay = {:?}\n\
         gravity = [{gravity:?}, {:?}]\n\
         [encoder]\ncounts_per_rev = {counts:?}\nnoise = {:?}\n\
         [amplifier]\nlimit = {:?}\n\
         [controller]\nkp = {:?}\nkd = {:?}\nki = {:?}\nsample_time = {:?}\n\
         [excitation]\n{excitation}\n\
         [run]\nduration = {duration:?}\n\
         [identifier]\nlaw = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n",
        delay / rate,
        0.5 * gravity,
        noise * step,
        10.0 * scale,
        9.0 * scale,
        0.19 * scale,
        4.0 * scale,
        1.0 / rate,
    );
    // Where the log of a hanging link begins, it moves already.
    let begins = if hangs { 1.0 } else { 0.0 };
    Drawn {
        text,
        counts,
        rate,
        begins,
    }
}

fn samples(drawn: &Drawn) -> Vec<Sample> {
    let mut samples = Vec::new();
    simulate::run(&parse(&drawn.text), &mut |sample| samples.push(*sample)).expect("it runs");
    samples
}

fn file(name: &str, text: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("scan-{}-{name}.csv", std::process::id()));
    std::fs::write(&path, text).expect("the log is written");
    path
}

/// Findings about a log that can be read.
#[derive(Debug)]
struct Scanned {
    remarks: Vec<Remark>,
    wrapped: bool,
    /// b, where nothing is refused.
    b: f64,
}

/// Reads and scans a log.
fn scanned(name: &str, log: &str, scenario: &str) -> Result<(Log, Scenario, Vec<Remark>), String> {
    let scenario =
        Scenario::parse("log", scenario, Purpose::Replay).map_err(|fault| fault.to_string())?;
    let path = file(name, log);
    let log = Log::read(&path, &scenario.log_columns(), scenario.log_sample_time());
    let log = log.map_err(|error| error.to_string())?;
    let scenario = fitted(scenario, &log);
    let remarks = remarks_about(&scenario, &log);
    Ok((log, scenario, remarks))
}

fn remarks(name: &str, log: &str, scenario: &str) -> Result<Scanned, String> {
    let (log, scenario, remarks) = scanned(name, log, scenario)?;
    let is_refused = remarks.iter().any(|remark| remark.refuses);
    let b = if is_refused {
        f64::NAN
    } else {
        identified(&log, &scenario)
    };
    std::fs::remove_file(log.path()).expect("it was there");
    Ok(Scanned {
        remarks,
        wrapped: log.found.wrapped.is_some(),
        b,
    })
}

#[test]
fn nothing_is_said_of_a_healthy_log() {
    let mut random = Random::new(24);
    let all: Vec<_> = (0..84)
        .map(|number| (number, drawn(number, &mut random)))
        .collect();
    let alarms = in_parallel(&all, |(number, drawn)| {
        let mut log = "t,r,q,u\n".to_owned();
        let all = samples(drawn);
        for sample in all.into_iter().filter(|sample| sample.time >= drawn.begins) {
            let Sample {
                time,
                reference,
                position,
                command,
                ..
            } = sample;
            writeln!(log, "{time},{reference},{position},{command}").expect("a string takes it");
        }
        let encoder = match number % 2 {
            0 => format!("[encoder]\ncounts_per_rev = {:?}\n", drawn.counts),
            _ => String::new(),
        };
        let scenario = format!(
            "{encoder}[identifier]\nlaw = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n\
             [log]\ntime = \"t\"\nreference = \"r\"\nposition = \"q\"\ncommand = \"u\"\n"
        );
        let found = scanned(&format!("healthy-{number}"), &log, &scenario);
        let found = found.map(|(log, _, remarks)| {
            std::fs::remove_file(log.path()).expect("it was there");
            remarks
        });
        match found {
            Ok(remarks) if remarks.is_empty() => None,
            other => Some(format!(
                "{number} {} Hz {}: {other:?}",
                drawn.rate, drawn.counts
            )),
        }
    });
    let alarms: Vec<_> = alarms.into_iter().flatten().collect();
    assert!(
        alarms.is_empty(),
        "{} of {}\n{}",
        alarms.len(),
        all.len(),
        alarms.join("\n")
    );
}

/// The consequence that a broken log must have.
#[derive(Debug, Clone, Copy)]
enum Consequence {
    /// A refusal with these words.
    Refused(&'static [&'static str]),
    /// Identification with a remark of these words.
    Noted(&'static str),
    /// A refusal, or identification with a remark, of these words.
    Said(&'static str),
    /// Identification of the true b.
    Mended,
}

use Consequence::{Mended, Noted, Refused, Said};

/// A way to break a log: its columns and rows, and the scenario without its identifier.
struct Broken {
    name: &'static str,
    columns: &'static str,
    /// Time, reference, position and command of a row, from its number, its sample and the one before.
    row: fn(usize, &Sample, &Sample) -> [f64; 4],
    rest: &'static str,
    consequence: Consequence,
}

const PLAIN: &str = "time = \"t\"\nreference = \"r\"\nposition = \"q\"\ncommand = \"u\"";
const NO_REFERENCE: &str = "time = \"t\"\nposition = \"q\"\ncommand = \"u\"";
const ENCODER: &str = "[encoder]\ncounts_per_rev = COUNTS";

/// The controller that ran, without an encoder: of the paper.
const CONTROLLER: &str = "[encoder]\ncounts_per_rev = 0\n[controller]\nsample_time = SAMPLE_TIME";

fn sound(s: &Sample) -> [f64; 4] {
    [s.time, s.reference, s.position, s.command]
}

/// Numbers from -1 to 1 in no order.
fn scrambled(k: usize) -> f64 {
    let mixed = (k as u64 ^ 0x5bd1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11;
    mixed as f64 / (1_u64 << 52) as f64 - 1.0
}

macro_rules! broken {
    ($($name:literal, $columns:expr, $rest:expr, $row:expr => $consequence:expr;)*) => {
        &[$(Broken {
            name: $name, columns: $columns, rest: $rest, row: $row, consequence: $consequence,
        }),*]
    };
}

/// Each on every servo of [`BASES`].
const BROKEN: &[Broken] = broken! {
    "command reversed", NO_REFERENCE, ENCODER, |_, s, _| [s.time, 0.0, s.position, -s.command]
        => Refused(&["log.command_scale = -1"]);
    "command reversed beside a reference", PLAIN, ENCODER, |_, s, _| [s.time, s.reference, s.position, -s.command]
        => Refused(&["log.command_scale = -1"]);
    "encoder reversed", PLAIN, ENCODER, |_, s, _| [s.time, s.reference, -s.position, s.command]
        => Refused(&["log.position_scale = -1"]);
    "reference reversed", PLAIN, ENCODER, |_, s, _| [s.time, -s.reference, s.position, s.command]
        => Refused(&["log.reference_scale = -1"]);
    "degrees as rad", NO_REFERENCE, ENCODER, |_, s, _| [s.time, 0.0, s.position.to_degrees(), s.command]
        => Refused(&["log.position_unit = \"deg\""]);
    "turns as rad", NO_REFERENCE, ENCODER, |_, s, _| [s.time, 0.0, s.position / TAU, s.command]
        => Refused(&["log.position_unit = \"turns\""]);
    "rad as degrees", "time = \"t\"\nposition = \"q\"\ncommand = \"u\"\nposition_unit = \"deg\"", ENCODER,
        |_, s, _| [s.time, 0.0, s.position, s.command] => Refused(&["log.position_unit = \"rad\""]);
    "degrees as rad, no encoder declared", NO_REFERENCE, "", |_, s, _| [s.time, 0.0, s.position.to_degrees(), s.command]
        => Refused(&["log.position_unit = \"deg\""]);
    "turns as rad, no encoder declared", NO_REFERENCE, "", |_, s, _| [s.time, 0.0, s.position / TAU, s.command]
        => Said("log.position_unit = \"turns\"");
    "counts as rad, no encoder declared", NO_REFERENCE, "",
        |_, s, _| [s.time, 0.0, (s.position / TAU * 1e4).round(), s.command]
        => Refused(&["log.position_unit = \"counts\"", "encoder.counts_per_rev"]);
    "degrees by the column's name", "time = \"t\"\nposition = \"q_deg\"\ncommand = \"u\"", "",
        |k, s, _| [s.time, 0.0, s.position.to_degrees() + 1e-4 * scrambled(k), s.command]
        => Refused(&["log.position_unit = \"deg\""]);
    "reference in degrees", PLAIN, ENCODER, |_, s, _| [s.time, s.reference.to_degrees(), s.position, s.command]
        => Refused(&["log.reference_unit"]);
    "position and reference in degrees beside the controller", PLAIN, CONTROLLER,
        |k, s, _| [s.time, s.reference.to_degrees(), s.position.to_degrees() + 1e-4 * scrambled(k), s.command]
        => Refused(&["[controller]", "log.position_unit"]);
    "position and reference exchanged", PLAIN, ENCODER, |_, s, _| [s.time, s.position, s.reference, s.command]
        => Refused(&["log.position"]);
    "position and command exchanged", NO_REFERENCE, "", |_, s, _| [s.time, 0.0, s.command, s.position]
        => Refused(&["log.position = \"u\" and log.command = \"q\""]);
    "command and reference exchanged", PLAIN, ENCODER, |_, s, _| [s.time, s.command, s.position, s.reference]
        => Refused(&["log.command"]);
    "reference as command", NO_REFERENCE, ENCODER, |_, s, _| [s.time, 0.0, s.position, s.reference]
        => Refused(&["log.command"]);
    "velocity as position", NO_REFERENCE, "",
        |_, s, before| [s.time, 0.0, (s.position - before.position) / (s.time - before.time).max(1e-9), s.command]
        => Refused(&["log.position"]);
    "time as position", NO_REFERENCE, "", |_, s, _| [s.time, 0.0, s.time, s.command] => Refused(&["log.position"]);
    "counter as command", NO_REFERENCE, ENCODER, |k, s, _| [s.time, 0.0, s.position, k as f64] => Refused(&["log.command"]);
    "command of zero", NO_REFERENCE, ENCODER, |_, s, _| [s.time, 0.0, s.position, 0.0] => Refused(&["log.command"]);
    "command of another axis", NO_REFERENCE, ENCODER, |k, s, _| [s.time, 0.0, s.position, scrambled(k / 50)]
        => Refused(&["log.command"]);
    "encoder with four times the counts declared", NO_REFERENCE, "[encoder]\ncounts_per_rev = FOURFOLD",
        |_, s, _| [s.time, 0.0, s.position, s.command] => Refused(&["encoder.counts_per_rev = COUNTS"]);
    "encoder with a quarter of the counts declared", NO_REFERENCE, "[encoder]\ncounts_per_rev = QUARTER",
        |_, s, _| [s.time, 0.0, s.position, s.command] => Refused(&["encoder.counts_per_rev = COUNTS"]);
    "another encoder declared", NO_REFERENCE, "[encoder]\ncounts_per_rev = 7200",
        |_, s, _| [s.time, 0.0, s.position, s.command] => Refused(&["encoder.counts_per_rev = COUNTS"]);
    "two decimals", NO_REFERENCE, ENCODER, |_, s, _| [s.time, 0.0, (s.position * 100.0).round() / 100.0, s.command]
        => Noted("encoder.counts_per_rev");
    "ms as s", NO_REFERENCE, ENCODER, |_, s, _| [1e3 * s.time, 0.0, s.position, s.command]
        => Refused(&["log.time_unit = \"ms\""]);
    "us as s", NO_REFERENCE, ENCODER, |_, s, _| [1e6 * s.time, 0.0, s.position, s.command]
        => Refused(&["log.time_unit = \"us\""]);
    "s as ms", "time = \"t\"\ntime_unit = \"ms\"\nposition = \"q\"\ncommand = \"u\"", ENCODER,
        |_, s, _| [s.time, 0.0, s.position, s.command] => Refused(&["log.time_unit = \"s\""]);
    "half the rate stated", "time = \"t\"\nposition = \"q\"\ncommand = \"u\"\nsample_time = 0.01", ENCODER,
        |_, s, _| [s.time, 0.0, s.position, s.command] => Refused(&["log.sample_time"]);
    "0 to 360 degrees", "time = \"t\"\nreference = \"r\"\nposition = \"q\"\ncommand = \"u\"\nposition_unit = \"deg\"",
        ENCODER,
        |_, s, _| [s.time, s.reference.to_degrees().rem_euclid(360.0), s.position.to_degrees().rem_euclid(360.0), s.command]
        => Mended;
    "-180 to 180 degrees", "time = \"t\"\nposition = \"q\"\ncommand = \"u\"\nposition_unit = \"deg\"", ENCODER,
        |_, s, _| [s.time, 0.0, s.position.to_degrees().rem_euclid(360.0) - 180.0, s.command] => Mended;
    "0 to two pi", NO_REFERENCE, ENCODER, |_, s, _| [s.time, 0.0, s.position.rem_euclid(TAU), s.command] => Mended;
    "0 to 360 degrees as rad", NO_REFERENCE, ENCODER,
        |_, s, _| [s.time, 0.0, s.position.to_degrees().rem_euclid(360.0), s.command]
        => Refused(&["log.position_unit = \"deg\""]);
    "0 to 5 rad", NO_REFERENCE, "", |_, s, _| [s.time, 0.0, s.position.rem_euclid(5.0), s.command] => Refused(&["log.wrap"]);
    "noise alone", NO_REFERENCE, ENCODER, |k, s, _| [s.time, 0.0, (2.0 * scrambled(k)).round() * 1e-3, s.command]
        => Refused(&["noise"]);
    "one direction", NO_REFERENCE, "", |_, s, _| [s.time, 0.0, s.position + 100.0 * s.time, s.command]
        => Refused(&["one direction", "coulomb"]);
    "clock that jumps back", NO_REFERENCE, ENCODER,
        |k, s, _| [if k < 500 { s.time } else { s.time - 0.3 }, 0.0, s.position, s.command] => Refused(&["log.cut"]);
    "clock that jumps ahead", NO_REFERENCE, ENCODER,
        |k, s, _| [if k < 500 { s.time } else { s.time + 3600.0 }, 0.0, s.position, s.command]
        => Refused(&["log.bridge_gaps", "log.cut"]);
    "no number in a cell", NO_REFERENCE, ENCODER,
        |k, s, _| [s.time, 0.0, s.position, if k == 700 { f64::NAN } else { s.command }] => Refused(&["log.cut"]);
    "infinite position", NO_REFERENCE, ENCODER,
        |k, s, _| [s.time, 0.0, if k == 700 { f64::INFINITY } else { s.position }, s.command] => Refused(&["log.cut"]);
    "position that stays", NO_REFERENCE, ENCODER, |_, s, _| [s.time, 0.0, 1.0, s.command] => Refused(&["log.position"]);
    "one column twice", "time = \"t\"\nposition = \"q\"\ncommand = \"q\"", ENCODER, |_, s, _| sound(s)
        => Refused(&["log.command", "log.position"]);
};

/// Servos: rate, counts, and the rest of the plant.
const BASES: [(f64, f64, &str); 3] = [
    (1000.0, 10_000.0, "load = 20.0\ncoulomb = 10.0"),
    (4000.0, 4096.0, "coulomb = 4.0\ndelay = 3e-4"),
    (500.0, 2000.0, "load = -8.0"),
];

const GAIN: f64 = 257.7;

fn base([rate, counts]: [f64; 2], plant: &str) -> Vec<Sample> {
    let text = format!(
        "[plant]\na = 0.5\nb = {GAIN:?}\n{plant}\n[encoder]\ncounts_per_rev = {counts:?}\n[amplifier]\nlimit = 10.0\n\
         [controller]\nsample_time = {:?}\n[run]\nduration = 8.0\n\
         [identifier]\nlaw = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n",
        1.0 / rate
    );
    let mut samples = Vec::new();
    simulate::run(&parse(&text), &mut |sample| samples.push(*sample)).expect("it runs");
    samples
}

/// b as it is identified.
fn identified(log: &Log, scenario: &Scenario) -> f64 {
    let replayed = replay(scenario, log, 1, &mut |_, _| {}).expect("it can be replayed");
    replayed.estimates.b
}

#[test]
fn every_broken_log_is_named_or_mended() {
    let logs: Vec<_> = (BASES.iter())
        .map(|(rate, counts, plant)| (*counts, base([*rate, *counts], plant)))
        .collect();
    let cases: Vec<_> = logs
        .iter()
        .flat_map(|log| BROKEN.iter().map(move |broken| (log, broken)))
        .collect();
    let outcomes = in_parallel(&cases, |((counts, samples), broken)| {
        let position = if broken.columns.contains("\"q_deg\"") {
            "q_deg"
        } else {
            "q"
        };
        let mut text = format!("t,r,{position},u\n");
        for (k, sample) in samples.iter().enumerate() {
            let [t, r, q, u] = (broken.row)(k, sample, &samples[k.saturating_sub(1)]);
            writeln!(text, "{t},{r},{q},{u}").expect("a string takes it");
        }
        let with_counts = |text: &str| {
            text.replace("COUNTS", &counts.to_string())
                .replace("FOURFOLD", &(4.0 * counts).to_string())
                .replace("QUARTER", &(0.25 * counts).to_string())
                .replace(
                    "SAMPLE_TIME",
                    &(samples[1].time - samples[0].time).to_string(),
                )
        };
        let scenario = format!(
            "{}\n[identifier]\nlaw = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n[log]\n{}\n",
            with_counts(broken.rest),
            broken.columns
        );
        let name = format!("{}-{counts}", broken.name.replace(' ', "-"));
        let found = remarks(&name, &text, &scenario);
        let is_right = match (broken.consequence, &found) {
            (Refused(words), Err(message)) => words
                .iter()
                .all(|word| message.contains(&with_counts(word))),
            (Refused(words), Ok(Scanned { remarks, .. })) => {
                let mut refusals = remarks.iter().filter(|remark| remark.refuses);
                refusals.any(|remark| {
                    words
                        .iter()
                        .all(|word| remark.text.contains(&with_counts(word)))
                })
            }
            (Said(word), Ok(Scanned { remarks, .. })) => {
                remarks.iter().any(|remark| remark.text.contains(word))
            }
            (Noted(word), Ok(Scanned { remarks, .. })) => {
                let [remark] = &remarks[..] else {
                    return Some(format!("{name}: {found:?}"));
                };
                !remark.refuses && remark.text.contains(word)
            }
            (
                Mended,
                Ok(Scanned {
                    remarks,
                    wrapped,
                    b,
                }),
            ) => remarks.is_empty() && *wrapped && (b / GAIN - 1.0).abs() < 0.02,
            _ => false,
        };
        (!is_right).then(|| format!("{name}: {found:?}"))
    });
    let wrong: Vec<_> = outcomes.into_iter().flatten().collect();
    assert!(cases.len() >= 40);
    assert!(
        wrong.is_empty(),
        "{} of {}\n{}",
        wrong.len(),
        cases.len(),
        wrong.join("\n")
    );
}
