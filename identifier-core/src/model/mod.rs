//! The servo (2), its exact step over a sample, and the model loop (5)–(7) with its regressor (9), driven
//! by the command that acted.

mod amplifier;
mod correction;
mod friction_step;
mod known_inputs;
mod model_loop;
mod observer_model;
mod tangents;
mod terms;
mod zero_order_hold_step;

pub(crate) use amplifier::{Amplifier, AmplifierState};
pub(crate) use correction::{CommandCorrection, Corrected, Correction};
pub(crate) use friction_step::{FrictionPhase, FrictionStep};
pub(crate) use known_inputs::{Acting, KnownInputs};
pub use known_inputs::{AngledInputs, DelayedInputs};
pub(crate) use model_loop::{ModelLoop, ModelState, Observed};
pub(crate) use observer_model::{Innovation, ModelStep, ObserverModel, SlidingStep};
pub(crate) use tangents::Tangents;
pub(crate) use terms::ModelValues;
pub(crate) use zero_order_hold_step::{Motion, Response, ZeroOrderHoldStep};
