use super::super::fit::{Blocking, Fit, Fitter, Found, Record};
use super::super::identify::Event;
use crate::number::Number;

/// The start of a recursion: the record, and the fit that the background makes of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start<N: Number, const W: usize> {
    record: Record<N, W>,
    /// Blocks since the last fit began.
    fresh: usize,
    fit: Option<Fit<N>>,
    found: Option<Found<N>>,
    /// What the fit that the recursion goes on from left unexplained.
    usual: N,
    failures: u32,
    unexplained: bool,
    recording: bool,
}

impl<N: Number, const W: usize> Start<N, W> {
    pub(super) fn new() -> Self {
        Self {
            record: Record::empty(),
            fresh: 0,
            fit: None,
            found: None,
            usual: N::ZERO,
            failures: 0,
            unexplained: false,
            recording: true,
        }
    }

    /// Begins anew to record.
    pub(super) fn clear(&mut self) {
        *self = Self {
            usual: self.usual,
            ..Self::new()
        };
    }

    /// Whether a fit leaves less than half of what the last left.
    pub(super) fn is_better(&self, found: &Found<N>) -> bool {
        found.unexplained + found.unexplained < self.usual
    }

    /// The recursion goes on from a fit.
    pub(super) fn go_on(&mut self, found: &Found<N>) {
        self.usual = found.unexplained;
        self.stop();
    }

    /// Ends the recording.
    pub(super) fn stop(&mut self) {
        self.record.clear();
        self.fresh = 0;
        self.failures = 0;
        self.recording = false;
    }

    pub(super) fn is_recording(&self) -> bool {
        self.recording
    }

    #[inline]
    pub(super) fn record(&mut self, blocking: &Blocking<N>, increment: N, command: N) -> Event {
        if self.record.push(blocking, increment, command) {
            self.fresh += 1;
        }
        if core::mem::take(&mut self.unexplained) {
            Event::NotFollowing
        } else {
            Event::None
        }
    }

    pub(super) fn take_found(&mut self) -> Option<Found<N>> {
        self.found.take()
    }

    pub(super) fn velocity(&self, blocking: &Blocking<N>) -> N {
        self.record.velocity(blocking)
    }

    pub(super) fn work(&mut self, fitter: &Fitter<N>, budget: u32) {
        if self.found.is_some() {
            return;
        }
        if self.fit.is_none() {
            let blocks = self.record.len();
            if blocks < W / 2 || self.fresh < W / 4 {
                return;
            }
            self.fresh = 0;
            self.record.hold();
            self.fit = Some(fitter.begin(blocks, fitter.given()));
        }
        let Some(fit) = &mut self.fit else { return };
        for _ in 0..budget {
            if let Some(result) = fitter.work(fit, &self.record) {
                self.fit = None;
                self.record.release();
                self.judge(result);
                return;
            }
        }
    }

    fn judge(&mut self, result: Option<Found<N>>) {
        let full = self.record.is_full();
        // A motion to and fro is worth waiting for: it tells friction from load.
        let good = result.filter(|found| {
            if full {
                found.is_good(0.2)
            } else {
                found.is_good(0.03) && found.only_direction == N::ZERO
            }
        });
        if good.is_some() {
            self.found = good;
        } else if full {
            self.failures = self.failures.saturating_add(1);
            self.unexplained = self.failures % 4 == 2;
        }
    }
}
