//! A terminal view of a drive: what is known of it, how that is drawn, and what is recorded.
//!
//! Data goes one way: the [`Link`] hears reports, [`State`] takes them in, [`draw`] shows them; a key
//! becomes an [`Action`] through a [`Dialogue`], and an action an order for the link.

mod dialogue;
mod frame;
mod history;
mod link;
mod listening;
mod recording;
mod state;
mod telemetry;
mod view;

pub use dialogue::{Action, Dialogue, Motion};
pub use frame::{Frame, Kind};
pub use link::{AtEnd, Ending, Heard, Link, LinkError};
pub use recording::{Recording, Taken};
pub use state::{Note, State};
pub use telemetry::Telemetry;
pub use view::{LEAST, Shown, draw};
