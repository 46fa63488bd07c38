//! The servo model and the model loop (5)–(7) around it.

mod friction_step;
mod held_step;
mod model_loop;
mod sensitivity;
mod servo;

pub use friction_step::{FrictionStep, Phase};
pub use held_step::{HeldStep, Motion, Response};
pub use model_loop::{ModelCommand, ModelLoop, ModelState};
pub use sensitivity::Sensitivity;
pub use servo::ServoParameters;
