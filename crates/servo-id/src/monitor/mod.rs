//! A terminal view of a drive: its state, the drawing of it, and recordings.
//!
//! Data flows one way. The [`Link`] receives reports, [`State`] takes them in, [`draw`] shows them. A key becomes an
//! [`Action`] through a [`Dialogue`], and an action a command for the link.

mod dialogue;
mod frame;
mod history;
mod link;
mod recording;
mod state;
mod telemetry;
mod view;

pub use dialogue::{Action, Dialogue, Motion};
pub use frame::Frame;
pub use link::{Link, LinkError, LinkEvent};
pub use recording::{FrameRecording, Taken};
pub use state::{Note, State};
pub use telemetry::Telemetry;
pub use view::{MIN_SIZE, Shown, draw};
