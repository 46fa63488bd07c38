//! What the verdict and the names of causes are worth, over many runs.

pub(crate) mod campaign;
mod effects;
mod honesty;
mod misdeclared;
mod naming;
