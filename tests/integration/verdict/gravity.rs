//! Servos that a force of the position drives as much as their command does: sign and b are right, or open.
//!
//! ```sh
//! LOGS=120 SEED=7 cargo test -p integration-tests --test integration verdict::gravity:: -- --ignored --nocapture
//! ```

use std::fmt::Write as _;

use identifier_log::verdict::{Status, VerdictReason};
use integration_tests::logs::{Controller, RecordedLog, under_gravity};
use integration_tests::{environment, in_parallel};

use super::readings::as_a_stranger;

/// What became of a log.
#[derive(Debug, Clone, PartialEq)]
struct Judged {
    /// The log, in words.
    of: String,
    end: End,
    reason: String,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    /// b within its interval, whose half width is a part of it.
    Right(f64),
    /// b outside of it.
    Wrong { is_converged: bool },
    /// No b.
    Open,
    /// The log is said to be at odds with itself.
    Refused,
}

/// Identifies the log of a number as a stranger does: its command has either sign, its positions are radians or counts.
fn judged(seed: u32, number: u32) -> Judged {
    let log = under_gravity(seed, number);
    let (is_turned, is_in_counts) = (number % 2 == 1, number % 4 > 1);
    let (of, end, reason) = match as_a_stranger(text(&log, is_turned, is_in_counts)) {
        Err(asked) => (String::new(), End::Refused, asked),
        Ok((summary, _)) => {
            let setup = &log.setup;
            let per_rad = setup.counts_per_rev / std::f64::consts::TAU;
            let truth = setup.servo.b * if is_in_counts { per_rad } else { 1.0 };
            let of = summary.estimates.b;
            let error = 2.0 * of.std_error.unwrap_or(f64::INFINITY);
            let is_converged = summary.status() == Status::Converged;
            let end = match summary.status() {
                _ if matches!(summary.verdict.reason, VerdictReason::LongestDelay) => End::Refused,
                Status::NoInformation => End::Open,
                _ if error > 0.5 * of.value => End::Open,
                _ if (of.value - truth).abs() <= error.max(0.01 * truth) => {
                    End::Right(error / of.value)
                }
                _ => End::Wrong { is_converged },
            };
            let of = format!(
                "b {:.4} ± {:.4} of the truth",
                of.value / truth,
                error / truth
            );
            (of, end, summary.reason)
        }
    };
    let setup = &log.setup;
    let [sine, cosine] = setup.effects.gravity;
    let own = sine.hypot(cosine).sqrt();
    Judged {
        of: format!(
            "{number}: {}, {} turned {is_turned}, own {own:.2} rad/s, bandwidth {:.1}, {:?}, {} rows of {:.2} ms, range {:.2}; {of}",
            if setup.controller == Controller::Open {
                "open"
            } else {
                "loop"
            },
            if is_in_counts { "counts" } else { "rad" },
            setup.bandwidth,
            setup.reference,
            setup.samples,
            1e3 * setup.sample_time,
            log.range,
        ),
        end,
        reason,
    }
}

fn text(log: &RecordedLog, is_turned: bool, is_in_counts: bool) -> String {
    let mut text = match is_in_counts {
        true => "time_s,position,command\n".to_owned(),
        false => "time_s,position_rad,command\n".to_owned(),
    };
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
#[ignore = "campaign: minutes, LOGS=120 SEED=n"]
fn a_servo_under_gravity_is_right_or_open() {
    let [seed, logs] =
        [("SEED", 1), ("LOGS", 40)].map(|(of, usual)| environment(of).unwrap_or(usual));
    let numbers: Vec<u32> = (0..logs).collect();
    let all = in_parallel(&numbers, |&number| judged(seed, number));
    for of in &all {
        println!("{:?} {}; {}", of.end, of.of, of.reason);
    }
    let count = |is: fn(&End) -> bool| all.iter().filter(|of| is(&of.end)).count();
    let mut widths: Vec<f64> = (all.iter())
        .filter_map(|of| match of.end {
            End::Right(width) => Some(width),
            _ => None,
        })
        .collect();
    widths.sort_by(f64::total_cmp);
    println!(
        "{} right, half width {:.3}; {} open, {} refused, {} wrong, {} converged and wrong",
        widths.len(),
        widths.get(widths.len() / 2).unwrap_or(&f64::NAN),
        count(|end| *end == End::Open),
        count(|end| *end == End::Refused),
        count(|end| matches!(
            end,
            End::Wrong {
                is_converged: false
            }
        )),
        count(|end| matches!(end, End::Wrong { is_converged: true })),
    );
}
