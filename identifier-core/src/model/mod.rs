//! The servo model and the model loop (5)–(7) around it.

mod friction_step;
mod held_step;
mod listening_model;
mod model_loop;
mod servo;

pub use friction_step::{FrictionStep, Phase};
pub use held_step::{HeldStep, Motion, Response};
pub use listening_model::{Correction, ListeningModel, Tangents};
pub use model_loop::{ModelCommand, ModelLoop, ModelState};
pub use servo::ServoParameters;
