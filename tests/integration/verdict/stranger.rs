//! What becomes of a log that is identified by one who states nothing.

use identifier_log::identify;
use identifier_log::log::{Log, Table};
use identifier_log::recognise::{LogOptions, recognise};
use identifier_log::result::{Reading, Summary};
use identifier_log::verdict::{Status, VerdictReason};
use integration_tests::{environment, in_parallel};

/// Identifies the text of a log as one does who states nothing.
///
/// # Errors
/// The question, or the refusal.
pub(super) fn as_a_stranger(text: String) -> Result<(Summary, Reading), String> {
    let read = Table::of_text("log.csv".as_ref(), std::io::Cursor::new(text));
    let table = read.map_err(|error| error.to_string())?;
    let recognised =
        recognise(&table, &LogOptions::default()).map_err(|error| error.to_string())?;
    let options = recognised.options().map_err(|error| error.to_string())?;
    let log = Log::new(&table, &options.log_columns(), options.log_sample_time());
    let log = log.map_err(|error| error.to_string())?;
    let found = identify(&[log], &[], &options, &|| true).map_err(|error| error.to_string())?;
    Ok((found.summary, recognised.reading))
}

/// What became of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum End {
    /// b is within its interval, whose half width is a part of it.
    Right { width: f64, is_converged: bool },
    /// b is outside of it.
    Wrong { is_converged: bool },
    /// No b.
    Open,
    /// The log is said to be at odds with itself.
    Refused,
}

/// What became of the text of a log whose servo has a gain, and the result in words.
pub(super) fn judged(text: String, gain: f64) -> (End, String) {
    /// The half width beyond which b is open, and the least that matters, part of it.
    const OPEN: f64 = 0.5;
    const LEAST: f64 = 0.01;
    let summary = match as_a_stranger(text) {
        Ok((summary, _)) => summary,
        Err(asked) => return (End::Refused, asked),
    };
    let b = summary.estimates.b;
    let width = 2.0 * b.std_error.unwrap_or(f64::INFINITY);
    let is_converged = summary.status() == Status::Converged;
    let is_odd = matches!(summary.verdict.reason, VerdictReason::LongestDelay);
    let end = match summary.status() {
        _ if is_odd => End::Refused,
        Status::NoInformation => End::Open,
        _ if width > OPEN * b.value => End::Open,
        _ if (b.value - gain).abs() <= width.max(LEAST * gain) => End::Right {
            width: width / b.value,
            is_converged,
        },
        _ => End::Wrong { is_converged },
    };
    let [value, width] = [b.value, width].map(|of| of / gain);
    (
        end,
        format!("b {value:.4} ± {width:.4} of the truth; {}", summary.reason),
    )
}

/// Judges the logs of a campaign on demand: `SEED=7 LOGS=100`.
pub(super) fn campaign(usual: u32, judged: impl Fn(u32, u32) -> (End, String) + Sync) {
    let [seed, logs] =
        [("SEED", 1), ("LOGS", usual)].map(|(of, usual)| environment(of).unwrap_or(usual));
    ends(seed, logs, judged);
}

/// Asserts that of some logs of a seed none converges wrongly, and as many are right as ever.
pub(super) fn assert_right(
    [seed, logs, least]: [u32; 3],
    judged: impl Fn(u32, u32) -> (End, String) + Sync,
) {
    let ends = ends(seed, logs, judged);
    let right = ends.iter().filter(|end| matches!(end, End::Right { .. }));
    let right = right.count() as u32;
    assert!(right >= least, "{right} of {logs} are right");
    assert!(!ends.contains(&End::Wrong { is_converged: true }));
}

/// The ends of the logs of a seed, which are printed with their counts.
fn ends(seed: u32, logs: u32, judged: impl Fn(u32, u32) -> (End, String) + Sync) -> Vec<End> {
    let numbers: Vec<u32> = (0..logs).collect();
    let all = in_parallel(&numbers, |&number| judged(seed, number));
    for (number, (end, words)) in all.iter().enumerate() {
        println!("{end:?} {number}: {words}");
    }
    let ends: Vec<End> = all.into_iter().map(|(end, _)| end).collect();
    let count = |is: fn(&End) -> bool| ends.iter().filter(|end| is(end)).count();
    let widths = ends.iter().filter_map(|end| match end {
        End::Right { width, .. } => Some(*width),
        _ => None,
    });
    let mut widths: Vec<f64> = widths.collect();
    widths.sort_by(f64::total_cmp);
    println!(
        "{logs} logs of seed {seed}: {} right ({} converged), half width {:.4}; {} open, {} refused, {} wrong, {} converged and wrong",
        widths.len(),
        count(|end| matches!(
            end,
            End::Right {
                is_converged: true,
                ..
            }
        )),
        widths.get(widths.len() / 2).unwrap_or(&f64::NAN),
        count(|end| *end == End::Open),
        count(|end| *end == End::Refused),
        count(|end| *end
            == End::Wrong {
                is_converged: false
            }),
        count(|end| *end == End::Wrong { is_converged: true }),
    );
    ends
}
