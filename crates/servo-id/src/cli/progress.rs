//! Progress of a verb and the time left, on standard error where that is a terminal.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::standard_output;

/// Time until progress is shown.
const SHOWN_AFTER: Duration = Duration::from_secs(2);

/// A line that shows how much is done. It disappears when it is dropped.
#[derive(Debug)]
pub(super) struct Progress {
    bar: ProgressBar,
    begun: Instant,
    done: AtomicU64,
    /// Done between two updates of the line.
    update_interval: u64,
    shown: AtomicBool,
}

impl Progress {
    /// Of `total` items, each of which takes long.
    pub(super) fn of_items(total: u64, what: &str) -> Self {
        Self::new(Some(total), what, 1)
    }

    /// Of samples, many of which are done in a moment.
    pub(super) fn of_samples(total: u64) -> Self {
        Self::new(Some(total), "samples", 4096)
    }

    /// Of samples whose number is not known beforehand.
    pub(super) fn of_a_course() -> Self {
        Self::new(None, "samples", 64)
    }

    /// For a fit, whose number of steps is unknown beforehand.
    pub(super) fn of_a_search() -> Self {
        let what = "steps of the fit (Ctrl-C ends it with the estimates so far)";
        Self::new(None, what, 1)
    }

    fn new(total: Option<u64>, what: &str, update_interval: u64) -> Self {
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
            update_interval,
            // As if it had been.
            shown: AtomicBool::new(standard_output::is_quiet()),
        }
    }

    /// One more is done.
    pub(super) fn advance(&self) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        if !done.is_multiple_of(self.update_interval) {
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
