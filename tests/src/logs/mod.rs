//! Logs of servos in closed loop with their truth known: servo, effects, controller, reference and encoder are
//! drawn, and the motion is that of the `virtual-servo`, which shares no code with the model under test. Controller
//! and references are written apart from the core, too.
//!
//! [`Draw`] is the loop of one log, as it is drawn from a seed; [`Draw::record`] runs it.

mod controller;
mod draw;
mod effect;
mod record;
mod reference;

pub use controller::Controller;
pub use draw::{Draw, LoadStep};
pub use effect::Effect;
pub use record::DrawnLog;
pub use reference::Reference;
