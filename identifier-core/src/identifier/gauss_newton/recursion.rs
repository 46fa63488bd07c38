use super::load_step::Suspicion;
use crate::adaptation::{GaussNewtonState, IdentifiableSet};
use crate::model::{ObserverModel, Response, Tangents};
use crate::number::Number;

/// The state of the half that runs every sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Recursion<N: Number, S: IdentifiableSet<P>, const P: usize> {
    pub(super) model: ObserverModel<N>,
    pub(super) tangents: Tangents<N, P>,
    pub(super) law: GaussNewtonState<N, S, P>,
    /// Commands given and angle measured.
    pub(super) inputs: S::Inputs<N>,
    /// Which terms have entered.
    pub(super) evidence: S::Evidence<N>,
    /// That of the model's step; it changes when the estimates do.
    pub(super) response: Response<N>,
    /// ω T in normal operation.
    pub(super) omega: N,
    /// ω T that was measured or given.
    pub(super) measured: N,
    /// ω T of this sample.
    pub(super) quick: N,
    /// The largest deviation of friction and load: the acceleration that the command gave in the
    /// record of the fit.
    pub(super) scale: N,
    pub(super) suspicion: Suspicion<N>,
    /// Mean square of the blocks' output error over a second.
    pub(super) mean_square: N,
    /// b of the last fit, or what a new fit confirmed.
    pub(super) trusted_gain: N,
    /// The load before the steps of the present alarm.
    pub(super) trusted_load: N,
    pub(super) last_move: N,
    /// The distance that the servo moved while friction held the model.
    pub(super) slid: N,
    /// Samples for which friction has held the model.
    pub(super) held: u16,
    /// Samples since the servo last moved; counted only where it matters, see
    /// [`Recursion::watch`].
    pub(super) still: u16,
    /// Grows with every step of the load and falls with time, blocks.
    pub(super) alarm: u16,
    /// Samples until the mode ends.
    pub(super) left: u16,
    /// Blocks since friction last stopped or turned the model.
    pub(super) straight: u8,
    pub(super) mode: Mode,
    /// A new fit was no better: the model lacks an effect of the servo.
    pub(super) lacking: bool,
    /// The deviation that is taken for the load may be friction as well.
    pub(super) ambiguous: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// There is no model yet.
    Recording,
    /// The model joins the servo's motion for a set time; nothing is learnt.
    Joining,
    /// The load is estimated anew for a set time.
    Searching,
    /// Everything is learnt.
    Learning,
    /// The servo does not follow the command; nothing is learnt for a set time.
    Waiting,
}

impl<N: Number, S: IdentifiableSet<P>, const P: usize> Recursion<N, S, P> {
    /// Moves the model with the estimates.
    #[inline]
    pub(super) fn follow(&mut self, steps: &[N; P]) {
        for i in 0..P {
            self.model.error = self.model.error - self.tangents.position[i] * steps[i];
            self.model.velocity += self.tangents.velocity[i] * steps[i];
        }
    }

    /// Counts the samples for which the servo has not moved. A single count back over the edge that
    /// was just crossed is no motion. It is not counted while model and servo move.
    pub(super) fn watch(&mut self, increment: N) {
        let back = increment == -self.last_move && increment.magnitude() <= N::ONE;
        if increment == N::ZERO || back {
            self.still = self.still.saturating_add(1);
        } else {
            self.still = 0;
        }
        if increment != N::ZERO {
            self.last_move = increment;
        }
    }

    /// Friction does not hold the model against the servo.
    #[inline]
    pub(super) fn move_on(&mut self) {
        self.held = 0;
        self.slid = N::ZERO;
    }

    /// Counts a sample of the mode; whether it was the last.
    pub(super) fn is_over(&mut self) -> bool {
        self.left = self.left.saturating_sub(1);
        self.left == 0
    }

    /// The correction after `narrowing`, the growth of 1/ω.
    #[inline]
    pub(super) fn narrowed(&self, narrowing: N) -> N {
        let narrower = self.quick - self.quick * self.quick * narrowing;
        if narrower > self.omega {
            narrower
        } else {
            self.omega
        }
    }
}
