//! One difficulty at a time: noise, a shifted record, one effect.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use integration_tests::environment;
use integration_tests::logs::{Effect, drawn_with, exact};

use super::campaign;
use super::identify::{FIT, FOUR, Settings};
use super::judge::{Judgement, judge};
use super::table::count;

const RATES: [f64; 4] = [250.0, 1000.0, 4000.0, 20_000.0];
/// The counts that an exact servo covers, so that ten counts of noise leave it visible.
const COUNTS: f64 = 2000.0;
/// Logs of each kind, unless a number is stated.
const LOGS: u32 = 6;

/// Magnitudes in order; infinite where one is unknown.
fn sorted(judged: &[&Judgement], of: impl Fn(&Judgement) -> Option<f64>) -> Vec<f64> {
    let all = judged.iter().map(|j| of(j).map_or(f64::INFINITY, f64::abs));
    let mut all: Vec<f64> = all.collect();
    all.sort_by(f64::total_cmp);
    all
}

/// The largest magnitude.
fn worst(judged: &[&Judgement], of: impl Fn(&Judgement) -> Option<f64>) -> f64 {
    sorted(judged, of).last().copied().unwrap_or(f64::NAN)
}

/// The median magnitude.
fn median(judged: &[&Judgement], of: impl Fn(&Judgement) -> Option<f64>) -> f64 {
    let sorted = sorted(judged, of);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The number of results that are converged, and right or wrong.
fn converged(judged: &[&Judgement], right: bool) -> usize {
    count(judged, |j| j.is_converged && j.is_right() == right)
}

/// The share of all errors within so many standard errors, per cent.
fn covered(judged: &[&Judgement], limit: f64) -> f64 {
    let errors = judged.iter().flat_map(|j| &j.deviations);
    let inside = errors.clone().filter(|error| **error <= limit).count();
    100.0 * inside as f64 / errors.count().max(1) as f64
}

/// Judgements by the kind of their logs.
fn by_kind<'a, K: Ord + Copy>(
    items: &[(K, u32)],
    judged: &'a [Judgement],
) -> BTreeMap<K, Vec<&'a Judgement>> {
    let mut kinds = BTreeMap::<K, Vec<&Judgement>>::new();
    for ((kind, _), judgement) in items.iter().zip(judged) {
        kinds.entry(*kind).or_default().push(judgement);
    }
    kinds
}

#[test]
#[ignore = "minutes: LOGS=6 SEED=n"]
fn with_noise_of_the_encoder_by_one_fit() {
    with_noise_of_the_encoder(&[FIT]);
}

#[test]
#[ignore = "minutes: LOGS=6 SEED=n"]
fn with_noise_of_the_encoder_by_recursion() {
    with_noise_of_the_encoder(&[FOUR]);
}

fn with_noise_of_the_encoder(settings: &[Settings]) {
    /// Tenths of a count.
    const NOISE: [u32; 8] = [0, 5, 10, 15, 20, 30, 50, 100];
    let (seed, logs) = campaign(LOGS);
    let mut items = Vec::new();
    for place in 0..RATES.len() {
        for tenths in NOISE {
            items.extend((0..logs).map(|number| ((place, tenths), number)));
        }
    }
    let judged = judge(settings, &items, |&((place, tenths), number)| {
        let mut setup = exact(seed, number, RATES[place], COUNTS).setup;
        setup.sensor.noise = 0.1 * f64::from(tenths) * TAU / setup.counts_per_rev;
        setup.record()
    });
    for (settings, judged) in settings.iter().zip(&judged) {
        println!("{}", settings.name);
        println!(
            "exact servos with noise: median and largest errors; errors within 2 and 3 standard errors, %; started; \
             converged and right, and wrong\n   \
             Hz counts | b %: median largest | c %: median largest | noise %: median largest | 2 σ 3 σ | started | \
             right wrong of"
        );
        if environment::<u8>("DETAIL").is_some() {
            for (((place, tenths), number), judged) in items.iter().zip(judged) {
                println!(
                    "{} Hz, {tenths} tenths, log {number}: b off {:.3} %, wrong {:.2}; {}",
                    RATES[*place],
                    100.0 * judged.off_b.unwrap_or(f64::NAN),
                    judged.wrongness.unwrap_or(f64::NAN),
                    judged.reason
                );
            }
        }
        for ((place, tenths), judged) in by_kind(&items, judged) {
            println!(
                "{:5} {:6.1} | {:11.3} {:7.3} | {:11.1} {:7.1} | {:15.1} {:7.1} | {:3.0} {:3.0} | {:7} | {:5} {:5} {:2}",
                RATES[place],
                0.1 * f64::from(tenths),
                100.0 * median(&judged, |j| j.off_b),
                100.0 * worst(&judged, |j| j.off_b),
                100.0 * median(&judged, |j| j.off_coulomb),
                100.0 * worst(&judged, |j| j.off_coulomb),
                100.0 * median(&judged, |j| j.off_noise),
                100.0 * worst(&judged, |j| j.off_noise),
                covered(&judged, 2.0),
                covered(&judged, 3.0),
                count(&judged, |j| !j.deviations.is_empty()),
                converged(&judged, true),
                converged(&judged, false),
                judged.len()
            );
        }
    }
}

/// A log of so many rows is fitted in blocks: the delay is reported in rows all the same.
#[test]
fn a_late_command_of_a_long_log_is_known_in_rows() {
    const ROWS: usize = 1 << 15;
    let judged = judge(&[FIT], &[0, 1], |&number| {
        let mut setup = exact(7, number, 20_000.0, COUNTS).setup;
        assert!(setup.samples > ROWS, "{} rows", setup.samples);
        setup.shift = -2.0;
        setup.present.push(Effect::Shift);
        setup.record()
    });
    for judgement in &judged[0] {
        let off = judgement.off_shift.expect("the delay is known");
        assert!(off.abs() < 0.05, "{off} rows");
    }
}

#[test]
#[ignore = "minutes: LOGS=6 SEED=n"]
fn with_a_record_that_is_late_or_early() {
    let (seed, logs) = campaign(LOGS);
    let halves: Vec<i32> = (-4..=6).collect();
    let mut items = Vec::new();
    for half in halves {
        for place in 0..RATES.len() as u32 {
            items.extend((0..logs).map(|number| (half, number * RATES.len() as u32 + place)));
        }
    }
    let settings = [FIT, FOUR];
    let judged = judge(&settings, &items, |&(half, number)| {
        let (place, number) = (number as usize % RATES.len(), number / RATES.len() as u32);
        let mut setup = exact(seed, number, RATES[place], COUNTS).setup;
        setup.shift = 0.5 * f64::from(half);
        setup.present.push(Effect::Shift);
        setup.record()
    });
    for (settings, judged) in settings.iter().zip(&judged) {
        println!("{}", settings.name);
        println!("exact servos, the command recorded late (below zero) or early: largest errors");
        println!(
            "samples | shift: known median largest | b %: median largest | c %: median largest | right wrong of"
        );
        for (half, judged) in by_kind(&items, judged) {
            let known: Vec<&Judgement> = judged
                .iter()
                .copied()
                .filter(|j| j.off_shift.is_some())
                .collect();
            println!(
                "{:7.1} | {:12} {:6.3} {:7.3} | {:11.3} {:7.2} | {:11.1} {:7.1} | {:5} {:5} {:2}",
                0.5 * f64::from(half),
                known.len(),
                median(&known, |j| j.off_shift),
                worst(&known, |j| j.off_shift),
                100.0 * median(&judged, |j| j.off_b),
                100.0 * worst(&judged, |j| j.off_b),
                100.0 * median(&judged, |j| j.off_coulomb),
                100.0 * worst(&judged, |j| j.off_coulomb),
                converged(&judged, true),
                converged(&judged, false),
                judged.len()
            );
        }
    }
}

/// Names of single effects, and of none. Effects are drawn down to sizes that no log shows, so that names are counted
/// where the effect matters, too: where the result is not both converged and right.
#[test]
#[ignore = "minutes: LOGS=20 SEED=n"]
fn with_one_effect_by_one_fit() {
    with_one_effect(&[FIT]);
}

#[test]
#[ignore = "minutes: LOGS=20 SEED=n"]
fn with_one_effect_by_recursion() {
    with_one_effect(&[FOUR]);
}

fn with_one_effect(settings: &[Settings]) {
    let (seed, logs) = campaign(20);
    let mut items: Vec<(Option<Effect>, u32)> =
        (0..5 * logs).map(|number| (None, number)).collect();
    for effect in Effect::ALL {
        items.extend((0..logs).map(|number| (Some(effect), number)));
    }
    let judged = judge(settings, &items, |&(effect, number)| {
        drawn_with(seed, number, effect.as_slice())
    });
    for (settings, judged) in settings.iter().zip(&judged) {
        println!(
            "{}\neffect                   | named: right wrong not | converged: right wrong | \
             refused: right wrong | b %: median 90 % | names",
            settings.name
        );
        let kinds = by_kind(&items, judged);
        for (effect, judged) in &kinds {
            let off_b = sorted(judged, |j| j.off_b);
            println!(
                "{:24} | {:12} {:5} {:3} | {:16} {:5} | {:14} {:5} | {:11.3} {:4.1} | {}",
                effect.map_or("none", Effect::name),
                named(judged, true),
                named(judged, false),
                count(judged, |j| j.names.is_empty()),
                converged(judged, true),
                converged(judged, false),
                count(judged, |j| !j.is_converged && j.is_right()),
                count(judged, |j| !j.is_converged && !j.is_right()),
                100.0 * off_b[off_b.len() / 2],
                100.0 * off_b[off_b.len() * 9 / 10],
                names(judged)
            );
        }
        let with_one = kinds.iter().filter(|(effect, _)| effect.is_some());
        let all: Vec<&Judgement> = with_one.flat_map(|(_, judged)| judged.clone()).collect();
        let is_harmless = |j: &&Judgement| j.is_converged && j.is_right();
        let harmful = all.iter().copied().filter(|j| !is_harmless(j)).collect();
        for (which, judged) in [("all", all), ("harmful ones", harmful)] {
            let share = |right| 100.0 * named(&judged, right) as f64 / judged.len() as f64;
            println!(
                "{which}: named right {:.1} %, wrong {:.1} % of {}",
                share(true),
                share(false),
                judged.len()
            );
        }
    }
}

/// The number of results that name effects which the log has and no others, or an effect which it has not.
fn named(judged: &[&Judgement], right: bool) -> usize {
    count(judged, |j| {
        !j.names.is_empty() && j.names.iter().all(|(_, is_right)| *is_right) == right
    })
}

/// The names that are given, each with its number.
fn names(judged: &[&Judgement]) -> String {
    let mut names = BTreeMap::<&str, u32>::new();
    for (name, _) in judged.iter().flat_map(|j| &j.names) {
        *names.entry(*name).or_default() += 1;
    }
    let all = names
        .iter()
        .map(|(name, number)| format!("{name} {number}"));
    all.collect::<Vec<_>>().join(", ")
}
