use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::excitation::{Excitation, Hold};
use identifier_core::number::Number;
use identifier_core::units::Units;

/// A staircase: up to M levels in turn, each held for the same time, then from the first again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steps<N, const M: usize> {
    levels: [N; M],
    used: usize,
    hold: u32,
}

/// Progress of a [`Steps`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepsState {
    hold: Hold,
    next: usize,
}

impl<N: Number, const M: usize> Steps<N, M> {
    /// The staircase of the given levels (rad), 1 to M of them. Each is held for a time (s, a whole number of control
    /// samples).
    ///
    /// # Errors
    /// `levels`: their number, or a level that is not finite; `hold`: no whole number of samples.
    pub fn new(units: &Units, levels: &[f64], hold: f64) -> Result<Self, OutOfRange> {
        Allowed::Within(1.0, M as f64).check("levels", levels.len() as f64)?;
        let mut steps = Self {
            levels: [N::ZERO; M],
            used: levels.len(),
            hold: Hold::steps("hold", hold, units.sample_time())?,
        };
        for (slot, &level) in steps.levels.iter_mut().zip(levels) {
            *slot = N::from_f64(Allowed::Finite.check("levels", level)? * units.position());
        }
        Ok(steps)
    }
}

impl<N: Number, const M: usize> Excitation<N> for Steps<N, M> {
    type State = StepsState;

    fn start(&self) -> StepsState {
        StepsState {
            hold: Hold::EXPIRED,
            next: 0,
        }
    }

    #[inline]
    fn process(&self, state: &mut StepsState) -> N {
        if state.hold.expires(self.hold) {
            state.next = if state.next >= self.used {
                1
            } else {
                state.next + 1
            };
        }
        self.levels
            .get(state.next.wrapping_sub(1))
            .copied()
            .unwrap_or(N::ZERO)
    }
}
