//! Progress of a verb and the time left, on standard error where that is a terminal.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::standard_output;

/// Time until progress is shown.
const SHOWN_AFTER: Duration = Duration::from_secs(2);

/// A line that shows how much is done. It goes when it is dropped.
#[derive(Debug)]
pub(super) struct Progress {
    bar: ProgressBar,
    begun: Instant,
    done: AtomicU64,
    /// So many are told together.
    together: u64,
    shown: AtomicBool,
}

impl Progress {
    /// Of so many of what takes long.
    pub(super) fn of(total: u64, what: &str) -> Self {
        Self::new(Some(total), what, 1)
    }

    /// Of samples, of which many are done in a moment.
    pub(super) fn of_samples(total: u64) -> Self {
        Self::new(Some(total), "samples", 4096)
    }

    /// Of samples of what ends when it has come to something.
    pub(super) fn of_a_course() -> Self {
        Self::new(None, "samples", 64)
    }

    fn new(total: Option<u64>, what: &str, together: u64) -> Self {
        let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::hidden());
        let line = match total {
            Some(_) => format!("{{bar:30}} {{human_pos}} of {{human_len}} {what}, {{eta}} left"),
            None => format!("{{spinner}} {{human_pos}} {what} in {{elapsed}}"),
        };
        if let Ok(style) = ProgressStyle::with_template(&line) {
            bar.set_style(style);
        }
        Self {
            bar,
            begun: Instant::now(),
            done: AtomicU64::new(0),
            together,
            // As if it had been.
            shown: AtomicBool::new(standard_output::is_quiet()),
        }
    }

    /// One more is done.
    pub(super) fn advance(&self) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        if !done.is_multiple_of(self.together) {
            return;
        }
        if self.begun.elapsed() > SHOWN_AFTER && !self.shown.swap(true, Ordering::Relaxed) {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.set_position(done);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
