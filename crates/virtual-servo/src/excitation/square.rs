use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::excitation::{Excitation, Hold};
use identifier_core::number::Number;
use identifier_core::units::Units;

/// A square wave between +amplitude and −amplitude, high first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square<N> {
    amplitude: N,
    half_period: u32,
}

/// Progress of a [`Square`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SquareState<N> {
    hold: Hold,
    level: N,
}

impl<N: Number> Square<N> {
    /// A square wave of an amplitude (rad) and a period (s, an even number of control samples).
    ///
    /// # Errors
    /// `amplitude` must be above 0, `period` an even number of control samples.
    pub fn new(units: &Units, amplitude: f64, period: f64) -> Result<Self, OutOfRange> {
        Allowed::Above(0.0).check("amplitude", amplitude)?;
        let half_period = Hold::steps("period", period, 2.0 * units.sample_time())?;
        Ok(Self {
            amplitude: N::from_f64(amplitude * units.position()),
            half_period,
        })
    }
}

impl<N: Number> Excitation<N> for Square<N> {
    type State = SquareState<N>;

    fn start(&self) -> SquareState<N> {
        SquareState {
            hold: Hold::EXPIRED,
            level: -self.amplitude,
        }
    }

    #[inline]
    fn process(&self, state: &mut SquareState<N>) -> N {
        if state.hold.expires(self.half_period) {
            state.level = -state.level;
        }
        state.level
    }
}
