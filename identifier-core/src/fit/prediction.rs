use super::fitter::{Fit, FitStage, Fitter};
use super::record::Blocks;
use crate::model::IdentifiableSet;
use crate::number::Number;

impl<N, S, const P: usize> Fitter<N, S, P>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// Makes a fit that has not begun a prediction by these unknowns, machine units of a sample.
    pub fn begin_prediction(&self, fit: &mut Fit<N, P>, unknowns: &[N; P]) {
        fit.trial = core::array::from_fn(|i| unknowns[i] * self.scale[i]);
        fit.horizon = N::from_f64(Self::OPEN_LOOP_MEMORY);
        fit.stage = FitStage::End;
        self.begin_pass(fit);
    }

    /// Continues a prediction by one block of the record: the servo's position less the model's, counts, weighted so that its
    /// variance is that of the position's noise. None behind the last.
    pub fn predict(&self, fit: &mut Fit<N, P>, record: &impl Blocks<N>) -> Option<N> {
        let block = record.block(fit.next)?;
        self.model_block(fit, record, block);
        fit.next += 1;
        Some(fit.pass.model.error * fit.pass.gain.weight)
    }
}
