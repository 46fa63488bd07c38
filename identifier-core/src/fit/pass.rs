use super::autocorrelation::Autocorrelation;
use super::early::{EarlySums, EarlyTangent};
use super::gain::KalmanGain;
use super::statistics::Turns;
use crate::linalg::NormalEquations;
use crate::model::{ObserverModel, Tangents};
use crate::number::Number;

/// A pass over the record: the model, its tangents and their sums.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pass<N, const P: usize> {
    pub(super) gain: KalmanGain<N>,
    pub(super) model: ObserverModel<N>,
    pub(super) tangents: Tangents<N, P>,
    pub(super) equations: NormalEquations<N, P>,
    pub(super) early: EarlyTangent<N>,
    pub(super) sums: PassSums<N, P>,
    pub(super) turns: Turns<N>,
    /// The measured position, counts from where the record begins.
    pub(super) position: N,
}

/// The sums of a pass besides its equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PassSums<N, const P: usize> {
    pub(super) autocorrelation: Autocorrelation<N>,
    pub(super) speed_square: N,
    pub(super) acceleration_square: N,
    pub(super) early: EarlySums<N, P>,
}

impl<N: Number, const P: usize> Pass<N, P> {
    /// Before the first block: a model at the measured position.
    pub(super) fn at_first(gain: KalmanGain<N>, reversal: N) -> Self {
        Self {
            gain,
            model: ObserverModel::alongside(N::ZERO),
            tangents: Tangents::NONE,
            equations: NormalEquations::default(),
            early: EarlyTangent::NONE,
            sums: PassSums {
                autocorrelation: Autocorrelation::default(),
                speed_square: N::ZERO,
                acceleration_square: N::ZERO,
                early: EarlySums::NONE,
            },
            turns: Turns::beyond(reversal),
            position: N::ZERO,
        }
    }

    #[inline]
    pub(super) fn measure(&mut self, free: &[bool; P]) {
        self.gain.advance();
        let weight = self.gain.weight;
        let mut row = self.tangents.position;
        for (entry, &free) in row.iter_mut().zip(free) {
            *entry = if free { *entry * weight } else { N::ZERO };
        }
        let jump = self.gain.jump;
        if jump > N::ZERO {
            self.model.velocity += jump * self.model.error;
            for (velocity, &position) in
                (self.tangents.velocity.iter_mut()).zip(&self.tangents.position)
            {
                *velocity = *velocity - jump * position;
            }
            self.early.velocity = self.early.velocity - jump * self.early.position;
        }
        let error = self.model.error * weight;
        self.equations.add(&row, error);
        self.sums.autocorrelation.add(error);
        let early = self.early.position * weight;
        self.sums.early.add(early, error, &row);
    }
}
