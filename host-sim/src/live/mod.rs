//! A page that changes while somebody looks at it: served to browsers of this machine, and to no other.
//!
//! ```text
//! whoever makes the page ─► Board ─► a thread for each browser: the page once, then what changes
//! ```

mod board;
mod request;
mod server;

pub use board::Update;
pub use server::Server;
