//! The servo model and the model loop (5)–(7) around it.

mod held_step;
mod model_loop;
mod servo;

pub use held_step::{HeldStep, Motion};
pub use model_loop::{ModelLoop, ModelSample, ModelState};
pub use servo::ServoParameters;
