//! The playground's side in WebAssembly.
//!
//! The page writes a request into the buffer of `input` and calls a function of the module `page`, which is there on
//! WebAssembly alone; it answers with a text and numbers in memory. A text is a line for each value, its name and its parts
//! divided by tabs. Scenario, simulation, verdict, tuning and logs are those of the command line's library.

pub mod experiment;
pub mod log;
pub mod settings;

#[cfg(target_arch = "wasm32")]
pub mod page;
