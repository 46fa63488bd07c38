//! The playground's side in WebAssembly.
//!
//! The page writes a request into the buffer of `input` and calls a function of the module `page`, which exists only on
//! WebAssembly. The answer is a text and numbers in memory. A text is a line for each value: its name and its parts,
//! separated by tabs. Scenario, simulation, verdict, tuning and logs are those of the command line's library.

pub mod experiment;
pub mod log;
pub mod settings;

#[cfg(target_arch = "wasm32")]
pub mod page;
