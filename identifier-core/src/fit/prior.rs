use crate::constants::{Encode, encode};
use crate::number::Number;

/// The configuration of a fitter, machine units of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FitterConfig<const P: usize = 4> {
    pub(crate) block: u32,
    pub(crate) noise: f64,
    pub(crate) low: [f64; P],
    pub(crate) high: [f64; P],
    pub(crate) initial: [Option<f64>; P],
    pub(crate) deviation: [Option<f64>; P],
    /// Unknowns that may be fitted; the others keep their initial value, or zero.
    pub(crate) free: [bool; P],
    pub(crate) bandwidth: Option<f64>,
    /// Standard deviation of the velocity before the first block, position units per sample. It is for a motion from
    /// rest that is short enough for an open-loop simulation. None for a servo that runs.
    pub(crate) at_first: Option<f64>,
}

/// The knowledge before a fit, units of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Prior<N, const P: usize> {
    /// Initial values: one more start; for a term, that it is fitted.
    pub(super) initial: [Option<N>; P],
    /// Reciprocal standard deviations of the initial values; zero without prior knowledge.
    pub(super) weight: [N; P],
}

encode! {
    [N: Encode, const P: usize] Prior<N, P> as "Prior" { initial, weight }
}

impl<N: Number, const P: usize> Prior<N, P> {
    /// The given initial values.
    pub(super) fn from_config(config: &FitterConfig<P>, scale: &[f64; P]) -> Self {
        Self {
            initial: core::array::from_fn(|i| {
                config.initial[i].map(|value| N::from_f64(value * scale[i]))
            }),
            weight: core::array::from_fn(|i| {
                N::from_f64(
                    config.deviation[i].map_or(0.0, |deviation| 1.0 / (deviation * scale[i])),
                )
            }),
        }
    }
}
