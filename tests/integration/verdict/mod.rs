//! What the verdict and the names of causes are worth, over many runs.

mod campaign;
mod honesty;
mod naming;
