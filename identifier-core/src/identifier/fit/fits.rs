use super::block::NumberedBlock;
use super::fit_result::FitResult;
use super::fitter::{Fit, Fitter, Prior};
use super::record::Record;
use crate::number::Number;

/// A record of at most W blocks and the fits to it, one at a time: the background's share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fits<N, const W: usize> {
    record: Record<N, W>,
    /// Blocks since the last fit began.
    fresh: usize,
    fit: Option<Fit<N>>,
    /// The number of the block that follows the last.
    next: u32,
}

/// A fit that has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ended<N> {
    /// Its result; none if the servo has not moved.
    pub(crate) result: Option<FitResult<N>>,
    /// The number of the last block that it used.
    pub(crate) last: u32,
    /// Whether the record was full.
    pub(crate) full: bool,
}

impl<N: Number, const W: usize> Fits<N, W> {
    /// No block yet.
    pub(crate) fn none() -> Self {
        Self {
            record: Record::empty(),
            fresh: 0,
            fit: None,
            next: 0,
        }
    }

    /// Forgets the record, and the fit under way.
    pub(crate) fn begin_anew(&mut self) {
        self.record.clear();
        self.fresh = 0;
        self.fit = None;
    }

    /// Whether a block is the one that comes next.
    pub(crate) fn is_next(&self, numbered: &NumberedBlock<N>) -> bool {
        numbered.number == self.next
    }

    /// Takes a block. One that is not the next begins the record anew: no fit spans a gap.
    pub(crate) fn take(&mut self, numbered: &NumberedBlock<N>) {
        if !self.is_next(numbered) {
            self.begin_anew();
        }
        self.next = numbered.number.wrapping_add(1);
        self.record.push(&numbered.block);
        self.fresh += 1;
    }

    /// Blocks in the record.
    pub(crate) fn blocks(&self) -> usize {
        self.record.len()
    }

    /// Blocks since the last fit began.
    pub(crate) fn fresh(&self) -> usize {
        self.fresh
    }

    /// Whether a fit is under way.
    pub(crate) fn is_under_way(&self) -> bool {
        self.fit.is_some()
    }

    /// Begins a fit to the record.
    pub(crate) fn begin(&mut self, fitter: &Fitter<N>, prior: Prior<N>) {
        self.fresh = 0;
        self.record.hold();
        self.fit = Some(fitter.begin(self.record.len(), prior));
    }

    /// Goes on with the fit under way by at most `budget` blocks.
    pub(crate) fn go_on(&mut self, fitter: &Fitter<N>, budget: u32) -> Option<Ended<N>> {
        let fit = self.fit.as_mut()?;
        let result = (0..budget).find_map(|_| fitter.work(fit, &self.record))?;
        self.fit = None;
        self.record.release();
        Some(Ended {
            result,
            last: self.next.wrapping_sub(1),
            full: self.record.is_full(),
        })
    }
}
