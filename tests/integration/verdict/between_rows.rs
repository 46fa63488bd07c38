//! Logs that are slower than their loop: what acted between two rows is not in them.
//!
//! ```sh
//! LOGS=200 SEED=7 cargo test -p integration-tests --test integration verdict::between_rows:: -- --ignored --nocapture
//! ```

use std::fmt::Write as _;

use integration_tests::Random;
use integration_tests::logs::{RecordedLog, exact};
use virtual_servo::distinct_seed;

use super::stranger::{End, assert_right, campaign, judged};

/// How the command of a row came to be.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Row {
    /// As the loop had it at this time.
    Sampled,
    /// The mean since the row before.
    Averaged,
}

/// Identifies every so-manieth row of the log of a number.
fn of_log(seed: u32, number: u32) -> (End, String) {
    const COUNTS: f64 = 100.0;
    let mut random = Random::new(distinct_seed(seed ^ 0x00b5, number));
    let each = random.log_uniform(1.0, 21.0) as usize;
    let row = [Row::Sampled, Row::Averaged][usize::from(random.chance(0.4))];
    let log = exact(seed, number, random.log_uniform(500.0, 4000.0), COUNTS);
    let (end, words) = judged(text(&log, each, row), log.setup.servo.b);
    let setup = &log.setup;
    let described = format!(
        "{row:?} each {each}, bandwidth times row {:.2}, {:?}, {:?}, {} samples of {:.2} ms",
        setup.bandwidth * setup.sample_time * each as f64,
        setup.controller,
        setup.reference,
        setup.samples,
        1e3 * setup.sample_time,
    );
    (end, format!("{words}; {described}"))
}

fn text(log: &RecordedLog, each: usize, row: Row) -> String {
    let mut text = "time_s,position_rad,command\n".to_owned();
    for sample in (each..log.commands.len()).step_by(each) {
        let command = match row {
            Row::Sampled => log.commands[sample],
            // A row whose loop ran once since has what acts from there on.
            Row::Averaged if each == 1 => log.commands[sample],
            Row::Averaged => log.commands[sample - each..sample].iter().sum::<f64>() / each as f64,
        };
        let time = sample as f64 * log.setup.sample_time;
        let position = log.position(sample);
        writeln!(text, "{time},{position},{command}").expect("a String takes all");
    }
    text
}

#[test]
fn a_few_logs_slower_than_their_loops_are_right_or_open() {
    assert_right([35599, 12, 10], of_log);
}

#[test]
#[ignore = "campaign: minutes, LOGS=200 SEED=n"]
fn a_log_slower_than_its_loop_is_right_or_open() {
    campaign(60, of_log);
}
