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

pub use amplifier::{Amplifier, AmplifierState};
pub use correction::{
    AccelerationCorrection, CommandCorrection, Corrected, Correction, IntegralError,
};
pub use friction_step::{FrictionStep, Phase};
pub use known_inputs::{Acting, AngleSettings, AngledInputs, DelayedInputs, KnownInputs, NoInputs};
pub use model_loop::{ModelLoop, ModelState, Observed};
pub use observer_model::{Innovation, ModelStep, ObserverModel, SlidingStep};
pub use tangents::Tangents;
pub use terms::{ModelValues, TermValues};
pub use zero_order_hold_step::{Motion, Response, ZeroOrderHoldStep};
