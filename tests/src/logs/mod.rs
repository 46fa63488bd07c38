//! Logs of servos in closed loop with their truth known: servo, effects, controller, reference and encoder are
//! drawn, and the motion is that of the `virtual-servo`, which shares no code with the model under test. Controller
//! and references are written apart from the core, too.
//!
//! [`drawn`] is the log of a number in a campaign. Its [`LoopSetup`] may be changed and [recorded](LoopSetup::record)
//! again.

mod controller;
mod draw;
mod effect;
mod record;
mod reference;
mod setup;

pub use controller::Controller;
pub use draw::{Masses, drawn, drawn_with, exact, two_masses, under_gravity, with_cogging};
pub use effect::Effect;
pub use record::RecordedLog;
pub use reference::Reference;
pub use setup::{LoadStep, LoopSetup};
