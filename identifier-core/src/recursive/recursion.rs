use super::law::GaussNewtonState;
use super::load_step::LoadStepDetector;
use crate::model::{IdentifiableSet, ObserverModel, Response, Tangents};
use crate::number::Number;
use crate::parameters::Terms;
use crate::unrolled::each;

/// The state of the half that runs every sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Recursion<N: Number, S: IdentifiableSet<P>, const P: usize> {
    pub(super) model: ObserverModel<N>,
    pub(super) tangents: Tangents<N, P>,
    pub(super) law: GaussNewtonState<N, S, P>,
    /// Commands given and angle measured.
    pub(super) inputs: S::Inputs<N>,
    pub(super) entered: Entered,
    /// That of the model's step; it changes when the estimates do.
    pub(super) response: Response<N>,
    /// ω T in normal operation.
    pub(super) omega: N,
    /// ω T that was measured or given.
    pub(super) measured: N,
    /// ω T of this sample.
    pub(super) correction_omega: N,
    /// The largest deviation of friction and load: the acceleration that the command gave in the
    /// record of the fit.
    pub(super) scale: N,
    /// Standard deviation of the noise in the settings over that of the position's, at most one. Errors are tested in
    /// units of the noise.
    pub(super) per_noise: N,
    pub(super) load_step_detector: LoadStepDetector<N>,
    /// Mean square of the blocks' output error over a second.
    pub(super) mean_square: N,
    /// b of the last fit, or the b that a new fit confirmed.
    pub(super) trusted_gain: N,
    /// The load before the steps of the present alarm.
    pub(super) trusted_load: N,
    pub(super) last_move: N,
    /// The distance that the servo moved while friction held the model.
    pub(super) moving: N,
    /// Samples for which friction has held the model.
    pub(super) samples_held: u16,
    /// Samples since the servo last moved; counted only where it matters, see
    /// [`Recursion::watch`].
    pub(super) samples_at_rest: u16,
    /// Grows with every step of the load and falls with time, blocks.
    pub(super) alarm: u16,
    /// Samples until the mode ends.
    pub(super) remaining: u16,
    /// Blocks since friction last stopped or turned the model.
    pub(super) blocks_in_motion: u8,
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
    /// Before there is a model.
    pub(super) fn new(
        law: GaussNewtonState<N, S, P>,
        inputs: S::Inputs<N>,
        entered: Entered,
        response: Response<N>,
        load_step_detector: LoadStepDetector<N>,
    ) -> Self {
        Self {
            model: ObserverModel::alongside(N::ZERO),
            tangents: Tangents::NONE,
            law,
            inputs,
            entered,
            response,
            omega: N::ZERO,
            measured: N::ZERO,
            correction_omega: N::ZERO,
            scale: N::ZERO,
            per_noise: N::ONE,
            load_step_detector,
            mean_square: N::ZERO,
            trusted_gain: N::ZERO,
            trusted_load: N::ZERO,
            last_move: N::ZERO,
            moving: N::ZERO,
            samples_held: 0,
            samples_at_rest: 0,
            alarm: 0,
            remaining: 0,
            blocks_in_motion: 0,
            mode: Mode::Recording,
            lacking: false,
            ambiguous: false,
        }
    }

    /// Moves the model with the estimates.
    #[inline]
    pub(super) fn follow(&mut self, steps: &[N; P]) {
        each::<P>(|i| {
            self.model.error = self.model.error - self.tangents.position[i] * steps[i];
            self.model.velocity += self.tangents.velocity[i] * steps[i];
        });
    }

    /// Counts the samples for which the servo has not moved. A single count back over the edge that
    /// was just crossed is no motion. It is not counted while model and servo move.
    pub(super) fn watch(&mut self, increment: N) {
        let back = increment == -self.last_move && increment.magnitude() <= N::ONE;
        if increment == N::ZERO || back {
            self.samples_at_rest = self.samples_at_rest.saturating_add(1);
        } else {
            self.samples_at_rest = 0;
        }
        if increment != N::ZERO {
            self.last_move = increment;
        }
    }

    /// Friction does not hold the model against the servo.
    #[inline]
    pub(super) fn clear_hold(&mut self) {
        self.samples_held = 0;
        self.moving = N::ZERO;
    }

    /// Counts a sample of the mode; whether it was the last.
    pub(super) fn is_over(&mut self) -> bool {
        self.remaining = self.remaining.saturating_sub(1);
        self.remaining == 0
    }

    /// The correction after `narrowing`, the growth of 1/ω.
    #[inline]
    pub(super) fn narrowed(&self, narrowing: N) -> N {
        let narrower =
            self.correction_omega - self.correction_omega * self.correction_omega * narrowing;
        if narrower > self.omega {
            narrower
        } else {
            self.omega
        }
    }
}

/// The terms that have entered, and the blocks in which the model has moved since the last of them.
///
/// Only motion in both directions distinguishes a term from the parameters. One term is distinguished from another only
/// while it is estimated. So they enter one after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entered {
    pub(super) terms: Terms,
    pub(super) forwards: u16,
    pub(super) backwards: u16,
}

impl Entered {
    /// No term, and no motion.
    pub(super) const NONE: Self = Self::with(Terms::NONE);

    pub(super) const fn with(terms: Terms) -> Self {
        Self {
            terms,
            forwards: 0,
            backwards: 0,
        }
    }
}
