//! The last seconds of a motion.

use std::collections::VecDeque;

use super::frame::Frame;

/// Length of the history, s.
pub(super) const LENGTH: f64 = 10.0;

/// A sample of the history.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    /// Since the motion began, s.
    pub(super) time: f64,
    pub(super) frame: Frame,
}

/// The last seconds of a motion.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct History(VecDeque<Point>);

/// The signals that are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Signal {
    Reference,
    Position,
    Command,
    OutputError,
}

impl History {
    /// Another motion begins.
    pub(super) fn begin(&mut self) {
        self.0.clear();
    }

    pub(super) fn add(&mut self, point: Point) {
        self.0.push_back(point);
        while self
            .0
            .front()
            .is_some_and(|first| first.time < point.time - LENGTH)
        {
            self.0.pop_front();
        }
    }

    /// The newest sample.
    pub(super) fn newest(&self) -> Option<&Point> {
        self.0.back()
    }

    /// A signal for the charts: time before the newest sample (s, not positive) and value.
    pub(super) fn signal(&self, signal: Signal) -> Vec<(f64, f64)> {
        let Some(newest) = self.newest() else {
            return Vec::new();
        };
        let value = |frame: &Frame| match signal {
            Signal::Reference => frame.reference(),
            Signal::Position => Some(frame.position()),
            Signal::Command => Some(frame.command().unwrap_or(0.0)),
            Signal::OutputError => frame.output_error(),
        };
        self.0
            .iter()
            .filter_map(|point| Some((point.time - newest.time, value(&point.frame)?)))
            .filter(|(_, value)| value.is_finite())
            .collect()
    }
}
