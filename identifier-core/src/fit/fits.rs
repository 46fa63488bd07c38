use super::block::NumberedBlock;
use super::fit_result::FitResult;
use super::fitter::{Fit, Fitter};
use super::record::Record;
use super::wait::FirstFitWait;
use crate::number::Number;
use crate::reason::Reason;

/// A record of at most W blocks and the fits to it, one at a time: the background's share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fits<N, const W: usize> {
    record: Record<N, W>,
    /// Blocks since the last fit began.
    fresh: usize,
    fit: Option<Fit<N, (), 4>>,
    /// The number of the block that follows the last.
    next: u32,
    wait: FirstFitWait,
}

/// A fit that has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ended<N> {
    /// Its result; none if the servo has not moved.
    pub(crate) result: Option<FitResult<N>>,
    /// The number of the last block that it used.
    pub(crate) last: u32,
    /// The record was full.
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
            wait: FirstFitWait::START,
        }
    }

    /// Blocks in the record.
    pub(crate) fn blocks(&self) -> usize {
        self.record.len()
    }

    /// Blocks since the last fit began.
    pub(crate) fn fresh(&self) -> usize {
        self.fresh
    }

    /// True if a fit is in progress.
    pub(crate) fn is_under_way(&self) -> bool {
        self.fit.is_some()
    }

    /// A first fit has succeeded.
    pub(crate) fn end_wait(&mut self) {
        self.wait.end();
    }
}

impl<N: Number> Fitter<N> {
    /// Forgets the record, and the fit in progress.
    pub(crate) fn begin_anew<const W: usize>(&self, fits: &mut Fits<N, W>) {
        fits.record.clear();
        fits.fresh = 0;
        fits.fit = None;
    }

    /// Takes a block. One that is not the next begins the record anew: no fit spans a gap.
    pub(crate) fn take<const W: usize>(&self, fits: &mut Fits<N, W>, numbered: &NumberedBlock<N>) {
        fits.wait.take(self.patience, numbered);
        if numbered.number != fits.next {
            self.begin_anew(fits);
        }
        fits.next = numbered.number.wrapping_add(1);
        fits.record.push(&numbered.block);
        fits.fresh += 1;
    }

    /// Begins a fit to the record.
    pub(crate) fn begin<const W: usize>(&self, fits: &mut Fits<N, W>) {
        fits.fresh = 0;
        fits.record.hold();
        fits.fit = Some(self.begin_fit(fits.record.len()));
    }

    /// Continues the fit in progress by at most `budget` blocks.
    pub(crate) fn advance<const W: usize>(
        &self,
        fits: &mut Fits<N, W>,
        budget: u32,
    ) -> Option<Ended<N>> {
        let fit = fits.fit.as_mut()?;
        let result = (0..budget).find_map(|_| self.work(fit, &fits.record))?;
        fits.fit = None;
        fits.record.release();
        Some(Ended {
            result,
            last: fits.next.wrapping_sub(1),
            full: fits.record.is_full(),
        })
    }

    /// Takes in that no servo could be taken from a result. True if the record was full, a first fit is overdue and the
    /// reason is new.
    pub(crate) fn object<const W: usize>(&self, fits: &mut Fits<N, W>, ended: &Ended<N>) -> bool {
        let reason = ended
            .result
            .map_or(Reason::TooLittleMotion, |result| result.rejection_reason());
        ended.full && fits.wait.object(self.patience, reason)
    }

    /// Why there is no first fit, once it is overdue.
    pub(crate) fn rejection_reason<const W: usize>(&self, fits: &Fits<N, W>) -> Option<Reason> {
        fits.wait.reason(self.patience)
    }
}
