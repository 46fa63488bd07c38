//! Servos that a force of the position drives as much as their command does: sign and b are right, or open.
//!
//! ```sh
//! LOGS=120 SEED=7 cargo test -p integration-tests --test integration verdict::gravity:: -- --ignored --nocapture
//! ```

use std::fmt::Write as _;

use integration_tests::logs::{Controller, RecordedLog, under_gravity};

use super::stranger::{End, assert_right, campaign, judged};

/// Identifies the log of a number: its command has either sign, its positions are radians or counts.
fn of_log(seed: u32, number: u32) -> (End, String) {
    let log = under_gravity(seed, number);
    let (is_turned, is_in_counts) = (number % 2 == 1, number % 4 > 1);
    let setup = &log.setup;
    let unit = match is_in_counts {
        true => setup.counts_per_rev / std::f64::consts::TAU,
        false => 1.0,
    };
    let (end, words) = judged(text(&log, is_turned, is_in_counts), setup.servo.b * unit);
    let [sine, cosine] = setup.effects.gravity;
    let is_open = setup.controller == Controller::Open;
    let described = format!(
        "{}, {}, own {:.1} rad/s, {:?}, {} rows of {:.2} ms, range {:.1} rad",
        if is_open { "open" } else { "in a loop" },
        if is_in_counts { "counts" } else { "rad" },
        sine.hypot(cosine).sqrt(),
        setup.reference,
        setup.samples,
        1e3 * setup.sample_time,
        log.range,
    );
    (end, format!("{words}; {described}"))
}

fn text(log: &RecordedLog, is_turned: bool, is_in_counts: bool) -> String {
    let unit = if is_in_counts { "" } else { "_rad" };
    let mut text = format!("time_s,position{unit},command\n");
    let sign = if is_turned { -1.0 } else { 1.0 };
    for (sample, command) in log.commands.iter().enumerate() {
        let time = sample as f64 * log.setup.sample_time;
        let position = match is_in_counts {
            true => log.counts[sample] as f64,
            false => log.position(sample),
        };
        writeln!(text, "{time},{position},{}", sign * command).expect("a String takes all");
    }
    text
}

#[test]
fn a_few_servos_under_gravity_are_right_or_open() {
    assert_right([2027, 12, 10], of_log);
}

#[test]
#[ignore = "campaign: minutes, LOGS=120 SEED=n"]
fn a_servo_under_gravity_is_right_or_open() {
    campaign(40, of_log);
}
