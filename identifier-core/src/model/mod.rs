//! The servo (2), its exact step over a sample, and the model loop (5)–(7) with its regressor (9). The command that
//! acted drives it.

mod amplifier;
mod correction;
mod friction_step;
pub(crate) mod identifiable_set;
pub(crate) mod known_inputs;
mod model_loop;
mod observer_model;
mod tangents;
mod terms;
mod zero_order_hold_step;

pub use amplifier::{Amplifier, AmplifierState};
pub(crate) use correction::CommandCorrection;
pub(crate) use friction_step::FrictionPhase;
pub use friction_step::FrictionStep;
pub(crate) use identifiable_set::IdentifiableSet;
pub(crate) use known_inputs::{Acting, KnownInputs};
pub(crate) use model_loop::{ModelLoop, ModelState, Observed};
pub(crate) use observer_model::{
    Innovation, ModelStep, MovingStep, ObserverModel, drive, stribeck_factor,
};
pub(crate) use tangents::{Tangents, sensitivity};
pub(crate) use terms::ModelValues;
pub use zero_order_hold_step::Motion;
pub(crate) use zero_order_hold_step::{Response, ZeroOrderHoldStep};
