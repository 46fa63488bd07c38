//! Campaigns over [drawn logs](integration_tests::logs), which are identified as a user would.
//!
//! ```sh
//! LOGS=1000 SEED=7 cargo test -p integration-tests --test integration verdict::logs:: -- --ignored --nocapture
//! ```
//!
//! `DETAIL=1` prints a line per log.

pub(super) mod identify;
mod judge;
mod ridge;
mod table;
mod truth;

use integration_tests::environment;
use integration_tests::logs::{Effect, drawn, exact};

use identify::{FIT, FOUR, Settings};
use judge::{Judgement, judge};
use table::{count, table};

/// The seed of a campaign on demand, and the number of its logs or of those of each kind: `SEED=7 LOGS=1000`.
fn campaign(usual: u32) -> (u32, u32) {
    (
        environment("SEED").unwrap_or(1),
        environment("LOGS").unwrap_or(usual),
    )
}

/// Judges the logs of a campaign and prints the table; with `DETAIL`, and of what is wrong in any case, a line per log.
fn run(settings: &[Settings], seed: u32, numbers: &[u32]) -> Vec<Vec<Judgement>> {
    let judged = judge(settings, numbers, |&number| drawn(seed, number));
    let all = environment::<u8>("DETAIL").is_some();
    for (settings, judged) in settings.iter().zip(&judged) {
        for (number, judgement) in numbers.iter().zip(judged) {
            if all || (judgement.is_converged && !judgement.is_right()) {
                let effects = judgement.present.iter().map(|effect| effect.name());
                println!(
                    "{}, log {number} of seed {seed} with [{}]: wrong {:.2}, b off {:.3} %, {:.1} s; {}",
                    settings.name,
                    effects.collect::<Vec<_>>().join(", "),
                    judgement.wrongness.unwrap_or(f64::NAN),
                    100.0 * judgement.off_b.unwrap_or(f64::NAN),
                    judgement.seconds,
                    judgement.reason
                );
            }
        }
    }
    println!("{}", table(settings, &judged));
    judged
}

#[test]
#[ignore = "minutes: LOGS=1000 SEED=n"]
fn with_drawn_effects_by_one_fit() {
    let (seed, count) = campaign(300);
    run(&[FIT], seed, &Vec::from_iter(0..count));
}

#[test]
#[ignore = "minutes: LOGS=1000 SEED=n"]
fn with_drawn_effects_by_recursion() {
    let (seed, count) = campaign(300);
    run(&[FOUR], seed, &Vec::from_iter(0..count));
}

/// Asserts that of these logs of a seed as many are right as ever.
fn assert_as_many_are_right(numbers: &[u32], least_right: usize, most_wrong: usize) {
    let [judged] = &run(&[FIT], 2, numbers)[..] else {
        panic!("one list for one setting")
    };
    let judged: Vec<&Judgement> = judged.iter().collect();
    let right = count(&judged, |j| j.is_converged && j.is_right());
    let wrong = count(&judged, |j| j.is_converged && !j.is_right());
    assert!(right >= least_right, "{right} are converged and right");
    assert!(wrong <= most_wrong, "{wrong} are converged and wrong");
    let exact_and_wrong = |j: &Judgement| j.present.is_empty() && j.is_converged && !j.is_right();
    assert_eq!(count(&judged, exact_and_wrong), 0);
}

/// Those of forty that are short: it may not become worse than it was.
#[test]
fn of_a_few_drawn_logs_as_many_are_right_as_ever() {
    const SHORT: [u32; 11] = [8, 9, 13, 15, 25, 30, 31, 33, 34, 36, 39];
    assert_as_many_are_right(&SHORT, 5, 0);
}

#[test]
#[ignore = "campaign: a minute and a half, cargo test --test integration of_forty_drawn_logs -- --ignored"]
fn of_forty_drawn_logs_as_many_are_right_as_ever() {
    assert_as_many_are_right(&Vec::from_iter(0..40), 26, 1);
}

/// Servos that stick most of the time, or follow slowly: a regression without friction sees no effect of the command in two
/// of them, and a velocity in the third.
#[test]
fn a_log_that_the_fit_knows_is_not_refused() {
    // The last needs a ripple, which is no loop that follows its goal.
    let mut converged = 0;
    for (seed, numbers) in [(31_415, &[8, 118, 125][..]), (14_352_099, &[216])] {
        let judged = judge(&[FIT], numbers, |&number| drawn(seed, number));
        for judgement in &judged[0] {
            assert!(judgement.is_right(), "{}", judgement.reason);
            converged += usize::from(judgement.is_converged);
        }
    }
    // The load of one walks or does not: that is open.
    assert!(converged >= 3, "{converged} are converged");
}

/// A log of so many rows is fitted in blocks: the delay is reported in rows all the same.
#[test]
fn a_late_command_of_a_long_log_is_known_in_rows() {
    const ROWS: usize = 1 << 15;
    const COUNTS: f64 = 2000.0;
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
