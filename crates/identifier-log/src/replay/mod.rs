//! The rows of logs on their way to a model, and the controller that is declared to have run.

mod agreement;
mod declared;
mod player;
mod scaled;
mod settling;

pub use agreement::Agreement;
pub(crate) use declared::DeclaredPid;
pub use player::{Beginning, InSegment, Input, Played, Player, Stopped};
pub use settling::settling_in_motion;
