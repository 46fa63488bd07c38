//! Servos whose motor cogs: the orders of its waves are right, or not named.
//!
//! ```sh
//! LOGS=60 SEED=7 cargo test -p integration-tests --test integration verdict::cogging:: -- --ignored --nocapture
//! ```

use std::fmt::Write as _;

use identifier_log::result::Summary;
use integration_tests::logs::{RecordedLog, with_cogging};
use integration_tests::{environment, in_parallel};

use super::stranger::as_a_stranger;

/// A wave: its sine and cosine, rad/s², and its order.
type Wave = ([f64; 2], u32);

/// What a log says of its waves: those that it has, those named rightly and wrongly, and the part of their force that is left.
#[derive(Default)]
struct Found {
    waves: usize,
    right: usize,
    wrong: usize,
    left: f64,
    words: String,
}

fn of_log(seed: u32, number: u32) -> Found {
    let log = with_cogging(seed, number);
    let effects = &log.setup.effects;
    let first = (effects.ripple, effects.ripple_order);
    let all = std::iter::once(first).chain(effects.ripples);
    let truth: Vec<Wave> = all.filter(|(_, order)| *order > 0).collect();
    let found = as_a_stranger(text(&log));
    let named = found.as_ref().map_or(Vec::new(), |(found, _)| named(found));
    let has = |of: &[Wave], order| of.iter().any(|(_, other)| *other == order);
    let right = named.iter().filter(|(_, order)| has(&truth, *order));
    let right = right.count();
    let power = |wave: [f64; 2]| wave[0] * wave[0] + wave[1] * wave[1];
    let size = |of: &[Wave], order| {
        let wave = of.iter().find(|(_, other)| *other == order);
        wave.map_or([0.0; 2], |(wave, _)| *wave)
    };
    let beside = named.iter().filter(|(_, order)| !has(&truth, *order));
    let left = truth.iter().chain(beside).map(|(_, order)| {
        let [found, true_size] = [size(&named, *order), size(&truth, *order)];
        power([found[0] - true_size[0], found[1] - true_size[1]])
    });
    let left: f64 = left.sum();
    let whole: f64 = truth.iter().map(|(wave, _)| power(*wave)).sum();
    let orders = |of: &[Wave]| of.iter().map(|(_, order)| *order).collect::<Vec<_>>();
    Found {
        waves: truth.len(),
        right,
        wrong: named.len() - right,
        left: (left / whole).sqrt(),
        words: format!(
            "{:?} named {:?}, {:.3} left; {} counts, {} rows of {:.2} ms, {:.0} rad; {}",
            orders(&truth),
            orders(&named),
            (left / whole).sqrt(),
            log.setup.counts_per_rev,
            log.setup.samples,
            1e3 * log.setup.sample_time,
            log.range,
            found.map_or_else(|asked| asked, |(found, _)| found.reason),
        ),
    }
}

/// The waves of a result.
fn named(found: &Summary) -> Vec<Wave> {
    let effects = found.fit.iter().flat_map(|fit| &fit.effects);
    let ripple = effects.filter(|effect| effect.name == "ripple" && effect.or.is_none());
    let waves = ripple.flat_map(|effect| {
        let term = |name: &str| {
            let terms = &found.estimates.terms;
            let own = terms.iter().find(|term| term.unknown.name() == name);
            own.map(|term| term.value)
        };
        let size = |name: &str| {
            let own = effect.sizes.iter().find(|(one, _)| *one == name);
            own.map(|(_, size)| *size).or_else(|| term(name))
        };
        let names = [
            ["ripple-sine", "ripple-cosine", "order"],
            ["sine_2", "cosine_2", "order_2"],
            ["sine_3", "cosine_3", "order_3"],
            ["sine_4", "cosine_4", "order_4"],
        ];
        names.map(|names| {
            let [sine, cosine, order] = names.map(size);
            Some(([sine?, cosine?], order? as u32))
        })
    });
    waves.flatten().collect()
}

fn text(log: &RecordedLog) -> String {
    let mut text = "time_s,position_rad,command\n".to_owned();
    for (sample, command) in log.commands.iter().enumerate() {
        let time = sample as f64 * log.setup.sample_time;
        let position = log.position(sample);
        writeln!(text, "{time},{position},{command}").expect("a String takes all");
    }
    text
}

/// What some logs of a seed say, printed, and summed.
fn judged(seed: u32, logs: u32) -> Found {
    let numbers: Vec<u32> = (0..logs).collect();
    let all = in_parallel(&numbers, |&number| of_log(seed, number));
    let mut sum = Found::default();
    for (number, found) in all.iter().enumerate() {
        println!("{number}: {}", found.words);
        sum.waves += found.waves;
        sum.right += found.right;
        sum.wrong += found.wrong;
    }
    let mut left: Vec<f64> = all.iter().map(|found| found.left).collect();
    left.sort_by(f64::total_cmp);
    println!(
        "{logs} logs of seed {seed}: {} waves, {} right, {} wrong; left of their force: median {:.3}, nine tenths {:.3}",
        sum.waves,
        sum.right,
        sum.wrong,
        left[left.len() / 2],
        left[9 * left.len() / 10],
    );
    sum
}

#[test]
fn a_few_motors_that_cog_have_their_orders() {
    let found = judged(3, 4);
    assert_eq!(found.wrong, 0);
    assert!(10 * found.right >= 9 * found.waves);
}

#[test]
#[ignore = "campaign: minutes, LOGS=60 SEED=n"]
fn the_orders_of_cogging_are_right_or_not_named() {
    let [seed, logs] =
        [("SEED", 1), ("LOGS", 60)].map(|(of, usual)| environment(of).unwrap_or(usual));
    judged(seed, logs);
}
