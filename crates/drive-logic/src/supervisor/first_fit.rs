//! Gauss–Newton's first fit, in the background while the interrupt keeps recording.

use drive_link::{Law, LoopSettings};
use identifier_core::identifier::{FitBlocks, GaussNewtonFitter};
use identifier_core::parameters::AbCoulombLoad;

use crate::channel::BackgroundEnd;
use crate::closed_loop::{BLOCKS, Fitted};

type Fitter = GaussNewtonFitter<f32, AbCoulombLoad, 4, BLOCKS>;

/// Blocks of the record that one turn of the background goes through.
const SLICE: u32 = 8;

/// The background's half of Gauss–Newton.
#[derive(Debug)]
pub(super) struct FirstFit {
    fitter: Fitter,
    state: <Fitter as FitBlocks<f32>>::State,
    /// A fit that found no room yet.
    fitted: Option<Fitted>,
}

impl FirstFit {
    /// For a run with these settings; none for a law that needs no fit.
    pub(super) fn for_run(settings: &LoopSettings) -> Option<Self> {
        if settings.law != Law::GaussNewton {
            return None;
        }
        let fitter: Fitter = settings.core.build().ok()?;
        Some(Self {
            state: fitter.start(),
            fitter,
            fitted: None,
        })
    }

    /// Takes in the blocks that were recorded and continues the fit, if there is one to make.
    pub(super) fn work(&mut self, channel: &mut BackgroundEnd<'_>) {
        while let Some(block) = channel.block() {
            self.fitter.take(&mut self.state, &block);
        }
        if self.fitted.is_none() {
            self.fitted = self.fitter.work(&mut self.state, SLICE);
        }
        if let Some(fitted) = self.fitted.take() {
            self.fitted = channel.fitted(fitted).err();
        }
    }
}
