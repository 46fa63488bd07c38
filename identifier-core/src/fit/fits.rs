use super::Prior;
use super::block::NumberedBlock;
use super::fit_result::FitResult;
use super::fitter::{Fit, Fitter};
use super::record::Record;
use crate::adaptation::IdentifiableSet;
use crate::model::{AngleSettings, KnownInputs};
use crate::number::Number;

/// A record of at most W blocks and the fits to it, one at a time: the background's share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fits<N, const W: usize, I = (), const P: usize = 4, const Q: usize = 6> {
    record: Record<N, I, W>,
    /// Blocks since the last fit began.
    fresh: usize,
    fit: Option<Fit<N, I, P, Q>>,
    /// The number of the block that follows the last.
    next: u32,
}

/// A fit that has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ended<N, const P: usize = 4> {
    /// Its result; none if the servo has not moved.
    pub(crate) result: Option<FitResult<N, P>>,
    /// The number of the last block that it used.
    pub(crate) last: u32,
    /// The record was full.
    pub(crate) full: bool,
}

impl<N, I, const W: usize, const P: usize, const Q: usize> Fits<N, W, I, P, Q>
where
    N: Number,
    I: KnownInputs<N>,
{
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
        self.begin_anew_at(&AngleSettings::NONE);
    }

    /// The same for models that depend on the angle.
    pub(crate) fn begin_anew_at(&mut self, angle: &AngleSettings<N>) {
        self.record.clear(angle);
        self.fresh = 0;
        self.fit = None;
    }

    /// Takes a block. One that is not the next begins the record anew: no fit spans a gap.
    pub(crate) fn take(&mut self, numbered: &NumberedBlock<N>) {
        self.take_at(&AngleSettings::NONE, numbered);
    }

    /// The same for models that depend on the angle.
    pub(crate) fn take_at(&mut self, angle: &AngleSettings<N>, numbered: &NumberedBlock<N>) {
        if numbered.number != self.next {
            self.begin_anew_at(angle);
        }
        self.next = numbered.number.wrapping_add(1);
        self.record.push(angle, &numbered.block);
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

    /// The distance travelled to and fro since the last fit began, counts.
    pub(crate) fn fresh_path(&self) -> N {
        self.record.path(self.fresh)
    }

    /// Sets the position of the first block.
    pub(crate) fn place(&mut self, angle: &AngleSettings<N>, position: N) {
        self.record.place(angle, position);
    }

    /// True if a fit is under way.
    pub(crate) fn is_under_way(&self) -> bool {
        self.fit.is_some()
    }

    /// Begins a fit to the record.
    pub(crate) fn begin<S>(&mut self, fitter: &Fitter<N, S, P, Q>, prior: Prior<N, P>)
    where
        S: IdentifiableSet<P, Inputs<N> = I>,
    {
        self.fresh = 0;
        self.record.hold();
        self.fit = Some(fitter.begin(self.record.len(), prior, *self.record.before()));
    }

    /// Continues the fit under way by at most `budget` blocks.
    pub(crate) fn advance<S>(
        &mut self,
        fitter: &Fitter<N, S, P, Q>,
        budget: u32,
    ) -> Option<Ended<N, P>>
    where
        S: IdentifiableSet<P, Inputs<N> = I>,
    {
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
