use crate::arx::continuous;
use crate::recursion::{Recursion, RecursionConfig, RecursionState};
use crate::{DirectEstimator, LeastSquaresConfig};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::number::Number;
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::units::Units;

/// Recursive extended least squares of a discrete-time model, several steps a sample: the idea of
/// Zhou, Han, Yan and Chen, "A fast method for online closed loop system identification",
/// International Journal of Advanced Manufacturing Technology 31(1–2), 2006.
///
/// The increments of the position over a block of control samples, y, and the mean command over
/// it, ū, obey y_j = (1 − x) y_{j−1} + β₁ ū_j + β₂ ū_{j−1} + e_j + γ e_{j−1}. The noise e is not
/// measured; the extended recursion puts the a posteriori prediction error in its place. Each block it
/// takes [`MultiStepLeastSquares::STEPS`] steps over as many recent blocks, with the errors that the newest
/// estimates leave. The model is then mapped back: a = −ln(1 − x)/T_j,
/// b = (β₁ + β₂) a/(x T_j).
///
/// A loop of low gain moves slowly, so a block may be many control samples long; the mean command
/// stands for a held one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MultiStepLeastSquares<N> {
    recursion: Recursion<N, 4>,
    block: u32,
    mean: N,
    units: Units,
}

/// State of [`MultiStepLeastSquares`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MultiStepLeastSquaresState<N: Number> {
    command: N,
    count: u32,
    increment: N,
    commands: N,
    blocks: [Block<N>; MultiStepLeastSquares::<f64>::KEPT],
    filled: usize,
    recursion: RecursionState<N, 4>,
}

/// One block of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Block<N> {
    increment: N,
    command: N,
    error: N,
}

impl<N> MultiStepLeastSquares<N> {
    /// Steps a block.
    pub const STEPS: usize = 3;

    /// A step needs the block before its own.
    const KEPT: usize = Self::STEPS + 1;
}

impl<N: Number> MultiStepLeastSquares<N> {
    /// Standard deviations of the initial x/T_j, 1/s, of the gains, rad/s² per command unit, and of
    /// γ.
    const UNCERTAINTY: [f64; 4] = [100.0, 1000.0, 1000.0, 1.0];

    /// The recursion over blocks of `block` control samples; the forgetting factor of `config` is
    /// one of blocks, its cut-off is not used.
    ///
    /// # Errors
    /// The parameter out of its range, by name.
    pub fn new(units: &Units, block: u32, config: &LeastSquaresConfig) -> Result<Self, OutOfRange> {
        Allowed::AtLeast(1.0).check("block", f64::from(block))?;
        let sample_time = units.sample_time() * f64::from(block);
        let units = Units::new(sample_time, units.position_unit())?;
        let [x, gain] = [Parameter::A, Parameter::B].map(|parameter| parameter.scale(&units));
        let half = 0.5 * config.b * gain;
        Ok(Self {
            recursion: Recursion::new(&RecursionConfig {
                forgetting: config.forgetting,
                noise: units.acceleration(),
                initial: [-libm::expm1(-config.a * units.rate()), half, half, 0.0],
                uncertainty: [
                    Self::UNCERTAINTY[0] * x,
                    Self::UNCERTAINTY[1] * gain,
                    Self::UNCERTAINTY[2] * gain,
                    Self::UNCERTAINTY[3],
                ],
            })?,
            block,
            mean: N::from_f64(1.0 / f64::from(block)),
            units,
        })
    }

    fn end_block(&self, state: &mut MultiStepLeastSquaresState<N>) {
        state.blocks.rotate_right(1);
        state.blocks[0] = Block {
            increment: state.increment,
            command: state.commands * self.mean,
            error: N::ZERO,
        };
        state.filled = (state.filled + 1).min(state.blocks.len());
        // From the oldest to the newest, each with the error that the one before it leaves now.
        for newer in (0..state.filled.saturating_sub(1)).rev() {
            let before = state.blocks[newer + 1];
            let block = &mut state.blocks[newer];
            let regressor = [
                -before.increment,
                block.command,
                before.command,
                before.error,
            ];
            let change = block.increment - before.increment;
            self.recursion
                .update(&mut state.recursion, &regressor, change);
            block.error = change - Recursion::predict(&state.recursion, &regressor);
        }
    }
}

impl<N: Number> DirectEstimator<N> for MultiStepLeastSquares<N> {
    type State = MultiStepLeastSquaresState<N>;

    const PARAMETERS: &'static [Parameter] = &[Parameter::A, Parameter::B];

    fn start(&self) -> Self::State {
        MultiStepLeastSquaresState {
            command: N::ZERO,
            count: 0,
            increment: N::ZERO,
            commands: N::ZERO,
            blocks: [Block {
                increment: N::ZERO,
                command: N::ZERO,
                error: N::ZERO,
            }; MultiStepLeastSquares::<f64>::KEPT],
            filled: 0,
            recursion: self.recursion.start(),
        }
    }

    #[inline]
    fn process(&self, state: &mut Self::State, increment: N, command: N) {
        if !(increment.is_finite() && command.is_finite()) {
            return;
        }
        state.increment += increment;
        state.commands += state.command;
        state.command = command;
        state.count += 1;
        if state.count == self.block {
            self.end_block(state);
            state.count = 0;
            state.increment = N::ZERO;
            state.commands = N::ZERO;
        }
    }

    fn estimates(&self, state: &Self::State) -> Option<ServoParameters> {
        let [x, first, second, _] = Recursion::estimates(&state.recursion);
        continuous(x, first + second, &self.units)
    }
}
