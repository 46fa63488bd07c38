//! A page that changes while it is shown, served to the browsers of this machine alone.
//!
//! ```text
//! the maker of the page ─► Board ─► a thread for each browser: the page once, then what changes
//! ```

mod board;
mod request;
mod server;

pub use board::Update;
pub use server::Server;
